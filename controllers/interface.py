"""What a controller is: two equations, one that computes a command and one that learns what became of it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from numba import types

from plants.equation import POINTER, caller, compiled, fingerprint, pack, unpack
from plants.interface import Measurement


class Reference(NamedTuple):
    """What is wanted at one instant, with exact derivatives; for a rotary controller a speed in rad/s."""

    position: Annotated[float, "m"]
    velocity: Annotated[float, "m/s"]
    acceleration: Annotated[float, "m/s^2"]


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


STEP = types.float64(POINTER, POINTER, POINTER, POINTER, types.float64)
"""C signature: reference, measurement, state (in and out), gains, sample time -> command."""

COMMIT = types.void(types.float64, POINTER, POINTER, types.float64)
"""C signature: realised command, state (in and out), gains, sample time."""

call_step, call_commit = caller(STEP), caller(COMMIT)


def compile_step(controller: Controller) -> Any:
    """The controller's step as a C function of signature `STEP`."""
    step, state_class, gains_class = controller.step, controller.State, controller.Gains
    reference_class, measurement_class = Reference, Measurement
    source = fingerprint(step)

    @compiled(STEP)
    def entry(reference: Any, measurement: Any, state: Any, gains: Any, sample_time: float) -> float:
        _ = source  # part of the key of the compiled code's cache
        r, y = unpack(reference_class, reference), unpack(measurement_class, measurement)
        command, following = step(r, y, unpack(state_class, state), unpack(gains_class, gains), sample_time)
        pack(following, state)
        return command

    return entry


def compile_commit(controller: Controller) -> Any:
    """The controller's commit as a C function of signature `COMMIT`."""
    commit, state_class, gains_class = controller.commit, controller.State, controller.Gains
    source = fingerprint(commit)

    @compiled(COMMIT)
    def entry(realised: float, state: Any, gains: Any, sample_time: float) -> None:
        _ = source  # part of the key of the compiled code's cache
        s = unpack(state_class, state)
        pack(commit(realised, s, unpack(gains_class, gains), sample_time), state)

    return entry
