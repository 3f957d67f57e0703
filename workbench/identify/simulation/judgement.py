"""What a fit by simulation is worth: which parameters the records cannot tell, which are at a bound, does it follow."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from plants.axis import unit_along
from workbench.errors import UserError
from workbench.identify.simulation.problem import Problem, noise_of, projected
from workbench.parameters.sets import known_units
from workbench.publish.along import SHOWN
from workbench.records.schema import NUISANCES

UNKNOWN = 0.5
"""Standard deviation, as a share of a parameter as declared or found, from which it counts as not identified."""

LARGEST_TOLD = 10.0
"""A relative standard deviation beyond this is told as such: its digits mean nothing."""

SINGULAR = 1e-4
"""Ratio of a singular value of the Jacobian, its columns of one length, to the largest below which a direction is not
identified: one parameter may be known a million times better than another."""

SHARE = 0.3
"""Part in such a direction from which a parameter is named."""

AT_BOUND = 1e-3
"""An unknown nearer than this to its bound (relative, of a logarithmic one) is at it."""

LOST = 0.7
"""Residuals above this share of an output's own deviation: the plant does not follow it at all."""

WORSE = 1.05
"""Ratio of the residuals after a fit to those before from which it made things worse."""

SEEN = 10.0
"""An output whose deviation is less than so many times its noise shows nothing that could be followed."""

FAR = 3.0
"""Standard deviations from which a sensor's error is told to be implausible."""

NOISY = 5.0
"""Residuals of so many times the noise that is expected refute the plant: of its numbers none is identified."""

NO_EFFECT = "has no effect on the records"


def without_effect(problem: Problem, theta: np.ndarray) -> dict[str, str]:
    """The free parameters that change nothing in any record, and why they cannot be found."""
    moved = np.any(problem.jacobian(theta, rough=True) != 0.0, axis=0)
    return {name: NO_EFFECT for name, any_ in zip(problem.free, moved, strict=True) if not any_}


def not_identified(problem: Problem, theta: np.ndarray, jacobian: np.ndarray, cov: np.ndarray) -> dict[str, str]:
    """The parameters to fix next, and why: those of a singular direction, else the one least known."""
    count = len(problem.free)
    own = projected(problem.projector(), jacobian[:, :count])
    size = np.linalg.norm(own, axis=0)
    _, singular, directions = np.linalg.svd(own / np.where(size > 0.0, size, 1.0), full_matrices=False)
    if singular[-1] <= SINGULAR * singular[0]:
        parts = np.abs(directions[-1])
        named = [problem.free[i] for i in np.flatnonzero(parts > SHARE)]
        worst = problem.free[int(np.argmax(parts))]
        others = [name for name in named if name != worst]
        why = f"cannot be told apart from {', '.join(others)}" if others else NO_EFFECT
        return {worst: why}
    return least_known(problem, theta, cov)


def least_known(problem: Problem, theta: np.ndarray, cov: np.ndarray) -> dict[str, str]:
    """The parameter of the largest relative deviation, if that is more than half, and why it is to be fixed."""
    spread = np.sqrt(np.maximum(np.diag(cov)[: len(problem.free)], 0.0)).tolist()
    deviations = [problem.relative(*each) for each in zip(problem.free, theta.tolist(), spread, strict=True)]
    if max(deviations) <= UNKNOWN:
        return {}
    i = int(np.argmax(deviations))
    return {problem.free[i]: f"standard deviation {percent(deviations[i])} of its value"}


def percent(ratio: float) -> str:
    """A relative standard deviation in words."""
    return f"above {100.0 * LARGEST_TOLD:.0f} %" if ratio > LARGEST_TOLD else f"{100.0 * ratio:.0f} %"


def at_bounds(problem: Problem, theta: np.ndarray) -> tuple[dict[str, tuple[float, str]], dict[str, str]]:
    """The free parameters at a bound of the experiment (value in SI, in words), and those that run out of all bounds.

    The latter are at the bound that the program sets where the experiment sets none: the records do not hold them. What
    may vanish does not run away downwards: it is smaller than the records show.
    """
    given: dict[str, tuple[float, str]] = {}
    astray: dict[str, str] = {}
    for name, x, low, high in zip(
        problem.free, theta.tolist(), *(ends.tolist() for ends in problem.limits()), strict=True
    ):
        end = low if x - low < AT_BOUND else high if high - x < AT_BOUND else None
        if end is None:
            continue
        value, unit = problem.value(name, end), known_units(problem.axis)[name]
        own = problem.experiment.bounds.get(name, (-np.inf, np.inf))
        if np.isclose(value, own[0 if end == low else 1], rtol=1e-9, atol=0.0):
            given[name] = (value, f"at its bound of {value:.6g} {unit}")
        elif end == low and problem.shift(name):
            given[name] = (value, f"at {value:.6g} {unit}: less than the records show")
        else:
            astray[name] = f"the fit runs away, to {value:.4g} {unit} and beyond; give it bounds, or free less"
    return given, astray


def check_followed(problem: Problem, theta: np.ndarray) -> None:
    """Whether the fitted plant follows every record at all.

    Raises:
        UserError: an output of which it follows nothing.
    """
    left, _ = problem.left(theta)
    residuals = left / problem.weights
    lost: dict[str, list[tuple[float, str]]] = {}
    seen: dict[str, None] = {}
    windows: dict[tuple[int, Path, str], list[slice]] = {}
    for item, name, place in problem.series():
        windows.setdefault((item.of.log, item.of.path, name), []).append(place)
    for (_, path, name), places in windows.items():
        values = [problem.measured[place] for place in places]
        varied = _rms([each - np.nanmean(each) for each in values])
        if varied < SEEN * _rms([np.array([noise_of(each)]) for each in values]):
            continue
        seen[name] = None
        known = [np.isfinite(each) for each in values]
        off = _rms([residuals[place][own] for place, own in zip(places, known, strict=True)])
        if not off < LOST * varied:
            by = f"{name} is off by {_number(problem, name, off)} rms and varies by {_number(problem, name, varied)}"
            lost.setdefault(name, []).append((off / varied, f"does not follow {path}: {by}"))
    moving: list[str] = [name for name in ("position", "rotation_speed") if name in seen]
    moving = moving or list(seen)
    if moving and all(name in lost for name in moving):
        _, worst = max(lost[moving[0]])
        raise UserError(
            f"plant {problem.experiment.plant.name} {worst}; is a sign or a unit in [channels] wrong, "
            f"{_or_lacks(problem)}"
        )


def check_better(problem: Problem, before: Mapping[str, float], after: Mapping[str, float]) -> None:
    """Whether the fit is worth more than the declared plant.

    Raises:
        UserError: every output is followed worse than before.
    """
    if all(after[name] > WORSE * before[name] for name in before):
        name = next(iter(before))
        raise UserError(
            f"{problem.experiment.path}: the fit does not follow the records, {name} worse than as declared "
            f"({_number(problem, name, after[name])} rms, before {_number(problem, name, before[name])}); "
            f"is a sign, a unit or a bound wrong, {_or_lacks(problem)}"
        )


def _or_lacks(problem: Problem) -> str:
    """The other question where a plant does not follow its records, and who answers it."""
    return f"or does the plant lack something? workbench diagnose {problem.experiment.path} looks for it"


def refuted(rms: Mapping[str, float], noise: Mapping[str, float]) -> str:
    """How much more than noise a fit leaves, in words; "" where that may be noise."""
    over = {name: rms[name] / noise[name] for name in rms if rms[name] > NOISY * noise[name]}
    if not over:
        return ""
    left = " and ".join(f"{name} {ratio:.0f} times" for name, ratio in sorted(over.items(), key=lambda each: -each[1]))
    return f"the fit leaves residuals far above the noise, of {left} as much"


def remarks(problem: Problem, theta: np.ndarray) -> tuple[str, ...]:
    """What is suspicious about a fit: sensors' errors beyond what is declared."""
    suspicions = []
    _, numbers = problem.left(theta)
    for name, std in problem.experiment.accuracies.items():
        if name not in problem.sensors:
            continue
        number = float(numbers[problem.sensors.index(name)])
        if abs(number) > FAR:
            given = f"{std:.3g} {unit_along(NUISANCES[name], problem.axis)}"
            suspicions.append(
                f"{name} is {abs(number):.0f} times the standard deviation that [sensors] gives it "
                f"({given}): the unit or the sign of a channel may be wrong"
            )
    return tuple(suspicions)


def held_remarks(held: Sequence[str]) -> tuple[str, ...]:
    """What was not fitted and is in the deviations."""
    return (f"The deviations include those of what was not fitted: {', '.join(held)}",) if held else ()


def _rms(parts: Sequence[np.ndarray]) -> float:
    """Of all their values that are known."""
    return float(np.sqrt(np.nanmean(np.concatenate(parts) ** 2)))


def _number(problem: Problem, output: str, value: float) -> str:
    """A deviation of an output as it is told."""
    if output == "position":
        return SHOWN[problem.axis].plain(value, 3)
    return f"{1e-3 * value:.3g} kPa" if output.startswith("pressure") else f"{value:.3g}"
