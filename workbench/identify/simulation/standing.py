"""Whether a fit stands beside what is declared of what it held, and how well its parameters are known then."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.fitting import covariance
from workbench.identify.simulation import judgement
from workbench.identify.simulation.expected import expected_noise, rms_at, rms_of
from workbench.identify.simulation.problem import Problem, projected
from workbench.identify.simulation.searching import least
from workbench.identify.simulation.uncertain import AREAS, held_columns, movable, without_held

FEW = 4
"""Records below which the sandwich scatters too much to be trusted where it says less than (J'J)^-1, whose errors are
weighted by their long-run deviation already."""

MISFIT = 1.5
"""Residuals over the expected noise from which a deviation is no smaller than that over parts of the records."""

BLOCKS = 10
"""Parts of the records, at least."""


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


def judge(
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
    rms = rms_at(problem, theta)
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
    cov = covariance_of(problem, theta, jacobian, left, length, whole=misfit > MISFIT)
    cov += covariance.of_uncertain(jacobian, columns, np.ones(len(held)), _priors(problem))
    return Judged(rms, noise, "", held, cov)


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

    x = least(
        lambda x: np.concatenate([projected(q, wide.errors(x)), away(x)]),
        lambda x: np.vstack([projected(q, wide.jacobian(x)), slopes(x)]),
        np.concatenate([theta, np.zeros(len(names))]),
        wide.limits(),
    )
    left = np.asarray(wide.left(x)[0] * problem.weights / wide.weights)
    problem.evaluations = wide.evaluations
    return left


def _priors(problem: Problem) -> np.ndarray:
    """Which unknowns have a prior of unit standard deviation: those of the sensors."""
    return np.concatenate([np.zeros(len(problem.free)), np.ones(problem.nuisance.shape[1])])


def covariance_of(
    problem: Problem, theta: np.ndarray, jacobian: np.ndarray, left: np.ndarray, length: int, *, whole: bool = False
) -> np.ndarray:
    """Covariance of all unknowns from the weighted errors that are left; `whole`: also from whole parts of records."""
    priors, series = _priors(problem), problem.series()
    cov = covariance.sandwich(jacobian, left, [place for _, _, place in series], length, priors)
    if len(problem.observed) < FEW:
        plain = covariance.inverse(jacobian.T @ jacobian + np.diag(priors))
        scaled = jacobian * long_run(problem, left)[:, None]
        cov = covariance.at_least(cov, plain @ (scaled.T @ scaled + np.diag(priors)) @ plain)
    if whole:
        cov = covariance.at_least(cov, covariance.by_blocks(jacobian, left, _blocks(problem), priors))
    return cov


def long_run(problem: Problem, left: np.ndarray) -> np.ndarray:
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
