"""A plant's hidden states along a measured motion, in compiled code: contact, spool, and what effects remember.

The states that a rig shows are put in as they were measured; the rates of the others are those of the plant's own
`derivatives`. From their rates r0 at an instant, and r1 with the next instant's motion, they advance by

    z <- z + h (w0 r0 + w1 r1),   w0 = (f - e^-d) / d0,   w1 = (1 - f) / d1,   f = (1 - e^-d) / d

with d0, d1 = -h dr/dz at both ends and d their mean, and no weight above 1/2. That is exact where r is linear in z and
in time, as of a valve's lag and a sliding bristle (an exponential integrator of second order; Cox and Matthews 2002).
Bristles that relax within a sample then have no lag that comes of the samples, which their damping would show; and z
stays between itself and where it would settle at either end, so that no reversal makes it overshoot.
"""

from typing import Any

import numpy as np

from plants.compiled import address, njit, shift
from workbench.simulation.compilation import call_derivatives

NUDGE = 1e-3
"""Of a state's typical magnitude, by which it is moved for a difference quotient."""

STRAIGHT = 1e-6
"""Decay in a step below which the step is a straight line: its weights then cancel to less than that."""

REFRESHED = 5e-3
"""s after which dr/dz of states that inputs alone drive is found anew: where such a state settles it does not depend
on it."""


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

    They begin as at rest, those that are `settled`, by the inputs alone, where the first input holds them.

    Where noise hides the velocity (`still`) the contact is only as loaded as the measured acceleration (m/s^2) asks
    for, and never beyond sliding; it does not slide then, or the noise's velocity would wear it. Either it rests
    (`resting`), or it creeps: friction then is of the mean creep, and its bend follows the mean motion, since damping
    and sliding have no linear response to the noise. At rest the bend that sliding left is taken as it was measured,
    and held, and an effect's friction acts in no direction. What fluctuates there is noise, whose bristles would have
    to be bent, and a bend would relax as if it crept.
    """
    count, size = time.size, rest.size
    tracked, asked = np.empty((count, hidden.size)), np.empty((count, wanted.size))
    z, x, rates, other = rest.copy(), rest.copy(), np.empty(size), np.empty(size)
    free, bends, slopes = np.empty(size), np.empty(size), np.empty(size)
    ahead, slopes_ahead, slopes_known = np.empty(size), np.empty(size), False
    p, steps = address(parameters), inputs.shape[1]
    by_motion = hidden.size > settled.size
    most = 1 if by_motion else max(round(REFRESHED / sample_time), 1)
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
        if not slopes_known and k % most == 0:
            _slopes(derivatives, time[k], x, u, p, hidden, nudges, rates, other, slopes)
        for j in range(hidden.size):
            tracked[k, j] = z[hidden[j]]
        for j in range(wanted.size):
            asked[k, j] = rates[wanted[j]]
        if k == 0:
            for i in settled:
                z[i] -= rates[i] / slopes[i] if slopes[i] < 0.0 else 0.0
                x[i], rates[i] = z[i], 0.0
        slopes_known = by_motion and not still[k] and k + 1 < count and not still[k + 1]
        ahead[:], slopes_ahead[:] = rates, slopes
        if slopes_known:
            for j in range(shown.size):
                x[shown[j]] = known[k + 1, j]
            call_derivatives(derivatives, time[k] + sample_time, address(x), u, p, address(ahead))
            _slopes(derivatives, time[k] + sample_time, x, u, p, hidden, nudges, ahead, other, slopes_ahead)
        for i in hidden:
            z[i] += sample_time * _step(-sample_time * slopes[i], -sample_time * slopes_ahead[i], rates[i], ahead[i])
        slopes[:] = slopes_ahead
        if still[k] and not stands:
            x[velocity] = speed
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
def _step(decay: float, decay_ahead: float, rate: float, ahead: float) -> float:
    """Mean rate over a step, from a state's rate and what the next instant's motion makes of it."""
    mean = 0.5 * (decay + decay_ahead)
    if decay < 0.0 or decay_ahead < 0.0 or mean < STRAIGHT:
        return 0.5 * (rate + ahead)
    left = np.exp(-mean)
    kept = -np.expm1(-mean) / mean
    first = min((kept - left) / decay, 0.5) if decay > 0.0 else 0.5
    second = min((1.0 - kept) / decay_ahead, 0.5) if decay_ahead > 0.0 else 0.5
    return first * rate + second * ahead


@njit(cache=True)
def _slopes(
    derivatives: int,
    time: float,
    state: Any,
    inputs: Any,
    parameters: Any,
    hidden: Any,
    nudges: Any,
    rates: Any,
    other: Any,
    slopes: Any,
) -> None:
    """dr/dz of the hidden states, all nudged at once."""
    for i in hidden:
        state[i] += nudges[i]
    call_derivatives(derivatives, time, address(state), inputs, parameters, address(other))
    for i in hidden:
        state[i] -= nudges[i]
        slopes[i] = (other[i] - rates[i]) / nudges[i]


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
        for i in range(size):
            x[i] = states[k, i]
        u = shift(address(inputs), k * steps)
        call_derivatives(derivatives, time[k], address(x), u, p, address(rates))
        _hold(derivatives, time[k], x, u, p, contact, velocity, acceleration[k], nudges, rates, other, bends)
        _limit(derivatives, time[k], x, u, p, contact, velocity, creep, other, free, bends)
        for i in range(size):
            states[k, i] = x[i]


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
