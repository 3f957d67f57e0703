"""A contact where noise hides whether it moves, in compiled code: as loaded as the motion asks for, and no more."""

from typing import Any

import numpy as np

from plants.compiled import address, inner, njit, shift
from workbench.simulation.compilation import call_derivatives

WIDEST_BEND = 1e6
"""Within this factor of a deflection's typical magnitude it is looked for."""


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
def bent_by(
    derivatives: int,
    state: Any,
    inputs: Any,
    parameters: Any,
    contact: Any,
    velocity: int,
    speed: float,
    scales: Any,
) -> Any:
    """How far each contact is bent by sliding at a `speed` (m/s), to a factor of two: where it takes half of it up; of
    all other states, and of what nothing stops, their `scales`.
    """
    x, rates, sizes = state.copy(), np.empty(state.size), scales.copy()
    u, p = address(inputs), address(parameters)
    x[velocity] = speed
    for i in contact:
        at_rest, x[i] = x[i], 0.0
        call_derivatives(derivatives, 0.0, address(x), u, p, address(rates))
        half, factor, goes_on = 0.5 * rates[i], 2.0, rates[i] > 0.0
        while goes_on and 1.0 / WIDEST_BEND < sizes[i] / scales[i] < WIDEST_BEND:
            x[i] = sizes[i]
            call_derivatives(derivatives, 0.0, address(x), u, p, address(rates))
            slides = rates[i] <= half
            if sizes[i] == scales[i] and slides:
                factor = 0.5
            goes_on = slides == (factor < 1.0)
            sizes[i] *= factor if goes_on else 1.0
        if goes_on:  # nothing stops it by itself
            sizes[i] = scales[i]
        x[i] = at_rest
    return sizes


@inner()
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


@inner()
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
