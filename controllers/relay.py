"""Relay: all forward or all backward. It makes a loop oscillate at its ultimate frequency, which is what it is for.

The relay experiment of Astrom and Hagglund (Automatica 20(5), 1984) finds the gain and the period at which a
proportional loop would just oscillate, without ever making it unstable; `workbench.tune.relay_test` runs it.
"""

from typing import Annotated, NamedTuple

import numpy as np

from controllers.interface import Controller, Reference
from controllers.settings import About
from plants.equation import Scalar, equation, select
from plants.interface import Measurement


class Settings(NamedTuple):
    """What a user sets. The hysteresis has to exceed the noise of the position, or the relay chatters."""

    amplitude: Annotated[float, "command", About("height of the command, to either side", above=True)]
    hysteresis: Annotated[float, "m", About("error beyond which the relay switches")] = 0.0


class Gains(NamedTuple):
    amplitude: Annotated[float, "command"]
    hysteresis: Annotated[float, "m"]


class State(NamedTuple):
    """The side on which the relay is: 1 or -1."""

    side: Annotated[float, "1"]


@equation
def step(
    reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
) -> tuple[Scalar, State]:
    """u = d sgn(e) where |e| > hysteresis, else as before; e = r - x."""
    error = reference.position - measurement.position
    side = select(np.abs(error) > gains.hysteresis, np.sign(error), state.side)
    return gains.amplitude * side, State(side)


@equation
def commit(realised: Scalar, state: State, gains: Gains, sample_time: Scalar) -> State:
    """Nothing to learn: a limited command switches as well."""
    return state


def start(measurement: Measurement, gains: Gains) -> State:
    """Forward."""
    return State(1.0)


def design(settings: Settings, belief: object, sample_time: float) -> Gains:
    """The settings are the gains.

    Raises:
        ValueError: an amplitude that is not above 0, or a negative hysteresis.
    """
    if settings.amplitude <= 0.0:
        raise ValueError(f"amplitude is {settings.amplitude:g}, expected a value above 0")
    if settings.hysteresis < 0.0:
        raise ValueError(f"hysteresis is {settings.hysteresis:g} m, expected 0 or more")
    return Gains(settings.amplitude, settings.hysteresis)


SUMMARY = "relay with hysteresis: makes the loop oscillate, to find its ultimate gain and period"

RELAY = Controller("relay", SUMMARY, Settings, Gains, State, design, step, commit, start)
