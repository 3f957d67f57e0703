"""What is held and not known exactly: declared parameters with a deviation, and the age of a slow log's samples."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plants.equation import fields
from workbench.errors import UserError
from workbench.fitting.covariance import inverse
from workbench.fitting.replay import straight
from workbench.identify.simulation.problem import DIVERGED, Problem
from workbench.records.sampling.sight import SLOW

BOUND = 1.0 / np.sqrt(3.0)
"""Standard deviation of what is anywhere within a bound, over that."""

SMALLEST = 0.5
"""Share of a parameter's value below which it is not lowered for its derivative."""

STEPS = 3
"""In which held parameters are looked for that explain what a fit leaves."""

AREAS = ("piston_area_1", "piston_area_2")
"""Of a plant that holds for equal ones alone they change together."""

AGE = 1.0 / np.sqrt(6.0)
"""Standard deviation, over the sample time, of how much later a position is taken than the command of its line: of a
difference of two ages, each anything from 0 to a sample."""


def held_columns(problem: Problem, theta: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Derivatives of the weighted errors by what is held, each a standard deviation of it, and the names of that.

    Without those that move nothing, such as friction of the other direction, or make a plant that cannot be.
    """
    deviations = problem.experiment.deviations
    columns = {name: _by_parameter(problem, theta, name, deviations[name]) for name in movable(problem)}
    columns["the age of the samples"] = _by_age(problem, theta)
    columns["the way of the inputs between samples"] = _by_way(problem, theta)
    moving = {name: column for name, column in columns.items() if np.any(column != 0.0)}
    return (np.column_stack([*moving.values()]) if moving else np.zeros((problem.measured.size, 0))), [*moving]


def movable(problem: Problem) -> list[str]:
    """The parameters that are held, and of which a deviation is declared."""
    known = {item.name for item in fields(problem.experiment.plant.Parameters)}
    return [
        name
        for name in problem.experiment.deviations
        if name in known and name not in problem.free and name not in problem.held
    ]


def without_held(
    problem: Problem, theta: np.ndarray, jacobian: np.ndarray, columns: np.ndarray, names: Sequence[str]
) -> np.ndarray:
    """Weighted errors without what held parameters explain that are not quite as declared.

    r(x, p) with x (fitted, sensors' errors) and p (held, in standard deviations) that make r'r + p'p least: some steps
    of Gauss and Newton with the derivatives at the declared values, as long as they make it less.
    """
    count, held = theta.size, jacobian.shape[1]
    both = np.hstack([jacobian, columns])
    priors = np.concatenate([np.zeros(count), np.ones(both.shape[1] - count)])
    back = inverse(both.T @ both + np.diag(priors))
    moved, left = np.zeros(both.shape[1]), problem.left(theta)[0]
    step = -back @ (both.T @ left)
    best = left + both @ step
    for _ in range(STEPS):
        trial = moved + step
        changes = _changed(problem, names, trial[held:])
        errors = problem.errors(np.clip(theta + trial[:count], *problem.limits()), changes)
        if not np.all(np.abs(errors) < DIVERGED):
            break
        linear = np.array([name not in problem.experiment.deviations for name in names], dtype=bool)
        errors = problem.without_sensors(errors + columns[:, linear] @ trial[held:][linear])[0]
        step = -back @ (both.T @ errors + priors * np.where(np.arange(trial.size) < held, 0.0, trial))
        moved, found = trial, errors + both @ step
        if found @ found >= best @ best:
            break
        best = found
    return np.asarray(best)


def _changed(problem: Problem, names: Sequence[str], deviations: np.ndarray) -> dict[str, float]:
    """Held parameters (SI) so many standard deviations from what is declared."""
    changes: dict[str, float] = {}
    for name, away in zip(names, deviations.tolist(), strict=True):
        if (std := problem.experiment.deviations.get(name)) is not None:
            value = problem.experiment.values[name]
            least = SMALLEST * value if value > 0.0 else -np.inf
            changes |= _possible(problem, name, max(value + away * std, least)) or {}
    return changes


def _by_parameter(problem: Problem, theta: np.ndarray, name: str, std: float) -> np.ndarray:
    """By a declared parameter, from one standard deviation below it to one above; 0 where the plant cannot be there."""
    value = problem.experiment.values[name]
    low = max(value - std, SMALLEST * value) if value > 0.0 else value - std
    sides = []
    for number in (low, value + std):
        changes = _possible(problem, name, number)
        if changes is None or not np.all(np.isfinite(simulated := problem.simulated(theta, changes))):
            return np.zeros(problem.measured.size)
        sides.append(simulated)
    slope = (sides[0] - sides[1]) * problem.weights * std / (value + std - low)
    return np.where(np.isfinite(problem.measured), slope, 0.0)


def _possible(problem: Problem, name: str, number: float) -> dict[str, float] | None:
    """The changes by which a parameter has that value; None where no plant has it, or another one stands for it."""
    experiment = problem.experiment
    together = dict.fromkeys(AREAS, number) if name in AREAS else {name: number}
    for changes in ({name: number}, together):
        try:
            experiment.parameters(changes)
        except UserError:
            continue
        counted = len(changes) > 1 and name == AREAS[1] and AREAS[0] in experiment.deviations
        return None if counted else changes
    return None


def _by_way(problem: Problem, theta: np.ndarray) -> np.ndarray:
    """By the way of slow records' inputs between samples: a straight line in the place of a curve is a bound."""
    column, changes, parts = np.zeros(problem.measured.size), problem.changes(theta), {}
    for item, name, place in problem.series():
        if item.record.sample_time <= SLOW:
            continue
        if item not in parts:
            feeds = tuple(replace(feed, signal=straight(item.record, feed.input)) for feed in item.setup.feeds)
            parts[item] = replace(item, setup=replace(item.setup, feeds=feeds)).predicted(problem.experiment, changes)
        if (shown := parts[item]) is not None:
            column[place] = shown[name]
    other = np.where(column != 0.0, problem.simulated(theta) - column, 0.0)
    return np.where(np.isfinite(problem.measured), np.nan_to_num(other) * BOUND * problem.weights, 0.0)


def _by_age(problem: Problem, theta: np.ndarray) -> np.ndarray:
    """By the time by which the outputs of slow records are later than their inputs."""
    column, simulated = np.zeros(problem.measured.size), problem.simulated(theta)
    for item, _, place in problem.series():
        step = item.record.sample_time
        if step > SLOW and place.stop - place.start > 1:
            column[place] = AGE * np.gradient(simulated[place]) / item.count
    return np.where(np.isfinite(problem.measured), column * problem.weights, 0.0)
