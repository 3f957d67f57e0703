"""What a controller is: two equations, one that computes a command and one that learns what became of it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple, TypeAlias, TypeVar

from plants.equation import Scalar
from plants.interface import Measurement

StateT = TypeVar("StateT")
GainsT = TypeVar("GainsT")


class Reference(NamedTuple):
    """What is wanted at one instant, with exact derivatives; for a rotary controller a speed in rad/s."""

    position: Annotated[float, "m"]
    velocity: Annotated[float, "m/s"]
    acceleration: Annotated[float, "m/s^2"]


Step: TypeAlias = Callable[[Reference, Measurement, StateT, GainsT, Scalar], tuple[Scalar, StateT]]
"""The equation of a controller with that state and these gains: see `Controller`."""


@dataclass(frozen=True, eq=False)
class Controller:
    """A sampled controller: names and units (as NamedTuple classes) and the equations over them.

    step(reference, measurement, state, gains, sample_time) -> (command, state)     at every sample instant
    commit(realised, state, gains, sample_time) -> state                            then, with the command that
                                                                                    the amplifier really gave
    start(measurement, gains) -> state                                              for a plant at rest
    design(settings, belief, sample_time) -> gains                                  once, before the run
    choose(settings, belief) -> Controller                                          which of a family the settings mean
    forcing(gains) -> frequency (Hz)                                                at which it shakes the plant on
                                                                                    purpose; what answers is no limit
                                                                                    cycle

    `Settings` is what a user writes: a NamedTuple of `Annotated[float, unit]` (the unit may name the plant's
    `command`) and `Annotated[str, choice, choice, ...]`, with defaults; `controllers.settings` says what may stand
    behind these. `unused` are those of them that this controller has no use for: several may share one class.
    `belief` is what the controller believes of the plant: an object of the plant's parameter class, never the truth.
    `gauge`: it is given the reading of the hypothetical friction gauge (`plants.friction_gauge`), which for every
    other controller is NaN. `design` raises ValueError where settings or belief do not serve.
    """

    name: str
    summary: str
    Settings: type
    Gains: type
    State: type
    design: Callable[..., Any]
    step: Callable[..., Any]
    commit: Callable[..., Any]
    start: Callable[..., Any]
    choose: Callable[..., "Controller"] | None = None
    forcing: Callable[..., float] | None = None
    unused: frozenset[str] = frozenset()
    gauge: bool = False
