"""A plant's hidden states along a measured motion, in compiled code: contact, spool, and what effects remember.

The states that a rig shows are put in as they were measured; the rates of the others are those of the plant's own
`derivatives`. From their rates r0 at an instant, and r1 with the next instant's motion, they advance by

    z <- z + h (w0 r0 + w1 r1),   w0 = (f - e^-d) / d0,   w1 = (1 - f) / d1,   f = (1 - e^-d) / d

with d0, d1 = -h dr/dz at both ends and d their mean, and no weight above 1/2. That is exact where r is linear in z and
in time, as of a valve's lag and a sliding bristle (an exponential integrator of second order; Cox and Matthews 2002).
Bristles that relax within a sample then have no lag that comes of the samples, which their damping would show; and z
stays between itself and where it would settle at either end, so that no reversal makes it overshoot. Where a contact's
r is not linear in z, one that sticks and begins to slip, the step is made again in as many parts as it takes. A state
that no other hidden one moves goes first, and r1 of the others is taken with it where it is by then: a velocity that a
lag shows to the contact settles within a sample. States that inputs alone drive go together where one drives another
(`driven`).
"""

from typing import Any

import numpy as np

from plants.compiled import address, copy, inner, njit, shift
from workbench.diagnose.residuals.driven import changes, settle, slopes_between
from workbench.diagnose.residuals.holding import hold, limit
from workbench.simulation.compilation import call_derivatives

NUDGE = 1e-3
"""Of a state's typical magnitude, by which it is moved for a difference quotient."""

STRAIGHT = 1e-6
"""Decay in a step below which the step is a straight line: its weights then cancel to less than that."""

MOST_PARTS = 256
"""Parts of a step, at most."""

REFRESHED = 5e-3
"""s after which dr/dz of states that inputs alone drive is found anew: where such a state settles it does not depend
on it."""


@njit(cache=True, nogil=True)
def walk(
    derivatives: int,
    time: Any,
    rest: Any,
    shown: Any,
    known: Any,
    inputs: Any,
    parameters: Any,
    hidden: Any,
    groups: Any,
    settled: Any,
    contact: Any,
    alone: Any,
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

    They begin as at rest, those that are `settled`, by the inputs alone, where the first input holds them. Those that
    move `alone` are moved by no other hidden one.

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
    before, expected = np.empty(size), np.empty(size)
    p, steps = address(parameters), inputs.shape[1]
    between, moved, coupled = np.empty((settled.size, settled.size)), np.empty(settled.size), False
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
        if slopes_known and by_motion and _bends(rates, expected, contact, z, nudges, sample_time):
            way = (known[k - 1], known[k])
            of = derivatives, u, p, hidden, groups, alone, nudges
            _in_parts(of, time[k], x, shown, contact, way, before, z, sample_time)
            call_derivatives(derivatives, time[k], address(x), u, p, address(rates))
            slopes_known = False
        stands = still[k] and resting[k]
        if stands and not (k + 1 < count and still[k + 1] and resting[k + 1]):  # what matters is how it leaves rest
            hold(derivatives, time[k], x, u, p, contact, velocity, acceleration[k], nudges, rates, other, bends)
            limit(derivatives, time[k], x, u, p, contact, velocity, creep, other, free, bends)
            for i in contact:
                z[i] = x[i]
            call_derivatives(derivatives, time[k], address(x), u, p, address(rates))
        if not slopes_known and k % most == 0:
            _slopes(derivatives, time[k], x, u, p, hidden, groups, nudges, rates, other, slopes)
        for j in range(hidden.size):
            tracked[k, j] = z[hidden[j]]
        for j in range(wanted.size):
            asked[k, j] = rates[wanted[j]]
        if k == 0:
            coupled = settled.size > 1 and slopes_between(
                derivatives, time[k], x, u, p, settled, nudges, rates, other, between
            )
            if coupled:
                settle(derivatives, time[k], x, u, p, settled, nudges, sample_time)
            for i in settled:
                if coupled:
                    z[i] = x[i]
                else:
                    z[i] -= rates[i] / slopes[i] if slopes[i] < 0.0 else 0.0
                x[i], rates[i] = z[i], 0.0
        if coupled:
            slopes_between(derivatives, time[k], x, u, p, settled, nudges, rates, other, between)
            changes(between, settled, rates, sample_time, moved)
        slopes_known = by_motion and not still[k] and k + 1 < count and not still[k + 1]
        copy(rates, ahead)
        copy(slopes, slopes_ahead)
        if slopes_known:
            for j in range(shown.size):
                x[shown[j]] = known[k + 1, j]
            call_derivatives(derivatives, time[k] + sample_time, address(x), u, p, address(ahead))
            _slopes(derivatives, time[k] + sample_time, x, u, p, hidden, groups, nudges, ahead, other, slopes_ahead)
            if 0 < alone.size < hidden.size:
                of, begin, end = (
                    (derivatives, u, p, hidden, groups, alone, nudges),
                    (rates, slopes),
                    (ahead, slopes_ahead),
                )
                _look_again(of, time[k] + sample_time, x, sample_time, z, begin, end, other, free, bends)
        copy(z, before)
        for i in hidden:
            z[i] += sample_time * _step(-sample_time * slopes[i], -sample_time * slopes_ahead[i], rates[i], ahead[i])
            expected[i] = ahead[i] + slopes_ahead[i] * (z[i] - before[i])
        if coupled:
            for j in range(settled.size):
                z[settled[j]] = before[settled[j]] + moved[j]
        copy(slopes_ahead, slopes)
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
            limit(derivatives, time[k], x, u, p, contact, velocity, creep, other, free, bends)
            for i in contact:
                z[i] = x[i]
    return tracked, asked


@inner()
def _bends(rates: Any, expected: Any, contact: Any, z: Any, nudges: Any, sample_time: float) -> bool:
    """Whether a contact's rates at the end of a step, over a sample, are off from where straight lines lead."""
    off = 0.0
    for i in contact:
        off = max(off, abs(rates[i] - expected[i]) / _counts(z[i], nudges[i]))
    return off * sample_time > 1.0


@inner()
def _counts(bent: float, nudge: float) -> float:
    """From which change on it counts where a contact is: a part of what is typical of it, or of how far it is bent."""
    return max(nudge, NUDGE * abs(bent))


@inner()
def _in_parts(
    of: Any, time: float, state: Any, shown: Any, contact: Any, way: Any, before: Any, z: Any, sample_time: float
) -> None:
    """A step again from `before`, what is shown going straight along its `way`, in ever more parts until these no
    longer count: `z` and `state` at its end.
    """
    derivatives, inputs, parameters, hidden, groups, _, nudges = of
    size, parts, change = state.size, 1, np.inf
    rates, ahead, other = np.empty(size), np.empty(size), np.empty(size)
    slopes, slopes_ahead, own, own_slopes = np.empty(size), np.empty(size), np.empty(size), np.empty(size)
    begin, last = (rates, slopes), (ahead, slopes_ahead)
    while change > 1.0 and parts < MOST_PARTS:
        parts *= 2
        step, now = sample_time / parts, before.copy()
        for part in range(parts):
            for end in range(2):
                for j in range(shown.size):
                    state[shown[j]] = way[0][j] + (way[1][j] - way[0][j]) * (part + end) / parts
                for i in hidden:
                    state[i] = now[i]
                found, sloping = begin if end == 0 else last
                call_derivatives(derivatives, time, address(state), inputs, parameters, address(found))
                _slopes(derivatives, time, state, inputs, parameters, hidden, groups, nudges, found, other, sloping)
            _look_again(of, time, state, step, now, begin, last, other, own, own_slopes)
            for i in hidden:
                now[i] += step * _step(-step * slopes[i], -step * slopes_ahead[i], rates[i], ahead[i])
        change = 0.0
        for i in contact:
            change = max(change, abs(now[i] - z[i]) / _counts(now[i], nudges[i]))
        copy(now, z)
    for i in hidden:
        state[i] = z[i]


@inner()
def _look_again(
    of: Any,
    time: float,
    state: Any,
    step: float,
    z: Any,
    begin: Any,
    end: Any,
    other: Any,
    own: Any,
    own_slopes: Any,
) -> None:
    """The rates at the `end` of a step, and their slopes, once more with those states that are moved by none of the
    others where they are by then, if they count in rates of others: what settles fast has settled there.
    """
    derivatives, inputs, parameters, hidden, groups, alone, nudges = of
    (rates, slopes), (ahead, slopes_ahead) = begin, end
    moves = False
    for i in alone:
        own[i], own_slopes[i] = ahead[i], slopes_ahead[i]
        state[i] = z[i] + step * _step(-step * slopes[i], -step * slopes_ahead[i], rates[i], ahead[i])
        moves = moves or state[i] != z[i]
    if not moves:
        return
    call_derivatives(derivatives, time, address(state), inputs, parameters, address(other))
    for i in alone:
        ahead[i] = other[i]
    counts = False
    for i in hidden:
        counts = counts or other[i] != ahead[i]
    if counts:
        copy(other, ahead)
        _slopes(derivatives, time, state, inputs, parameters, hidden, groups, nudges, ahead, other, slopes_ahead)
    for i in alone:
        state[i], ahead[i], slopes_ahead[i] = z[i], own[i], own_slopes[i]


@njit(cache=True, nogil=True)
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


@inner()
def _slopes(
    derivatives: int,
    time: float,
    state: Any,
    inputs: Any,
    parameters: Any,
    hidden: Any,
    groups: Any,
    nudges: Any,
    rates: Any,
    other: Any,
    slopes: Any,
) -> None:
    """dr/dz of the hidden states, those of a group nudged at once: none of them counts in another's rate."""
    count = 0
    for group in groups:
        count = max(count, group + 1)
    for group in range(count):
        for j in range(hidden.size):
            if groups[j] == group:
                state[hidden[j]] += nudges[hidden[j]]
        call_derivatives(derivatives, time, address(state), inputs, parameters, address(other))
        for j in range(hidden.size):
            if groups[j] == group:
                i = hidden[j]
                state[i] -= nudges[i]
                slopes[i] = (other[i] - rates[i]) / nudges[i]


@njit(cache=True, nogil=True)
def rates_along(derivatives: int, time: Any, states: Any, inputs: Any, parameters: Any) -> Any:
    """Rates (instants, states) of whole states along a motion."""
    rates = np.empty_like(states)
    p, size, steps = address(parameters), states.shape[1], inputs.shape[1]
    for k in range(states.shape[0]):
        x, u = shift(address(states), k * size), shift(address(inputs), k * steps)
        call_derivatives(derivatives, time[k], x, u, p, shift(address(rates), k * size))
    return rates
