"""A contact where noise hides whether it moves, in compiled code: as loaded as the motion asks for, and no more."""

from typing import Any

import numpy as np

from plants.compiled import address, njit, shift
from workbench.simulation.compilation import call_derivatives


@njit(cache=True, nogil=True)
def hold_all(
    derivatives: int,
    time: Any,
    states: Any,
    inputs: Any,
    parameters: Any,
    contact: Any,
    velocity: int,
    creep: float,
    acceleration: Any,
    nudges: Any,
) -> None:
    """Bend the contact in each row of `states` as the measured `acceleration` asks for, as far as it can be bent."""
    count, size = states.shape
    x, rates, other = np.empty(size), np.empty(size), np.empty(size)
    free, bends = np.empty(size), np.empty(size)
    p, steps = address(parameters), inputs.shape[1]
    for k in range(count):
        for i in range(size):
            x[i] = states[k, i]
        u = shift(address(inputs), k * steps)
        call_derivatives(derivatives, time[k], address(x), u, p, address(rates))
        hold(derivatives, time[k], x, u, p, contact, velocity, acceleration[k], nudges, rates, other, bends)
        limit(derivatives, time[k], x, u, p, contact, velocity, creep, other, free, bends)
        for i in range(size):
            states[k, i] = x[i]


@njit(cache=True, nogil=True)
def hold(
    derivatives: int,
    time: float,
    state: Any,
    inputs: Any,
    parameters: Any,
    contact: Any,
    velocity: int,
    acceleration: float,
    nudges: Any,
    rates: Any,
    other: Any,
    slopes: Any,
) -> None:
    """Bend the contact, all of it that carries a force alike, until the mass has this acceleration (m/s^2)."""
    stiffness = 0.0
    for i in contact:
        bend = state[i]
        state[i] = bend + nudges[i]
        call_derivatives(derivatives, time, address(state), inputs, parameters, address(other))
        state[i] = bend
        slopes[i] = (other[velocity] - rates[velocity]) / nudges[i]
        stiffness += slopes[i]
    for i in contact:
        if slopes[i] != 0.0:
            state[i] += (acceleration - rates[velocity]) / stiffness


@njit(cache=True, nogil=True)
def limit(
    derivatives: int,
    time: float,
    state: Any,
    inputs: Any,
    parameters: Any,
    contact: Any,
    velocity: int,
    creep: float,
    rates: Any,
    free: Any,
    bends: Any,
) -> None:
    """Take back what the contact is bent beyond sliding: to where its rates vanish at a creep that bends it so.

    A rate is taken to be linear in the bend, as a bristle's is.
    """
    speed, bend = state[velocity], 0.0
    for i in contact:
        bends[i] = state[i]
        bend += state[i]
        state[i] = 0.0
    state[velocity] = creep if bend >= 0.0 else -creep
    call_derivatives(derivatives, time, address(state), inputs, parameters, address(rates))
    for i in contact:
        free[i] = rates[i]
        state[i] = bends[i]
    call_derivatives(derivatives, time, address(state), inputs, parameters, address(rates))
    for i in contact:
        if free[i] * rates[i] < 0.0:
            state[i] = bends[i] * free[i] / (free[i] - rates[i])
    state[velocity] = speed
