"""A Kalman filter that keeps a plant beside measured positions, in compiled code.

From a state x_k a plant goes to f(x_k) at the next sample; derivatives of that are quotients of runs by RK4, so that a
contact that breaks away within a sample is in them, and one much faster than the samples, too:

    F = df/dx,   B = df/dr,   G = df/du

r are constant rates that are added over the sample, u is the command, held over it. They are found along the way that
the filter itself goes, sample by sample.
"""

from typing import TypeAlias

import numpy as np

from plants.compiled import address, copy, inner, njit
from workbench.simulation.compilation import call_derivatives

Sampling: TypeAlias = tuple[int, np.ndarray, np.ndarray, np.ndarray, int, float, float, int]
"""How a plant goes over a sample: the address of its rates, its parameters; the places of the states whose derivatives
are asked for, and by how much each is moved; the place of the command, and by how much that is; s from sample to
sample, and steps of RK4 within one."""


@inner()
def _go(
    derivatives: int,
    time: float,
    y: np.ndarray,
    u: np.ndarray,
    p: np.ndarray,
    added: np.ndarray,
    work: np.ndarray,
    span: float,
    steps: int,
) -> None:
    """Steps of RK4 over a span (s), in place, under held inputs and with rates that are `added`."""
    k, trial, total = work
    h = span / steps
    for step in range(steps):
        for j in range(y.size):
            trial[j], total[j] = y[j], 0.0
        for stage in range(4):
            ahead = h if stage > 1 else 0.5 * h
            at = time + h * (step + (0.0 if stage == 0 else 1.0 if stage == 3 else 0.5))
            call_derivatives(derivatives, at, address(trial), address(u), address(p), address(k))
            for j in range(y.size):
                k[j] += added[j]
                total[j] += k[j] if stage == 0 or stage == 3 else 2.0 * k[j]
                trial[j] = y[j] + ahead * k[j]
        for j in range(y.size):
            y[j] += h / 6.0 * total[j]


@njit(cache=True, nogil=True)
def over_sample(
    plant: Sampling, time: float, state: np.ndarray, u: np.ndarray, both_ways: bool
) -> tuple[np.ndarray, np.ndarray]:
    """F and B, each (states, states), of a plant that goes on from a whole state at a time (s) under inputs: by
    quotients to one side, or to `both_ways`: a contact at rest slips differently to either side, and what stays beside
    it for long is on both.
    """
    derivatives, parameters, places, nudges, _, _, span, steps = plant
    count, every = places.size, state.size
    moved, held = np.zeros((count, count)), np.zeros((count, count))
    base, other, added, work = state.copy(), state.copy(), np.zeros(every), np.zeros((3, every))
    sides = 2 if both_ways else 1
    if not both_ways:
        _go(derivatives, time, base, u, parameters, added, work, span, steps)
    for i in range(count):
        for side in range(sides):
            size = nudges[i] if side == 0 else -nudges[i]
            copy(state, other)
            other[places[i]] += size
            _go(derivatives, time, other, u, parameters, added, work, span, steps)
            for j in range(count):
                moved[j, i] += (other[places[j]] - base[places[j]]) / (sides * size)
            copy(state, other)
            added[places[i]] = size / span
            _go(derivatives, time, other, u, parameters, added, work, span, steps)
            for j in range(count):
                held[j, i] += (other[places[j]] - base[places[j]]) / (sides * size / span)
            added[places[i]] = 0.0
    return moved, held


@inner()
def _fastest_at(plant: Sampling, time: float, state: np.ndarray, u: np.ndarray) -> float:
    """1/s: the spectral radius of derivatives of a plant's rates, J, as |J^32|^(1/32) in units of the nudges."""
    derivatives, parameters, places, nudges, _, _, _, _ = plant
    count = places.size
    base, rates, other, power = np.zeros(state.size), np.zeros(state.size), state.copy(), np.zeros((count, count))
    call_derivatives(derivatives, time, address(state), address(u), address(parameters), address(base))
    for i in range(count):
        other[places[i]] += nudges[i]
        call_derivatives(derivatives, time, address(other), address(u), address(parameters), address(rates))
        other[places[i]] = state[places[i]]
        for j in range(count):
            power[j, i] = (rates[places[j]] - base[places[j]]) / nudges[j]
    radius, share = 0.0, 1.0
    for _ in range(5):
        size = np.sqrt(np.sum(power**2))
        if not 0.0 < size < np.inf:
            return 0.0
        radius += share * np.log(size)
        power /= size
        power = power @ power
        share *= 0.5
    return float(np.exp(radius + share * np.log(max(np.sqrt(np.sum(power**2)), 1e-300))))


@njit(cache=True, nogil=True)
def pushed_over_sample(plant: Sampling, time: float, state: np.ndarray, u: np.ndarray) -> np.ndarray:
    """G, (states,), of the same."""
    derivatives, parameters, places, _, command, push, span, steps = plant
    base, other, inputs, work = state.copy(), state.copy(), u.copy(), np.zeros((3, state.size))
    added = np.zeros(state.size)
    _go(derivatives, time, base, inputs, parameters, added, work, span, steps)
    inputs[command] += push
    _go(derivatives, time, other, inputs, parameters, added, work, span, steps)
    pushed = np.zeros(places.size)
    for i in range(places.size):
        pushed[i] = (other[places[i]] - base[places[i]]) / push
    return pushed


@njit(cache=True, nogil=True)
def keep_beside(
    plant: Sampling,
    time: np.ndarray,
    start: np.ndarray,
    inputs: np.ndarray,
    position: np.ndarray,
    noise: tuple[float, float],
    first: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Corrections (samples, states), standard deviations of what is not foreseen (samples,), and what is not foreseen
    (samples,), of which these are NaN from where the plant is lost.

    Args:
        plant: as it goes over a sample.
        time: s, shape (samples,).
        start: whole state before the first sample.
        inputs: held over each sample, shape (samples, inputs).
        position: what is measured of the first of the states, shape (samples,).
        noise: standard deviations of the command as it is known, and of the position.
        first: standard deviations of the states before the first sample.
    """
    derivatives, parameters, places, _, _, _, span, steps = plant
    count, every = places.size, start.size
    corrections, spread, off = np.zeros((time.size, count)), np.zeros(time.size), np.zeros(time.size)
    y, at, added, work = start.copy(), start.copy(), np.zeros(every), np.zeros((3, every))
    uncertain, gain, u = np.zeros((count, count)), np.zeros(count), np.zeros(inputs.shape[1])
    for i in range(count):
        uncertain[i, i] = first[i] ** 2
    for k in range(time.size):
        copy(inputs[k], u)
        variance = uncertain[0, 0] + noise[1] ** 2
        off[k], spread[k] = position[k] - y[places[0]], np.sqrt(variance)
        copy(y, at)
        for i in range(count):
            gain[i] = uncertain[i, 0] / variance
            at[places[i]] += gain[i] * off[k]
        moved, held = over_sample(plant, time[k], at, u, False)
        pushed = pushed_over_sample(plant, time[k], at, u)
        if not (np.all(np.isfinite(moved)) and np.all(np.isfinite(held))):
            for later in range(k, time.size):
                spread[later] = np.nan
            break
        correcting = np.linalg.solve(held, moved @ gain)
        for i in range(count):
            corrections[k, i] = correcting[i]
            added[places[i]] = correcting[i] * off[k]
        _go(derivatives, time[k], y, u, parameters, added, work, span, steps)
        left = np.eye(count)
        for i in range(count):
            left[i, 0] -= gain[i]
        kept = left @ uncertain @ left.T
        _add_square(kept, gain, noise[1])
        kept = moved @ kept @ moved.T
        _add_square(kept, pushed, noise[0])
        uncertain = 0.5 * (kept + kept.T)
    return corrections, spread, off


@inner()
def _add_square(matrix: np.ndarray, along: np.ndarray, size: float) -> None:
    """Add size^2 v v' to a matrix, `along` v."""
    for i in range(along.size):
        for j in range(along.size):
            matrix[i, j] += size**2 * (along[i] * along[j])


@njit(cache=True, nogil=True)
def fastest(plant: Sampling, time: np.ndarray, states: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    """1/s: how fast a plant is in each of some whole states (samples, all) under inputs (samples, inputs)."""
    rates = np.empty(time.size)
    for k in range(time.size):
        rates[k] = _fastest_at(plant, time[k], states[k], inputs[k])
    return rates
