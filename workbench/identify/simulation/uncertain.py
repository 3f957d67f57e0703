"""What is held and not known exactly: declared parameters with a deviation, and the age of a slow log's samples."""

import numpy as np

from plants.equation import fields
from workbench.errors import UserError
from workbench.fitting.covariance import inverse
from workbench.identify.simulation.problem import Problem
from workbench.records.sampling.sight import SLOW

SMALLEST = 0.5
"""Share of a parameter's value below which it is not lowered for its derivative."""

AREAS = ("piston_area_1", "piston_area_2")
"""Of a plant that holds for equal ones alone they change together."""

AGE = 1.0 / np.sqrt(6.0)
"""Standard deviation, over the sample time, of how much later a position is taken than the command of its line: of a
difference of two ages, each anything from 0 to a sample."""


def held_columns(problem: Problem, theta: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Derivatives of the weighted errors by what is held, each a standard deviation of it, and the names of that.

    Without those that move nothing, such as friction of the other direction, or make a plant that cannot be.
    """
    known = {item.name for item in fields(problem.experiment.plant.Parameters)}
    columns = {
        name: _by_parameter(problem, theta, name, std)
        for name, std in problem.experiment.deviations.items()
        if name in known and name not in problem.free and name not in problem.held
    }
    columns["the age of the samples"] = _by_age(problem, theta)
    moving = {name: column for name, column in columns.items() if np.any(column != 0.0)}
    return (np.column_stack([*moving.values()]) if moving else np.zeros((problem.measured.size, 0))), [*moving]


def without_held(problem: Problem, theta: np.ndarray, jacobian: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Weighted errors without what held parameters explain that are not quite as declared, to first order.

    r + J x + C p with x (fitted, sensors' errors) and p (held, in standard deviations) that make it and p'p least.
    """
    left, _ = problem.left(theta)
    both = np.hstack([jacobian, columns])
    priors = np.concatenate([np.zeros(theta.size), np.ones(both.shape[1] - theta.size)])
    return np.asarray(left - both @ inverse(both.T @ both + np.diag(priors)) @ (both.T @ left))


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


def _by_age(problem: Problem, theta: np.ndarray) -> np.ndarray:
    """By the time by which the outputs of slow records are later than their inputs."""
    column, simulated = np.zeros(problem.measured.size), problem.simulated(theta)
    for item, _, place in problem.series():
        step = item.record.sample_time
        if step > SLOW and place.stop - place.start > 1:
            column[place] = AGE * np.gradient(simulated[place]) / item.count
    return np.where(np.isfinite(problem.measured), column * problem.weights, 0.0)
