"""Identification by simulation error: the parameters with which the declared plant, driven by what was measured,
follows the record best."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from plants.equation import NEGATIVE
from workbench.errors import UserError
from workbench.fitting import covariance
from workbench.fitting.replay import observe_all
from workbench.identify.simulation import judgement, starts
from workbench.identify.simulation.expected import expected_noise, rms_of
from workbench.identify.simulation.found import SimulationFit, result_of
from workbench.identify.simulation.integration import is_fine
from workbench.identify.simulation.problem import Problem, make_problem, projected
from workbench.identify.simulation.uncertain import AREAS, held_columns, movable, without_held
from workbench.progress import Progress, silent
from workbench.records.experiment import Experiment, parameter_names
from workbench.records.friction import directions
from workbench.records.reading import Record
from workbench.records.sampling.sight import SLOW
from workbench.records.schema import FRICTION
from workbench.records.sliding import check_slides

FLAT, NEAR, MOST_STEPS = 1e-8, 1e-5, 60
"""A search ends when a step gains less of the sum of squares, or moves the unknowns less, than this."""

INSIDE = 1e-9
"""A search starts this far inside its bounds."""

FEW = 4
"""Records below which the sandwich scatters too much to be trusted where it says less than (J'J)^-1, whose errors are
weighted by their long-run deviation already."""

MISFIT = 1.5
"""Residuals over the expected noise from which a deviation is no smaller than that over parts of the records."""

BLOCKS = 10
"""Parts of the records, at least."""

AS_HELD = "The command is held from sample to sample: the plant follows better then than with straight lines"

CLEARLY = 10.0
"""Sum of squares, in those of the noise, by which a command that is held has to leave less than straight lines."""

MOST_REFINEMENTS = 2
"""Times that the step of integration is halved because a fit would take its error for information."""


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
        theta = starts.scanned(problem)
    unidentified = judgement.without_effect(problem, theta)
    if unidentified and experiment.plant.unknown and experiment.free is None:
        raise UserError(
            f"{experiment.path}: the records move, and the plant as it is declared does not: {', '.join(unidentified)} "
            "change nothing in it; is a dead band declared beyond the largest command, or a channel's unit wrong?"
        )
    theta = _without(problem, theta, unidentified)
    theta = _best(problem, _solve(problem, theta, rough=True))
    problem, theta = _as_driven(problem, theta)
    judgement.check_followed(problem, theta)
    bounded: dict[str, tuple[float, str]] = {}
    standing: Standing | None = None
    refinements = 0
    while True:
        problem.describe_sensors(theta)
        length = _reweight(problem, theta)
        theta = _solve(problem, theta)
        jacobian = _whole_jacobian(problem, theta)
        cov = _covariance(problem, theta, jacobian, problem.left(theta)[0], length)
        if not problem.free:
            judged = _judged(problem, theta, jacobian, length, before, check=standing is None)
            break
        if refinements < MOST_REFINEMENTS and not is_fine(problem, theta, jacobian, cov):
            problem.refine()
            refinements += 1
            continue
        given, astray = judgement.at_bounds(problem, theta)
        worst = {} if given else astray or judgement.not_identified(problem, theta, jacobian, cov)
        if not given and not worst:
            judged = _judged(problem, theta, jacobian, length, before, check=standing is None)
            if judged.refuted and standing is not None:
                break
            worst = {} if judged.refuted else judgement.least_known(problem, theta, judged.cov)
            if worst:
                kept = replace(problem, held=dict(problem.held))
                standing = Standing(kept, theta, length, judged, dict(unidentified), dict(bounded), worst)
        if not given and not worst:
            break
        bounded |= given
        problem.held |= {name: value for name, (value, _) in given.items()}
        unidentified |= worst
        theta = _without(problem, theta, {**given, **worst})
    kept_notes: tuple[str, ...] = ()
    if judged.refuted and standing is not None:  # the plant cannot be as declared in what was given up
        problem, theta, length, judged = standing.problem, standing.theta, standing.length, standing.judged
        unidentified, bounded = standing.unidentified, standing.bounded
        kept_notes = tuple(
            f"{name} is hardly known, {why}, and cannot stay as declared: the records refute the plant then"
            for name, why in standing.given_up.items()
        )
    notes = (
        *judgement.remarks(problem, theta),
        *judgement.held_remarks([] if judged.refuted else judged.held),
        *(AS_HELD for _ in problem.observed[:1] if problem.observed[0].held),
        *kept_notes,
    )
    return result_of(
        problem,
        theta,
        cov if judged.refuted else judged.cov,
        length,
        unidentified,
        bounded,
        before,
        judged.rms,
        judged.noise,
        judged.refuted,
        notes,
    )


@dataclass(frozen=True, eq=False)
class Judged:
    """A fit with what is declared of parameters that it held: the errors that it leaves and those of the noise, by
    output (SI), by how much these refute it, in words; the covariance of all unknowns if they do not.
    """

    rms: Mapping[str, float]
    noise: Mapping[str, float]
    refuted: str
    held: Sequence[str]
    cov: np.ndarray


@dataclass(frozen=True, eq=False)
class Standing:
    """A fit that its records do not refute, in which a parameter is hardly known and `given_up` next: it stands if what
    follows is refuted.
    """

    problem: Problem
    theta: np.ndarray
    length: int
    judged: Judged
    unidentified: dict[str, str]
    bounded: dict[str, tuple[float, str]]
    given_up: Mapping[str, str]


def _judged(
    problem: Problem,
    theta: np.ndarray,
    jacobian: np.ndarray,
    length: int,
    before: Mapping[str, float],
    *,
    check: bool = True,
) -> Judged:
    """Judge a fit; with `check` also whether it is worth anything.

    Raises:
        UserError: the plant follows the records not at all, or worse than as declared.
    """
    rms = _rms(problem, theta)
    if check:
        judgement.check_followed(problem, theta)
        judgement.check_better(problem, before, rms)
    noise = expected_noise(problem, theta, jacobian[:, : theta.size])
    columns, held = held_columns(problem, theta)
    left = _beyond_held(problem, theta, jacobian, columns, held, noise)
    beyond = rms_of(problem, left)
    refuted = judgement.refuted(beyond, noise)
    if refuted and held:
        left = _beyond_first_order(problem, theta, noise)
        beyond = rms_of(problem, left)
        refuted = judgement.refuted(beyond, noise)
    if refuted:
        return Judged(rms, noise, judgement.refuted(rms, noise) or refuted, held, np.zeros((0, 0)))
    misfit = max(beyond[name] / noise[name] for name in beyond)
    cov = _covariance(problem, theta, jacobian, left, length, whole=misfit > MISFIT)
    cov += covariance.of_uncertain(jacobian, columns, np.ones(len(held)), _priors(problem))
    return Judged(rms, noise, "", held, cov)


def _best(problem: Problem, theta: np.ndarray) -> np.ndarray:
    """The best unknowns of searches from several starts, where the first one ended far from the noise."""
    if not problem.free:
        return theta
    jacobian = problem.jacobian(theta, rough=True)
    noise = expected_noise(problem, theta, jacobian)
    if not judgement.refuted(_rms(problem, theta), noise):
        return theta
    whole = np.hstack([jacobian, -problem.weighted_nuisance])
    left = without_held(problem, theta, whole, *held_columns(problem, theta))
    if not judgement.refuted(rms_of(problem, left), noise):
        return theta
    found = [theta, *(_solve(problem, start, rough=True) for start in starts.others(problem))]
    problem.forget()
    return min(found, key=lambda each: starts.left(problem, each))


def _as_driven(problem: Problem, theta: np.ndarray) -> tuple[Problem, np.ndarray]:
    """The problem with the command held from sample to sample, as a computer's is, where that leaves clearly less than
    straight lines; of a slow log nobody knows its way.
    """
    if not problem.free or any(item.of.sample_time > SLOW for item in problem.observed):
        return problem, theta
    other = problem.with_command_held()
    other.describe_sensors(theta)
    found = _solve(other, theta, rough=True)
    if starts.left(other, found) < starts.left(problem, theta) - CLEARLY:
        return other, found
    problem.forget()
    return problem, theta


def _beyond_held(
    problem: Problem,
    theta: np.ndarray,
    jacobian: np.ndarray,
    columns: np.ndarray,
    held: Sequence[str],
    noise: Mapping[str, float],
) -> np.ndarray:
    """Weighted errors without what is held explains of them, weighed against what is declared by the noise (SI).

    By the weights of the fit, which know a misfit only as noise, what is declared would count for more than it should.
    """
    by_noise = replace(problem, weights=_by_noise(problem, noise))  # what was simulated holds for both
    ratio = (by_noise.weights / problem.weights)[:, None]
    left = without_held(by_noise, theta, ratio * jacobian, ratio * columns, held)
    problem.evaluations = by_noise.evaluations
    return np.asarray(left / ratio[:, 0])


def _by_noise(problem: Problem, noise: Mapping[str, float]) -> np.ndarray:
    """Weights by the noise (SI) of each output."""
    return np.concatenate([np.full(place.stop - place.start, 1.0 / noise[name]) for _, name, place in problem.series()])


def _beyond_first_order(problem: Problem, theta: np.ndarray, noise: Mapping[str, float]) -> np.ndarray:
    """The same by a fit of what is held, too, each weighed against what is declared of it: what sticks, and a plant
    that nothing leads, goes other ways than first order says.
    """
    names = [name for name in movable(problem) if name not in AREAS]
    declared = {name: problem.experiment.values[name] for name in names}
    wide = replace(
        problem,
        free=[*problem.free, *names],
        start={**problem.start, **declared},
        weights=_by_noise(problem, noise),
        known={},
        idle={},
    )
    count, q = len(problem.free), wide.projector()
    stds = np.array([problem.experiment.deviations[name] for name in names])

    def away(x: np.ndarray) -> np.ndarray:
        values = [wide.value(name, float(each)) for name, each in zip(names, x[count:], strict=True)]
        return np.asarray((np.array(values) - np.array(list(declared.values()))) / stds)

    def slopes(x: np.ndarray) -> np.ndarray:
        own = [wide.slope(name, float(each)) for name, each in zip(names, x[count:], strict=True)]
        return np.hstack([np.zeros((len(names), count)), np.diag(np.array(own) / stds)])

    low, high = wide.limits()
    solution = least_squares(
        lambda x: np.concatenate([projected(q, wide.errors(x)), away(x)]),
        np.clip(np.concatenate([theta, np.zeros(len(names))]), low + INSIDE, high - INSIDE),
        jac=lambda x: np.vstack([projected(q, wide.jacobian(x)), slopes(x)]),
        bounds=(low, high),
        ftol=FLAT,
        xtol=NEAR,
        gtol=None,
        max_nfev=MOST_STEPS,
    )
    left = np.asarray(wide.left(solution.x)[0] * problem.weights / wide.weights)
    problem.evaluations = wide.evaluations
    return left


def _without(problem: Problem, theta: np.ndarray, names: Mapping[str, object]) -> np.ndarray:
    """Take parameters out of the search; returns the unknowns that stay."""
    keep = [i for i, name in enumerate(problem.free) if name not in names]
    problem.free = [problem.free[i] for i in keep]
    return theta[keep]


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
    length = covariance.long_run_length([residuals[place] for _, _, place in problem.series()])
    problem.weights = 1.0 / np.maximum(_long_run(problem, residuals), 1e-12)
    return length


def _whole_jacobian(problem: Problem, theta: np.ndarray) -> np.ndarray:
    """Weighted Jacobian over all unknowns: parameters, then sensors."""
    return np.hstack([problem.jacobian(theta), -problem.weighted_nuisance])


def _priors(problem: Problem) -> np.ndarray:
    """Which unknowns have a prior of unit standard deviation: those of the sensors."""
    return np.concatenate([np.zeros(len(problem.free)), np.ones(problem.nuisance.shape[1])])


def _covariance(
    problem: Problem, theta: np.ndarray, jacobian: np.ndarray, left: np.ndarray, length: int, *, whole: bool = False
) -> np.ndarray:
    """Covariance of all unknowns from the weighted errors that are left; `whole`: also from whole parts of records."""
    priors, series = _priors(problem), problem.series()
    cov = covariance.sandwich(jacobian, left, [place for _, _, place in series], length, priors)
    if len(problem.observed) < FEW:
        plain = covariance.inverse(jacobian.T @ jacobian + np.diag(priors))
        scaled = jacobian * _long_run(problem, left)[:, None]
        cov = covariance.at_least(cov, plain @ (scaled.T @ scaled + np.diag(priors)) @ plain)
    if whole:
        cov = covariance.at_least(cov, covariance.by_blocks(jacobian, left, _blocks(problem), priors))
    return cov


def _long_run(problem: Problem, left: np.ndarray) -> np.ndarray:
    """The long-run deviation of each output's weighted errors, at each sample."""
    deviations, series = np.zeros(left.size), problem.series()
    for output in {name for _, name, _ in series}:
        parts = [place for _, name, place in series if name == output]
        memory = covariance.long_run_length([left[place] for place in parts])
        squares = [covariance.long_run_deviation(left[place], memory) ** 2 for place in parts]
        for place in parts:
            deviations[place] = np.sqrt(np.mean(squares))
    return deviations


def _blocks(problem: Problem) -> np.ndarray:
    """The number of the part of the records in which each sample is: at least `BLOCKS` in all, none in two records."""
    logs = list(dict.fromkeys(item.of for item in problem.observed))
    parts = -(-BLOCKS // len(logs))
    blocks = np.full(problem.measured.size, -1)
    for item, _, place in problem.series():
        share = (item.time[: place.stop - place.start] - item.of.time[0]) / item.of.time[-1]
        blocks[place] = logs.index(item.of) * parts + np.clip((share * parts).astype(int), 0, parts - 1)
    blocks[~np.isfinite(problem.measured)] = -1
    return np.unique(blocks, return_inverse=True)[1] - (1 if np.any(blocks < 0) else 0)


def _rms(problem: Problem, theta: np.ndarray) -> dict[str, float]:
    """Root mean square (SI) of measured - simulated by output, the sensors' errors taken off."""
    return rms_of(problem, problem.left(theta)[0])
