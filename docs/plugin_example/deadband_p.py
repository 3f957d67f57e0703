"""A P controller that rests while the error is small: a controller of one's own, found by its entry point."""

from typing import Annotated, NamedTuple

import numpy as np

from controllers.interface import Controller
from plants.equation import equation


class Settings(NamedTuple):
    kp: Annotated[float, "command/m"]
    deadband: Annotated[float, "m"] = 0.0


class State(NamedTuple):
    command: Annotated[float, "command"]


@equation
def step(reference, measurement, state, gains, sample_time):
    """u = K_p (|e| - D) sgn(e) where |e| > D, else 0; e = r - x and the half-width D in m."""
    error = reference.position - measurement.position
    command = gains.kp * np.sign(error) * np.maximum(np.abs(error) - gains.deadband, 0.0)
    return command, State(command)


@equation
def commit(realised, state, gains, sample_time):
    """Keeps what the amplifier really gave; a law with an integral would learn from it."""
    return State(realised)


def start(measurement, gains):
    """At rest."""
    return State(0.0)


def design(settings, belief, sample_time):
    """The settings are the gains; ValueError becomes the user's message, with file and line."""
    if settings.deadband < 0.0:
        raise ValueError(f"deadband is {settings.deadband:g} m, expected 0 or more")
    return settings


DEADBAND_P = Controller(
    "deadband_p", "P with a deadband of the error", Settings, Settings, State, design, step, commit, start
)
