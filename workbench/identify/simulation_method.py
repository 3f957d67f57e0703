"""Identification by simulation error: the parameters with which the declared plant, driven by what was measured,
follows the record best."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from plants.equation import NEGATIVE
from workbench.errors import UserError
from workbench.identify import covariance
from workbench.identify.experiment import Experiment, parameter_names
from workbench.identify.friction_records import directions
from workbench.identify.model import observe
from workbench.identify.problem import Problem, make_problem, projected
from workbench.identify.records import Record
from workbench.identify.schema import FRICTION

FLAT, NEAR, MOST_STEPS = 1e-8, 1e-5, 60
"""A search ends when a step gains less of the sum of squares, or moves the unknowns less, than this."""

INSIDE = 1e-9
"""A search starts this far inside its bounds."""

UNKNOWN = 0.5
"""Relative standard deviation from which a parameter counts as not identified."""

SINGULAR = 1e-4
"""Ratio of a singular value of the scaled Jacobian to the largest below which a direction is not identified."""

SHARE = 0.3
"""Part in such a direction from which a parameter is named."""

NORMAL_95 = 1.959964
"""Half width of a 95 % interval in standard deviations."""


@dataclass(frozen=True)
class Fitted:
    """One parameter: value, standard deviation and 95 % interval (SI)."""

    value: float
    std: float
    low: float
    high: float


@dataclass(frozen=True)
class SimulationFit:
    """What a fit by simulation finds.

    `unidentified` says of each parameter that the records cannot identify why; it is at its declared value.
    `residuals` and `simulated` are by record path and output, in SI, over `times`; `rms` the residuals' by output.
    """

    estimates: Mapping[str, Fitted]
    correlation: np.ndarray
    unidentified: Mapping[str, str]
    sensors: Mapping[str, Fitted]
    rms: Mapping[str, float]
    before: Mapping[str, float]
    times: Mapping[str, np.ndarray]
    simulated: Mapping[str, Mapping[str, np.ndarray]]
    measured: Mapping[str, Mapping[str, np.ndarray]]
    memory: float
    evaluations: int
    notes: tuple[str, ...] = ()


def default_free(experiment: Experiment, records: Sequence[Record]) -> list[str]:
    """Friction in the directions in which the records move; one value for both where the plant has one."""
    known = parameter_names(experiment.plant)
    moved = {sign for record in records for sign in directions(record, experiment)}
    apart = any(f"{name}_{NEGATIVE}" in experiment.values for name in FRICTION)
    names = [name for name in FRICTION if name in known and (1 in moved or not apart)]
    if -1 in moved and apart:
        names += [f"{name}_{NEGATIVE}" for name in FRICTION if f"{name}_{NEGATIVE}" in experiment.values]
    return names


def identify_by_simulation(experiment: Experiment, records: Sequence[Record]) -> SimulationFit:
    """Fit the free parameters to all records together.

    Each output is weighted by the long-run deviation of its own residuals, found in a first fit. A parameter that the
    records cannot identify is fixed at its declared value, and the rest fitted again.

    Raises:
        UserError: nothing to fit, or the declared plant cannot be simulated on these records.
    """
    turning = sorted({record.rpm for record in records if record.rpm})
    if turning and not experiment.plant.rotary_command:
        raise UserError(
            f"{experiment.path}: plant {experiment.plant.name} does not rotate, and there are records at "
            f"{', '.join(f'{rpm:g}' for rpm in turning)} rpm; take a rotating plant such as "
            "rotating_anisotropic_ideal, or --method thesis"
        )
    observed = [observe(record, experiment) for record in records]
    free = list(experiment.free) if experiment.free is not None else default_free(experiment, records)
    if not free:
        raise UserError(f"{experiment.path}: fit.free: is empty: expected at least one parameter")
    problem = make_problem(experiment, observed, free)
    before = _rms(problem, np.zeros(len(free)))
    theta = _solve(problem, np.zeros(len(free)), rough=True)
    unidentified: dict[str, str] = {}
    while True:
        problem.describe_sensors(theta)
        length = _reweight(problem, theta)
        theta = _solve(problem, theta)
        jacobian, cov = _covariance(problem, theta, length)
        worst = _unidentified(problem, jacobian, cov)
        if not worst or len(problem.free) == len(worst):
            break
        unidentified |= worst
        keep = [i for i, name in enumerate(problem.free) if name not in worst]
        problem.free = [problem.free[i] for i in keep]
        theta = theta[keep]
    return _result(problem, theta, cov, length, unidentified, before)


def _solve(problem: Problem, theta: np.ndarray, *, rough: bool = False) -> np.ndarray:
    """The best unknowns: trust region, bounds; `rough` on the first way there."""
    q = problem.projector()
    low, high = problem.limits()
    found = least_squares(
        lambda x: projected(q, problem.errors(x)),
        np.clip(theta, low + INSIDE, high - INSIDE),
        jac=lambda x: projected(q, problem.jacobian(x, rough=rough)),
        bounds=(low, high),
        ftol=FLAT,
        xtol=NEAR,
        gtol=None,
        max_nfev=MOST_STEPS,
    )
    return np.asarray(found.x)


def _reweight(problem: Problem, theta: np.ndarray) -> int:
    """Weight each output by the long-run deviation of its residuals; returns the residuals' memory (samples)."""
    left, _ = problem.left(theta)
    residuals = left / problem.weights
    series = problem.series()
    length = covariance.long_run_length([residuals[place] for _, _, place in series])
    for output in {name for _, name, _ in series}:
        places = [place for _, name, place in series if name == output]
        memory = covariance.long_run_length([residuals[place] for place in places])
        deviation = np.sqrt(np.mean([covariance.long_run_deviation(residuals[place], memory) ** 2 for place in places]))
        for place in places:
            problem.weights[place] = 1.0 / max(float(deviation), 1e-12)
    return length


def _covariance(problem: Problem, theta: np.ndarray, length: int) -> tuple[np.ndarray, np.ndarray]:
    """Weighted Jacobian over all unknowns (parameters, then sensors), and their covariance."""
    jacobian = np.hstack([problem.jacobian(theta), -problem.weighted_nuisance])
    left, _ = problem.left(theta)
    priors = np.concatenate([np.zeros(theta.size), np.ones(problem.nuisance.shape[1])])
    groups = [place for _, _, place in problem.series()]
    return jacobian, covariance.sandwich(jacobian, left, groups, length, priors)


def _unidentified(problem: Problem, jacobian: np.ndarray, cov: np.ndarray) -> dict[str, str]:
    """The parameters to fix next, and why: those of a singular direction, else the one least known."""
    count = len(problem.free)
    _, singular, directions_ = np.linalg.svd(projected(problem.projector(), jacobian[:, :count]), full_matrices=False)
    deviations = np.sqrt(np.maximum(np.diag(cov)[:count], 0.0))
    if singular[-1] < SINGULAR * singular[0]:
        parts = np.abs(directions_[-1])
        named = [problem.free[i] for i in np.flatnonzero(parts > SHARE)]
        worst = problem.free[int(np.argmax(parts))]
        others = [name for name in named if name != worst]
        why = f"cannot be told apart from {', '.join(others)}" if others else "has no effect on the records"
        return {worst: why}
    if np.max(deviations) > UNKNOWN:
        i = int(np.argmax(deviations))
        return {problem.free[i]: f"standard deviation {100.0 * deviations[i]:.0f} % of its value"}
    return {}


def _rms(problem: Problem, theta: np.ndarray) -> dict[str, float]:
    """Root mean square (SI) of measured - simulated by output, the sensors' errors taken off."""
    left, _ = problem.left(theta)
    squares: dict[str, list[np.ndarray]] = {}
    for _, name, place in problem.series():
        known = np.isfinite(problem.measured[place])
        squares.setdefault(name, []).append(((left / problem.weights)[place][known]) ** 2)
    return {name: float(np.sqrt(np.mean(np.concatenate(parts)))) for name, parts in squares.items()}


def _result(
    problem: Problem,
    theta: np.ndarray,
    cov: np.ndarray,
    length: int,
    unidentified: Mapping[str, str],
    before: Mapping[str, float],
) -> SimulationFit:
    count = len(problem.free)
    deviations = np.sqrt(np.diag(cov))
    estimates = {}
    for i, name in enumerate(problem.free):
        ends = [problem.value(name, theta[i] + side * NORMAL_95 * deviations[i]) for side in (-1.0, 1.0)]
        value = problem.value(name, theta[i])
        estimates[name] = Fitted(value, abs(problem.slope(name, theta[i])) * deviations[i], ends[0], ends[1])
    left, numbers = problem.left(theta)
    residuals = left / problem.weights
    times: dict[str, np.ndarray] = {}
    simulated: dict[str, dict[str, np.ndarray]] = {}
    measured: dict[str, dict[str, np.ndarray]] = {}
    for item, name, place in problem.series():
        path = str(item.record.path)
        times[path] = item.time
        measured.setdefault(path, {})[name] = item.measured[name]
        simulated.setdefault(path, {})[name] = problem.measured[place] - residuals[place]
    scales = np.outer(deviations[:count], deviations[:count])
    sensors = {}
    for name, std in problem.experiment.accuracies.items():
        if name in problem.sensors:
            column = problem.sensors.index(name)
            spread = std * deviations[count + column]
            value = std * float(numbers[column])
            sensors[name] = Fitted(value, spread, value - NORMAL_95 * spread, value + NORMAL_95 * spread)
    return SimulationFit(
        estimates,
        cov[:count, :count] / np.where(scales > 0.0, scales, 1.0),
        unidentified,
        sensors,
        _rms(problem, theta),
        before,
        times,
        simulated,
        measured,
        length * float(problem.observed[0].count) * problem.observed[0].record.sample_time,
        problem.evaluations,
    )
