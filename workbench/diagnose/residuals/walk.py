"""A plant's hidden states along a measured motion, in compiled code: contact, spool, and what effects remember.

The states that a rig shows are put in as they were measured; the rates of the others are those of the plant's own
`derivatives`. They advance by the exact solution for a rate that is linear in the state and inputs that are held, which
a valve's lag and a sliding bristle are:

    z <- z + h r (1 - exp(-d)) / d,   d = -h dr/dz
"""

from typing import Any

import numpy as np

from plants.compiled import address, njit, shift
from workbench.simulation.compilation import call_derivatives

NUDGE = 1e-3
"""Of a state's typical magnitude, by which it is moved for a difference quotient."""

STRAIGHT = 1e-9
"""Decay in a step below which the step is a straight line."""

REFRESHED = 5e-3
"""s after which dr/dz is found anew. Measured signals are smoothed over more than that, and where a state settles it
does not depend on it."""


@njit(cache=True)
def walk(
    derivatives: int,
    time: Any,
    rest: Any,
    shown: Any,
    known: Any,
    inputs: Any,
    parameters: Any,
    hidden: Any,
    settled: Any,
    contact: Any,
    wanted: Any,
    velocity: int,
    still: Any,
    resting: Any,
    creep: float,
    acceleration: Any,
    nudges: Any,
    sample_time: float,
) -> Any:
    """The `hidden` states (instants, hidden) along a motion, and the rates (instants, wanted) that go with them.

    They begin as at rest, those that are `settled` where the first input holds them.

    States are numbered; `known` has the columns of those that are `shown`, all others are as at `rest`. `contact` are
    those that the contact remembers. Where it is `still` the velocity is noise, below `creep` (m/s): the contact is
    taken to stand, is bent by the way that the noise makes, and slips only at its full deflection; its rates are those
    of the bend without the velocity, and of the velocity without the bend. Where it is also `resting` its friction is
    what holds it, and its bend that which gives the measured `acceleration`: simulated from a velocity that is noise it
    would relax as if it crept.
    """
    count, size = time.size, rest.size
    tracked, asked = np.empty((count, hidden.size)), np.empty((count, wanted.size))
    z, x, rates, other = rest.copy(), rest.copy(), np.empty(size), np.empty(size)
    free, bends, slopes = np.empty(size), np.empty(size), np.zeros(size)
    p, steps, age, most = address(parameters), inputs.shape[1], 0, max(round(REFRESHED / sample_time), 1)
    for k in range(count):
        for j in range(shown.size):
            x[shown[j]] = known[k, j]
        for i in hidden:
            x[i] = z[i]
        u, speed = shift(address(inputs), k * steps), x[velocity]
        if still[k]:
            x[velocity] = 0.0
        call_derivatives(derivatives, time[k], address(x), u, p, address(rates))
        stands = still[k] and resting[k]
        if stands and not (k + 1 < count and still[k + 1] and resting[k + 1]):  # what matters is how it leaves rest
            _hold(derivatives, time[k], x, u, p, contact, velocity, acceleration[k], nudges, rates, other, bends)
            _limit(derivatives, time[k], x, u, p, contact, velocity, creep, other, free, bends)
            for i in contact:
                z[i] = x[i]
            call_derivatives(derivatives, time[k], address(x), u, p, address(rates))
        if age == 0:
            for i in hidden:
                x[i] = z[i] + nudges[i]
            call_derivatives(derivatives, time[k], address(x), u, p, address(other))
            for i in hidden:
                slopes[i] = (other[i] - rates[i]) / nudges[i]
        age = (age + 1) % most
        for j in range(hidden.size):
            tracked[k, j] = z[hidden[j]]
        for j in range(wanted.size):
            asked[k, j] = rates[wanted[j]]
        if k == 0:
            for i in settled:
                z[i] -= rates[i] / slopes[i] if slopes[i] < 0.0 else 0.0
                rates[i] = 0.0
        for i in hidden:
            decay = -sample_time * slopes[i]
            if decay > STRAIGHT:
                z[i] -= -np.expm1(-decay) * rates[i] / slopes[i]
            else:
                z[i] += sample_time * rates[i]
        if still[k] and not stands:
            x[velocity] = speed
            for j in range(hidden.size):
                x[hidden[j]] = tracked[k, j]
            for i in contact:
                bends[i], x[i] = x[i], 0.0
            call_derivatives(derivatives, time[k], address(x), u, p, address(other))
            x[velocity] = 0.0
            call_derivatives(derivatives, time[k], address(x), u, p, address(free))
            for j in range(wanted.size):
                asked[k, j] += other[wanted[j]] - free[wanted[j]]
            for i in contact:
                x[i] = bends[i] + sample_time * other[i]
            _limit(derivatives, time[k], x, u, p, contact, velocity, creep, other, free, bends)
            for i in contact:
                z[i] = x[i]
    return tracked, asked


@njit(cache=True)
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
        x[:] = states[k]
        u = shift(address(inputs), k * steps)
        call_derivatives(derivatives, time[k], address(x), u, p, address(rates))
        _hold(derivatives, time[k], x, u, p, contact, velocity, acceleration[k], nudges, rates, other, bends)
        _limit(derivatives, time[k], x, u, p, contact, velocity, creep, other, free, bends)
        states[k] = x


@njit(cache=True)
def _hold(
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


@njit(cache=True)
def _limit(
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


@njit(cache=True)
def rates_along(derivatives: int, time: Any, states: Any, inputs: Any, parameters: Any) -> Any:
    """Rates (instants, states) of whole states along a motion."""
    rates = np.empty_like(states)
    p, size, steps = address(parameters), states.shape[1], inputs.shape[1]
    for k in range(states.shape[0]):
        x, u = shift(address(states), k * size), shift(address(inputs), k * steps)
        call_derivatives(derivatives, time[k], x, u, p, shift(address(rates), k * size))
    return rates
