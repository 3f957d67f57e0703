"""No feedback: the command comes from a recorded or generated input."""

from typing import Annotated, NamedTuple

from controllers.interface import Controller, Reference
from plants.equation import Scalar, equation
from plants.interface import Measurement


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


OPEN_LOOP = Controller(
    name="open_loop",
    summary="no feedback: a recorded or generated command",
    Gains=Gains,
    State=State,
    step=step,
    commit=commit,
    start=start,
)
