"""The residual that is to be expected of a plant that lacks nothing: what noise of the outputs leaves, white or not,
and what the rounding of a recorded input makes of the simulation.
"""

from dataclasses import replace

import numpy as np

from workbench.fitting.replay import Observed, observe
from workbench.identify.simulation.problem import Problem, noise_of, projected

COLOURED = 0.3
"""s. Noise remembers no longer: what is slower is motion."""

GROWTH = 2.0
"""Ratio of second differences, from one distance to twice that, up to which they are those of noise: 1 if it is white,
sqrt(2) of what a first-order lag makes of it and sqrt(3) of means of that; 4 of a smooth signal."""

LEVELS, OFTEN = 8, 3
"""A rounded input takes at least so many values, so often each; a staircase of few steps is a command as it is."""

ON_GRID = 0.01
"""Part of a step by which the values of a rounded input may lie off its grid."""

SEED = 1


def expected_noise(problem: Problem, theta: np.ndarray, jacobian: np.ndarray) -> dict[str, float]:
    """Rms (SI) by output that the residuals would have if the plant were right; `jacobian` by the free parameters."""
    left, _ = problem.left(theta)
    residuals = left / problem.weights
    squares: dict[str, list[float]] = {}
    for item, name, place in problem.series():
        step = item.count * item.record.sample_time
        own = min(noise_level(each, step) for each in (problem.measured[place], residuals[place]))
        squares.setdefault(name, []).append(own**2)
    noise = {name: float(np.mean(each)) for name, each in squares.items()}
    by_inputs = _by_rounding(problem, theta, jacobian)
    return {name: float(np.sqrt(each + by_inputs.get(name, 0.0))) for name, each in noise.items()}


def rms_at(problem: Problem, theta: np.ndarray) -> dict[str, float]:
    """Root mean square (SI) of measured - simulated by output, the sensors' errors taken off."""
    return rms_of(problem, problem.left(theta)[0])


def rms_of(problem: Problem, left: np.ndarray) -> dict[str, float]:
    """Root mean square (SI) of weighted errors by output, over what was measured."""
    squares: dict[str, list[np.ndarray]] = {}
    for _, name, place in problem.series():
        known = np.isfinite(problem.measured[place])
        squares.setdefault(name, []).append(((left / problem.weights)[place][known]) ** 2)
    return {name: float(np.sqrt(np.mean(np.concatenate(parts)))) for name, parts in squares.items()}


def noise_level(values: np.ndarray, step: float) -> float:
    """Standard deviation of the noise of a series with samples `step` (s) apart, which may be coloured.

    From second differences over 1, 2, 4, ... samples, for as long as these grow no faster than noise; their medians,
    to which the few samples at a jump or a kink do not matter.
    """
    level, before, reach = noise_of(values), np.inf, 1
    while reach * step <= COLOURED and 8 * reach < values.size:
        second = values[2 * reach :] - 2.0 * values[reach:-reach] + values[: -2 * reach]
        second = second[np.isfinite(second)]
        own = float(np.median(np.abs(second))) / 0.6745 / np.sqrt(6.0) if second.size else 0.0
        if own > GROWTH * before:
            break
        level, before, reach = max(level, own), own or before, 2 * reach
    return level


def _by_rounding(problem: Problem, theta: np.ndarray, jacobian: np.ndarray) -> dict[str, float]:
    """Mean square (SI) by output of what changes in the simulation if its rounded inputs are as they were before that.

    Less what a fit takes for another plant, or for errors of the sensors, of which the start of a record is one.
    """
    restored = [unrounded(item, problem) for item in problem.observed]
    if not any(restored):
        return {}
    changes = problem.changes(theta)
    parts: list[np.ndarray] = []
    for item, other in zip(problem.observed, restored, strict=True):
        before = None if other is None else other.predicted(problem.experiment, changes)
        usual = None if before is None else item.predicted(problem.experiment, changes)
        if before is None or usual is None:
            parts += [np.zeros(values.size) for values in item.measured.values()]
        else:
            parts += [before[name] - usual[name] for name in item.measured]
    moved = np.where(np.isfinite(problem.measured), np.nan_to_num(np.concatenate(parts)), 0.0)
    explained = projected(problem.projector(), np.column_stack([moved * problem.weights, jacobian]))
    absorbed = explained[:, 1:] @ np.linalg.lstsq(explained[:, 1:], explained[:, 0], rcond=None)[0]
    left = (explained[:, 0] - absorbed)[: moved.size]
    return {name: rms**2 for name, rms in rms_of(problem, left).items()}


def unrounded(item: Observed, problem: Problem) -> Observed | None:
    """A record with the inputs that it may have had before these were rounded; None where none is."""
    changed = {}
    inputs = [feed.input for feed in item.setup.feeds]
    for name in [*inputs, "command"]:
        values = item.record.channels.get(name)
        if values is not None and (step := resolution(values)):
            changed[name] = values - rounding_error(values, step)
    if not changed:
        return None
    record = replace(item.record, channels={**item.record.channels, **changed})
    return replace(item, setup=observe(record, problem.experiment, held=item.held).setup)


def resolution(values: np.ndarray) -> float:
    """The step to which a signal is rounded; 0 where it is not."""
    known = values[np.isfinite(values)]
    span = float(np.ptp(known)) if known.size else 0.0
    if span == 0.0:
        return 0.0
    places, counts = np.unique(np.round(known / span, 9), return_counts=True)
    often = places[counts >= OFTEN]
    if often.size < LEVELS or np.sum(counts[counts >= OFTEN]) < 0.5 * known.size:
        return 0.0
    step = float(np.min(np.diff(often)))
    off = np.abs(np.diff(often) / step - np.round(np.diff(often) / step))
    return step * span if np.max(off) < ON_GRID else 0.0


def rounding_error(values: np.ndarray, step: float) -> np.ndarray:
    """A likely error of a signal that was rounded to steps: of a slow one the way from one change to the next, which is
    a line, and to the value itself where it turns or ends; of one that changes with every sample noise.
    """
    index = np.arange(values.size, dtype=float)
    filled = np.interp(index, index[np.isfinite(values)], values[np.isfinite(values)])
    at = np.flatnonzero(np.diff(filled) != 0.0)
    between = 0.5 * (filled[at] + filled[at + 1])
    turns = np.flatnonzero(between[1:] == between[:-1])
    turning = 0.5 * (at[turns] + at[turns + 1]) + 0.5
    places = np.concatenate([at + 0.5, turning, [0.0, index[-1]]])
    levels = np.concatenate([between, filled[at[turns] + 1], filled[[0, -1]]])
    order = np.argsort(places)
    line = np.interp(index, places[order], levels[order])
    fast = np.zeros(values.size, dtype=bool)
    fast[at[np.flatnonzero(np.diff(at) == 1) + 1]] = True
    noise = np.random.default_rng(SEED).uniform(-0.5, 0.5, values.size) * step
    return np.asarray(np.clip(filled - line, -0.5 * step, 0.5 * step) + np.where(fast, noise, 0.0))
