"""No feedback: the command comes from a recorded or generated input."""

from typing import Annotated, NamedTuple

from controllers.interface import Controller, Reference
from controllers.settings import ANY, About
from plants.equation import Scalar, equation
from plants.interface import Measurement


class Settings(NamedTuple):
    """Which input of the plant the reference goes to (default: its command), and how it goes on between samples."""

    input: Annotated[str, ANY, About("which input of the plant the reference goes to; its command if not set")] = ""
    hold: Annotated[str, "linear", "zero", About("how it goes on between samples")] = "linear"


class Gains(NamedTuple):
    bias: Annotated[float, "command"]


class State(NamedTuple):
    command: Annotated[float, "command"]


@equation
def step(
    reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
) -> tuple[Scalar, State]:
    """The constant `bias`, whatever is measured."""
    return gains.bias, state


@equation
def commit(realised: Scalar, state: State, gains: Gains, sample_time: Scalar) -> State:
    """Keeps what was realised."""
    return State(realised)


def start(measurement: Measurement, gains: Gains) -> State:
    """Nothing yet."""
    return State(0.0)


def design(settings: Settings, belief: object, sample_time: float) -> Gains:
    """No bias: the reference is fed to the plant's input."""
    return Gains(0.0)


SUMMARY = "no feedback: a recorded or generated command"

OPEN_LOOP = Controller("open_loop", SUMMARY, Settings, Gains, State, design, step, commit, start)
