"""Identification by simulation error: the parameters with which the declared plant, driven by what was measured,
follows the record best."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares

from plants.equation import NEGATIVE
from workbench.errors import UserError
from workbench.identify import covariance
from workbench.identify.experiment import Experiment, parameter_names
from workbench.identify.friction_records import directions
from workbench.identify.model import Observed, observe, predictions
from workbench.identify.nuisance import columns
from workbench.identify.records import Record
from workbench.parameters import SIGNED

FRICTION = ("coulomb", "stribeck", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping")
"""What is free where an experiment does not say."""

WIDEST = 100.0
"""A parameter without bounds of its own stays within this factor of its declared value."""

STEP = 1e-3
"""Relative step of the central differences; truncation and the integrator's noise are both below 1e-4 of a derivative."""

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


@dataclass
class _Problem:
    """Stacked residuals over scaled unknowns theta = log(p / p0), or (p - p0) / scale where p may be 0 or negative."""

    experiment: Experiment
    observed: Sequence[Observed]
    free: list[str]
    start: dict[str, float]
    nuisance: np.ndarray
    sensors: list[str]
    weights: np.ndarray
    measured: np.ndarray
    evaluations: int = 0
    solutions: dict[bytes, np.ndarray] = field(default_factory=dict)

    def value(self, name: str, theta: float) -> float:
        """A parameter (SI) from its scaled unknown."""
        start = self.start[name]
        return start * float(np.exp(theta)) if _positive(name, start) else start + theta * _scale(name, start)

    def slope(self, name: str, theta: float) -> float:
        """Derivative of the parameter by its scaled unknown."""
        start = self.start[name]
        return self.value(name, theta) if _positive(name, start) else _scale(name, start)

    def simulated(self, theta: np.ndarray) -> np.ndarray:
        """Stacked predictions (SI), NaN where the plant diverges."""
        key = theta.tobytes() + ",".join(self.free).encode()
        if key not in self.solutions:
            changes = {name: self.value(name, x) for name, x in zip(self.free, theta.tolist(), strict=True)}
            found = predictions(self.observed, self.experiment, changes)
            self.evaluations += 1
            parts = []
            for item, predicted in zip(self.observed, found, strict=True):
                for name, values in item.measured.items():
                    parts.append(np.full(values.size, np.nan) if predicted is None else predicted[name])
            if len(self.solutions) > 4 * len(self.free) + 8:
                self.solutions.clear()
            self.solutions[key] = np.concatenate(parts)
        return self.solutions[key]

    def errors(self, theta: np.ndarray) -> np.ndarray:
        """Weighted measured - simulated, 0 over gaps; large where the plant diverges."""
        difference = (self.measured - self.simulated(theta)) * self.weights
        difference[~np.isfinite(self.measured)] = 0.0
        return np.nan_to_num(difference, nan=DIVERGED)

    def jacobian(self, theta: np.ndarray) -> np.ndarray:
        """d errors / d theta by central differences, shape (samples, free)."""
        slopes = []
        for i in range(theta.size):
            step = np.zeros(theta.size)
            step[i] = STEP
            slopes.append((self.errors(theta + step) - self.errors(theta - step)) / (2.0 * STEP))
        return np.column_stack(slopes)

    def describe_sensors(self, theta: np.ndarray) -> None:
        """Columns of the sensors' errors about the outputs simulated at `theta`.

        Raises:
            UserError: the plant diverges there.
        """
        simulated = self.simulated(theta)
        if not np.all(np.isfinite(simulated)):
            raise UserError(
                f"{self.experiment.path}: plant {self.experiment.plant.name} with these parameters diverges on the "
                "records; start from others with [plant.set]"
            )
        self.nuisance, self.sensors = columns(self.observed, simulated, self.experiment.accuracies)

    @property
    def weighted_nuisance(self) -> np.ndarray:
        """The sensors' columns, weighted, 0 over gaps."""
        return np.where(np.isfinite(self.measured), self.weights, 0.0)[:, None] * self.nuisance


DIVERGED = 1e6
"""Weighted error of a sample that a diverged simulation does not reach."""


def _positive(name: str, start: float) -> bool:
    return start > 0.0 and name.removesuffix(f"_{NEGATIVE}") not in SIGNED


def _scale(name: str, start: float) -> float:
    return abs(start) or TYPICAL.get(name.removesuffix(f"_{NEGATIVE}"), 1.0)


TYPICAL = {
    "coulomb": 100.0,
    "stribeck": 100.0,
    "viscous": 1e3,
    "load_force": 100.0,
    "valve_overlap": 1e-5,
    "leakage_coefficient": 1e-13,
}
"""Steps (SI) of parameters whose declared value is 0."""


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
    observed = [observe(record, experiment) for record in records]
    free = list(experiment.free) if experiment.free is not None else default_free(experiment, records)
    if not free:
        raise UserError(f"{experiment.path}: fit.free: is empty: expected at least one parameter")
    problem = _problem(experiment, observed, free)
    before = _rms(problem, np.zeros(len(free)))
    theta = _solve(problem, np.zeros(len(free)))
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


def _problem(experiment: Experiment, observed: Sequence[Observed], free: list[str]) -> _Problem:
    plain = {
        name: experiment.values.get(name, experiment.values.get(name.removesuffix(f"_{NEGATIVE}"))) for name in free
    }
    missing = [name for name, value in plain.items() if value is None]
    if missing:
        raise UserError(f"{experiment.path}: {missing[0]} is free and has no declared value; set it in [plant.set]")
    measured = np.concatenate([values for item in observed for values in item.measured.values()])
    weights = np.concatenate(
        [np.full(values.size, 1.0 / _noise(values)) for item in observed for values in item.measured.values()]
    )
    start = {name: float(value) for name, value in plain.items() if value is not None}
    problem = _Problem(experiment, observed, free, start, np.zeros((measured.size, 0)), [], weights, measured)
    problem.describe_sensors(np.zeros(len(free)))
    return problem


def _noise(values: np.ndarray) -> float:
    """Standard deviation of the noise of a series, from its second differences, which a slow signal lacks."""
    second = np.diff(values, 2)
    second = second[np.isfinite(second)]
    return max(float(np.sqrt(np.mean(second**2) / 6.0)), 1e-9 * float(np.nanmax(np.abs(values))), 1e-12)


def _projector(problem: _Problem) -> np.ndarray:
    """Orthonormal columns Q of the sensors' errors with their priors: what they explain of a residual is Q Q' r."""
    nuisance = problem.weighted_nuisance
    stacked = np.vstack([nuisance, np.eye(nuisance.shape[1])])
    return np.asarray(np.linalg.qr(stacked)[0])


def _solve(problem: _Problem, theta: np.ndarray) -> np.ndarray:
    """The best scaled unknowns: trust region, bounds; the sensors' errors are solved for exactly at every step."""
    q = _projector(problem)
    size = problem.measured.size

    def without_sensors(values: np.ndarray) -> np.ndarray:
        inner = q[:size].T @ values
        whole = -q @ inner
        whole[:size] += values
        return np.asarray(whole)

    low, high = _limits(problem)
    found = least_squares(
        lambda x: without_sensors(problem.errors(x)),
        np.clip(theta, low + 1e-9, high - 1e-9),
        jac=lambda x: without_sensors(problem.jacobian(x)),
        bounds=(low, high),
        x_scale=1.0,
        ftol=1e-7,
        xtol=1e-6,
        gtol=1e-12,
        max_nfev=40,
    )
    return np.asarray(found.x)


def _limits(problem: _Problem) -> tuple[np.ndarray, np.ndarray]:
    """Bounds of the scaled unknowns."""
    limits = []
    for name in problem.free:
        low, high = problem.experiment.bounds.get(name, (-np.inf, np.inf))
        start = problem.start[name]
        if _positive(name, start):
            widest = np.log(WIDEST)
            lower = np.log(low / start) if low > 0.0 else -widest
            limits.append((lower, np.log(high / start) if np.isfinite(high) else widest))
        else:
            scale = _scale(name, start)
            if name.removesuffix(f"_{NEGATIVE}") not in SIGNED:
                low = max(low, 0.0)
            limits.append(((low - start) / scale, (high - start) / scale))
    array = np.array(limits)
    return array[:, 0], array[:, 1]


def _left(problem: _Problem, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weighted residuals after the sensors' errors, and those errors' numbers."""
    errors, nuisance = problem.errors(theta), problem.weighted_nuisance
    normal = nuisance.T @ nuisance + np.eye(nuisance.shape[1])
    numbers = np.linalg.solve(normal, nuisance.T @ errors)
    return errors - nuisance @ numbers, numbers


def _series(problem: _Problem) -> list[tuple[Observed, str, slice]]:
    """Where each output of each record stands in the stack."""
    found, first = [], 0
    for item in problem.observed:
        for name, values in item.measured.items():
            found.append((item, name, slice(first, first + values.size)))
            first += values.size
    return found


def _reweight(problem: _Problem, theta: np.ndarray) -> int:
    """Weight each output by the long-run deviation of its residuals; returns the residuals' memory (samples)."""
    left, _ = _left(problem, theta)
    residuals = left / problem.weights
    series = _series(problem)
    length = covariance.long_run_length([residuals[place] for _, _, place in series])
    for output in {name for _, name, _ in series}:
        places = [place for _, name, place in series if name == output]
        memory = covariance.long_run_length([residuals[place] for place in places])
        deviation = np.sqrt(np.mean([covariance.long_run_deviation(residuals[place], memory) ** 2 for place in places]))
        for place in places:
            problem.weights[place] = 1.0 / max(float(deviation), 1e-12)
    return length


def _covariance(problem: _Problem, theta: np.ndarray, length: int) -> tuple[np.ndarray, np.ndarray]:
    """Weighted Jacobian over all unknowns (parameters, then sensors), and their covariance."""
    jacobian = np.hstack([problem.jacobian(theta), -problem.weighted_nuisance])
    left, _ = _left(problem, theta)
    priors = np.concatenate([np.zeros(theta.size), np.ones(problem.nuisance.shape[1])])
    groups = [place for _, _, place in _series(problem)]
    return jacobian, covariance.sandwich(jacobian, left, groups, length, priors)


def _unidentified(problem: _Problem, jacobian: np.ndarray, cov: np.ndarray) -> dict[str, str]:
    """The parameters to fix next, and why: those of a singular direction, else the one least known."""
    count = len(problem.free)
    q = _projector(problem)
    size = jacobian.shape[0]
    own = jacobian[:, :count]
    projected = np.vstack([own, np.zeros((q.shape[0] - size, count))]) - q @ (q[:size].T @ own)
    _, singular, directions_ = np.linalg.svd(projected, full_matrices=False)
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


def _rms(problem: _Problem, theta: np.ndarray) -> dict[str, float]:
    """Root mean square (SI) of measured - simulated by output, the sensors' errors taken off."""
    left, _ = _left(problem, theta)
    squares: dict[str, list[np.ndarray]] = {}
    for _, name, place in _series(problem):
        known = np.isfinite(problem.measured[place])
        squares.setdefault(name, []).append(((left / problem.weights)[place][known]) ** 2)
    return {name: float(np.sqrt(np.mean(np.concatenate(parts)))) for name, parts in squares.items()}


def _result(
    problem: _Problem,
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
    left, numbers = _left(problem, theta)
    residuals = left / problem.weights
    times: dict[str, np.ndarray] = {}
    simulated: dict[str, dict[str, np.ndarray]] = {}
    measured: dict[str, dict[str, np.ndarray]] = {}
    for item, name, place in _series(problem):
        path = str(item.record.path)
        times[path] = item.time
        measured.setdefault(path, {})[name] = item.measured[name]
        simulated.setdefault(path, {})[name] = problem.measured[place] - residuals[place]
    scales = np.outer(deviations[:count], deviations[:count])
    sensors = {}
    for name, std in problem.experiment.accuracies.items():
        if name in problem.sensors:
            place = problem.sensors.index(name)
            spread = std * deviations[count + place]
            value = std * float(numbers[place])
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
