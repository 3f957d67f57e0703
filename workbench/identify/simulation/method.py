"""Identification by simulation error: the parameters with which the declared plant, driven by what was measured,
follows the record best."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field

import numpy as np
from scipy.optimize import least_squares

from plants.equation import NEGATIVE
from workbench.errors import UserError
from workbench.fitting import covariance
from workbench.fitting.replay import observe_all
from workbench.identify.simulation import judgement
from workbench.identify.simulation.problem import Problem, make_problem, projected
from workbench.progress import Progress, silent
from workbench.records.experiment import Experiment, parameter_names
from workbench.records.friction import directions
from workbench.records.reading import Record
from workbench.records.schema import FRICTION
from workbench.records.sliding import check_slides

FLAT, NEAR, MOST_STEPS = 1e-8, 1e-5, 60
"""A search ends when a step gains less of the sum of squares, or moves the unknowns less, than this."""

LOGARITHMIC_SCAN, LINEAR_SCAN, FARTHEST, MOST_SCANS = (-1.2, -0.4, 0.4, 1.2), (-2.0, -0.5, 0.5, 2.0), 2.4, 6
"""Steps of the unknowns in a coarse scan, how far it goes (11 times as much), and how often through all of them."""

INSIDE = 1e-9
"""A search starts this far inside its bounds."""

FEW = 4
"""Records below which the sandwich scatters too much to be trusted where it says less than (J'J)^-1, whose errors are
weighted by their long-run deviation already."""

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

    `unidentified` says of each parameter that the records cannot identify why; it is at its declared value. `bounded`
    are those at a bound of the experiment: value (SI), and which bound, in words; such a number has no deviation.
    `measured` and `simulated` are by record and output, in SI, over `times`; `rms` the residuals' by output.
    """

    estimates: Mapping[str, Fitted]
    correlation: np.ndarray
    unidentified: Mapping[str, str]
    sensors: Mapping[str, Fitted]
    rms: Mapping[str, float]
    before: Mapping[str, float]
    times: Mapping[Record, np.ndarray]
    simulated: Mapping[Record, Mapping[str, np.ndarray]]
    measured: Mapping[Record, Mapping[str, np.ndarray]]
    memory: float
    evaluations: int
    notes: tuple[str, ...] = ()
    bounded: Mapping[str, tuple[float, str]] = field(default_factory=dict)

    def to_json(self) -> dict[str, object]:
        """As identified.json holds it."""
        return {
            "unidentified": dict(self.unidentified),
            "notes": list(self.notes),
            "correlation": {"names": list(self.estimates), "matrix": self.correlation.tolist()},
            "sensors": {name: asdict(fitted) for name, fitted in self.sensors.items()},
            "rms": {"before": dict(self.before), "after": dict(self.rms)},
            "residual_memory_s": self.memory,
            "evaluations": self.evaluations,
        }


def default_free(experiment: Experiment, records: Sequence[Record]) -> list[str]:
    """Friction in the directions in which the records move, or what the plant is `unknown` by in its place; one value
    for both where the plant has one.
    """
    known, wanted = parameter_names(experiment.plant), experiment.plant.unknown or FRICTION
    moved = {sign for record in records for sign in directions(record, experiment)}
    apart = any(f"{name}_{NEGATIVE}" in experiment.values for name in wanted)
    names = [name for name in wanted if name in known and (1 in moved or not apart)]
    if -1 in moved and apart:
        names += [f"{name}_{NEGATIVE}" for name in wanted if f"{name}_{NEGATIVE}" in experiment.values]
    return names


def identify_by_simulation(
    experiment: Experiment, records: Sequence[Record], progress: Progress = silent
) -> SimulationFit:
    """Fit the free parameters to all records together.

    Each output is weighted by the long-run deviation of its own residuals, found in a first fit. A parameter that the
    records cannot identify is fixed at its declared value, one that reaches a bound of the experiment there, and the
    rest fitted again. `progress` is told in words what is being done.

    Raises:
        UserError: nothing to fit, or the plant cannot be simulated on these records, or follows them not at all.
    """
    observed = [part for record in records for part in observe_all(record, experiment)]
    free = list(experiment.free) if experiment.free is not None else default_free(experiment, records)
    if not free and experiment.free is None:
        check_slides(records, experiment)
    if not free:
        raise UserError(f"{experiment.path}: fit.free: is empty: expected at least one parameter")
    problem = make_problem(experiment, observed, free)
    problem.progress = progress
    theta = np.zeros(len(free))
    before = _rms(problem, theta)
    if experiment.plant.unknown:
        theta = _scanned(problem)
    unidentified = judgement.without_effect(problem, theta)
    if unidentified and experiment.plant.unknown and experiment.free is None:
        raise UserError(
            f"{experiment.path}: the records move, and the plant as it is declared does not: {', '.join(unidentified)} "
            "change nothing in it; is a dead band declared beyond the largest command, or a channel's unit wrong?"
        )
    theta = _without(problem, theta, unidentified)
    theta = _solve(problem, theta, rough=True)
    judgement.check_followed(problem, theta)
    bounded: dict[str, tuple[float, str]] = {}
    while True:
        problem.describe_sensors(theta)
        length = _reweight(problem, theta)
        theta = _solve(problem, theta)
        jacobian, cov = _covariance(problem, theta, length)
        if not problem.free:
            break
        given, astray = judgement.at_bounds(problem, theta)
        worst = {} if given else astray or judgement.not_identified(problem, theta, jacobian, cov)
        if not given and not worst:
            break
        bounded |= given
        problem.held |= {name: value for name, (value, _) in given.items()}
        unidentified |= worst
        theta = _without(problem, theta, {**given, **worst})
    judgement.check_followed(problem, theta)
    judgement.check_better(problem, before, _rms(problem, theta))
    return _result(problem, theta, cov, length, unidentified, bounded, before)


def _without(problem: Problem, theta: np.ndarray, names: Mapping[str, object]) -> np.ndarray:
    """Take parameters out of the search; returns the unknowns that stay."""
    keep = [i for i, name in enumerate(problem.free) if name not in names]
    problem.free = [problem.free[i] for i in keep]
    return theta[keep]


def _scanned(problem: Problem) -> np.ndarray:
    """The unknowns from which a search starts of which the valleys are narrow: of delays and dead bands.

    Each unknown in turn takes the best of some values far around its own, until none gets better.
    """
    theta, q = np.zeros(len(problem.free)), problem.projector()
    low, high = (np.clip(ends, -FARTHEST, FARTHEST) for ends in problem.limits())

    def left(x: np.ndarray) -> float:
        return float(np.sum(projected(q, problem.errors(x)) ** 2))

    best = left(theta)
    for _ in range(MOST_SCANS):
        before = best
        for i, name in enumerate(problem.free):
            steps = LOGARITHMIC_SCAN if problem.logarithmic(name) else LINEAR_SCAN
            for value in {float(np.clip(theta[i] + step, low[i], high[i])) for step in steps} - {float(theta[i])}:
                trial = theta.copy()
                trial[i] = value
                if (found := left(trial)) < best:
                    theta, best = trial, found
        if best == before:
            break
    return theta


def _solve(problem: Problem, theta: np.ndarray, *, rough: bool = False) -> np.ndarray:
    """The best unknowns: trust region, bounds; `rough` on the first way there."""
    if not problem.free:
        return theta
    q = problem.projector()
    low, high = problem.limits()
    solution = least_squares(
        lambda x: projected(q, problem.errors(x)),
        np.clip(theta, low + INSIDE, high - INSIDE),
        jac=lambda x: projected(q, problem.jacobian(x, rough=rough)),
        bounds=(low, high),
        ftol=FLAT,
        xtol=NEAR,
        gtol=None,
        max_nfev=MOST_STEPS,
    )
    return np.asarray(solution.x)


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
    cov = covariance.sandwich(jacobian, left, groups, length, priors)
    if len(problem.observed) < FEW:
        plain = covariance.inverse(jacobian.T @ jacobian + np.diag(priors))
        cov = covariance.at_least(cov, plain)
    return jacobian, cov


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
    bounded: Mapping[str, tuple[float, str]],
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
    times, measured, simulated = (dict[Record, dict[str, list[np.ndarray]]]() for _ in range(3))
    for item, name, place in problem.series():
        own = slice(place.start + item.warm, place.stop)
        for table, values in (
            (times, item.time[item.warm :]),
            (measured, problem.measured[own]),
            (simulated, (problem.measured - residuals)[own]),
        ):
            table.setdefault(item.of, {}).setdefault(name, []).append(values)
    scales = np.outer(deviations[:count], deviations[:count])
    sensors = {}
    for name, std in problem.experiment.accuracies.items():
        if name in problem.sensors:
            column = problem.sensors.index(name)
            spread = std * deviations[count + column]
            value = std * float(numbers[column])
            sensors[name] = Fitted(value, spread, value - NORMAL_95 * spread, value + NORMAL_95 * spread)
    rms = _rms(problem, theta)
    return SimulationFit(
        estimates=estimates,
        correlation=cov[:count, :count] / np.where(scales > 0.0, scales, 1.0),
        unidentified=unidentified,
        sensors=sensors,
        rms=rms,
        before=before,
        times={record: np.concatenate(next(iter(parts.values()))) for record, parts in times.items()},
        simulated={record: _joined(parts) for record, parts in simulated.items()},
        measured={record: _joined(parts) for record, parts in measured.items()},
        memory=length * float(problem.observed[0].count) * problem.observed[0].record.sample_time,
        evaluations=problem.evaluations,
        notes=judgement.remarks(problem, theta, rms),
        bounded=bounded,
    )


def _joined(parts: Mapping[str, Sequence[np.ndarray]]) -> dict[str, np.ndarray]:
    """The windows of each output one after the other."""
    return {name: np.concatenate(values) for name, values in parts.items()}
