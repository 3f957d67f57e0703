"""Identification by simulation error: the parameters with which the declared plant, driven by what was measured,
follows the record best."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from plants.equation import NEGATIVE
from workbench.errors import UserError
from workbench.fitting import covariance
from workbench.fitting.replay import observe_all
from workbench.identify.simulation import judgement, starts
from workbench.identify.simulation.expected import expected_noise, rms_at, rms_of
from workbench.identify.simulation.found import SimulationFit, result_of
from workbench.identify.simulation.integration import is_fine
from workbench.identify.simulation.problem import Problem, make_problem
from workbench.identify.simulation.searching import solve
from workbench.identify.simulation.standing import Standing, covariance_of, judge, long_run
from workbench.identify.simulation.uncertain import held_columns, without_held
from workbench.progress import Progress, silent
from workbench.records.experiment import Experiment, parameter_names
from workbench.records.friction import directions
from workbench.records.reading import Record
from workbench.records.sampling.sight import SLOW
from workbench.records.schema import FRICTION
from workbench.records.sliding import check_slides

AS_HELD = "The command is held from sample to sample: the plant follows better then than with straight lines"

CLEARLY = 10.0
"""Sum of squares, in those of the noise, by which a command that is held has to leave less than straight lines."""

MOST_WEIGHINGS, FAR_LESS = 3, 0.7
"""Times that a fit is weighed by what it leaves, at most, and share of an output's rms that the start left up to which
it is weighed once more.
"""

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
    before = rms_at(problem, theta)
    if experiment.plant.unknown:
        theta = starts.scanned(problem)
    unidentified = judgement.without_effect(problem, theta)
    if unidentified and experiment.plant.unknown and experiment.free is None:
        raise UserError(
            f"{experiment.path}: the records move, and the plant as it is declared does not: {', '.join(unidentified)} "
            "change nothing in it; is a dead band declared beyond the largest command, or a channel's unit wrong?"
        )
    theta = _without(problem, theta, unidentified)
    theta = _best(problem, solve(problem, theta, rough=True))
    problem, theta = _as_driven(problem, theta)
    judgement.check_followed(problem, theta)
    bounded: dict[str, tuple[float, str]] = {}
    standing: Standing | None = None
    refinements = 0
    while True:
        theta, length = _solved(problem, theta)
        jacobian = _whole_jacobian(problem, theta)
        cov = covariance_of(problem, theta, jacobian, problem.left(theta)[0], length)
        if not problem.free:
            judged = judge(problem, theta, jacobian, length, before, check=standing is None)
            break
        if refinements < MOST_REFINEMENTS and not is_fine(problem, theta, jacobian, cov):
            problem.refine()
            refinements += 1
            continue
        given, astray = judgement.at_bounds(problem, theta)
        worst = {} if given else astray or judgement.not_identified(problem, theta, jacobian, cov)
        if not given and not worst:
            judged = judge(problem, theta, jacobian, length, before, check=standing is None)
            worst = {} if judged.refuted else judgement.least_known(problem, theta, judged.cov)
            if not worst:
                break
            kept = replace(problem, held=dict(problem.held))
            standing = Standing(kept, theta, length, judged, dict(unidentified), dict(bounded), worst)
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


def _best(problem: Problem, theta: np.ndarray) -> np.ndarray:
    """The best unknowns of searches from several starts, where the first one ended far from the noise."""
    if not problem.free:
        return theta
    jacobian = problem.jacobian(theta, rough=True)
    noise = expected_noise(problem, theta, jacobian)
    if not judgement.refuted(rms_at(problem, theta), noise):
        return theta
    whole = np.hstack([jacobian, -problem.weighted_nuisance])
    left = without_held(problem, theta, whole, *held_columns(problem, theta))
    if not judgement.refuted(rms_of(problem, left), noise):
        return theta
    found = [theta, *(solve(problem, start, rough=True) for start in starts.others(problem))]
    problem.forget()
    return min(found, key=lambda each: starts.left(problem, each))


def _as_driven(problem: Problem, theta: np.ndarray) -> tuple[Problem, np.ndarray]:
    """The problem with the command held from sample to sample, as a computer's is, where that leaves clearly less than
    straight lines; of a slow log nobody knows its way.
    """
    if not problem.free or any(item.of.sample_time > SLOW for item in problem.observed):
        return problem, theta
    other = problem.with_command_held()
    if other.can_be(theta):
        other.describe_sensors(theta)
        found = solve(other, theta, rough=True)
        if starts.left(other, found) < starts.left(problem, theta) - CLEARLY:
            return other, found
    problem.forget()
    return problem, theta


def _without(problem: Problem, theta: np.ndarray, names: Mapping[str, object]) -> np.ndarray:
    """Take parameters out of the search; returns the unknowns that stay."""
    keep = [i for i, name in enumerate(problem.free) if name not in names]
    problem.free = [problem.free[i] for i in keep]
    return theta[keep]


def _solved(problem: Problem, theta: np.ndarray) -> tuple[np.ndarray, int]:
    """The best unknowns by the weights of what they leave, and its memory (samples): by those of a start that left far
    more nothing is known of noise.
    """
    before = rms_at(problem, theta)
    for _ in range(MOST_WEIGHINGS):
        problem.describe_sensors(theta)
        length = _reweight(problem, theta)
        theta = solve(problem, theta)
        after = rms_at(problem, theta)
        if all(after[name] > FAR_LESS * before[name] for name in before):
            break
        before = after
    return theta, length


def _reweight(problem: Problem, theta: np.ndarray) -> int:
    """Weight each output by the long-run deviation of its residuals; returns the residuals' memory (samples)."""
    left, _ = problem.left(theta)
    residuals = left / problem.weights
    length = covariance.long_run_length([residuals[place] for _, _, place in problem.series()])
    problem.weights = 1.0 / np.maximum(long_run(problem, residuals), 1e-12)
    return length


def _whole_jacobian(problem: Problem, theta: np.ndarray) -> np.ndarray:
    """Weighted Jacobian over all unknowns: parameters, then sensors."""
    return np.hstack([problem.jacobian(theta), -problem.weighted_nuisance])
