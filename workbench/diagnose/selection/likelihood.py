"""What sets of effects would gain in likelihood, to first order: from the columns of all, with no further fit."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np
from scipy.stats import chi2

from workbench.diagnose.residuals.balance import SIMULATION
from workbench.diagnose.residuals.fit import Fit, weighed_without
from workbench.diagnose.residuals.weighing import Weighing
from workbench.diagnose.selection.trials import Columns, Trial
from workbench.fitting.least_squares import bounded_minimum

FALSE_ALARMS = 0.01
"""Of a machine that lacks nothing: probability that any of its candidates is asked for less than it gains by noise."""


def asked(numbers: int, candidates: int) -> float:
    """Gain in the logarithm of the likelihood that an effect sized by so many numbers has to exceed, one of so many
    candidates, each of its shapes one: its quantile where there is none (Wilks 1938), each candidate with its share of
    `FALSE_ALARMS`.
    """
    return 0.5 * float(chi2.isf(FALSE_ALARMS / max(candidates, 1), numbers))


TIMES = 3
"""Times that noise is found anew as what is left with some columns."""


def gain_of(fitted: Fit, block: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[float, np.ndarray]:
    """By how much the logarithm of the likelihood rises, to first order, with columns (rows, numbers; not weighed)
    between bounds beside a fit's own unknowns, and how far they go.

    What is missing is coloured, and may pass for noise: with the columns and without them noise is what is left.
    """
    own = fitted.changes * fitted.free
    x, weighing, left = _settled(fitted, np.column_stack([own, block]), low, high)
    if fitted.balance.name == SIMULATION:
        noise, without = _own_noise(fitted)
        return likelier((weighing, left), (noise, without)), x[own.shape[1] :]
    columns, residual = weighing(np.column_stack([own, block])), weighing(fitted.residual)
    curvature, slope = columns.T @ columns, columns.T @ residual
    count = own.shape[1]
    curvature[:count, :count] += _vague(fitted)
    wide = np.full(count, np.inf)
    before, _ = _fallen(curvature[:count, :count], slope[:count], -wide, wide)
    fallen, _ = _fallen(curvature, slope, np.concatenate([-wide, low]), np.concatenate([wide, high]))
    return fallen - before, x[count:]


def likelier(one: tuple[Weighing, np.ndarray], other: tuple[Weighing, np.ndarray]) -> float:
    """By how much the logarithm of the likelihood of a residual by its noise is above that of another by its own."""
    (weighing, residual), (beside, rest) = one, other
    counts = weighing.counts & beside.counts
    return weighing.log_likelihood(residual, counts) - beside.log_likelihood(rest, counts)


def _settled(
    fitted: Fit, stack: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, Weighing, np.ndarray]:
    """How far columns go, of which the first are a fit's own unknowns; the noise then, and what is left."""
    count, residual, weigh = len(fitted.unknowns), fitted.residual, fitted.weighing
    wide = np.full(count, np.inf)
    low, high = np.concatenate([-wide, low]), np.concatenate([wide, high])
    x, left = np.zeros(stack.shape[1]), residual
    for _ in range(TIMES):
        columns = weigh(stack)
        curvature = columns.T @ columns
        curvature[:count, :count] += _vague(fitted)
        _, x = _fallen(curvature, columns.T @ weigh(residual), low, high)
        left = np.where(residual != 0.0, residual + stack @ x, 0.0)
        weigh = weighed_without(fitted, left)
    return x, weigh, left


@lru_cache(maxsize=2)
def _own_noise(fitted: Fit) -> tuple[Weighing, np.ndarray]:
    """The noise that a fit leaves by itself, and what it leaves."""
    nothing = np.zeros(0)
    return _settled(fitted, fitted.changes * fitted.free, nothing, nothing)[1:]


def _vague(fitted: Fit) -> np.ndarray:
    """What is known of a fit's unknowns before any record, as a curvature."""
    return fitted.curvature - fitted.jacobian.T @ fitted.jacobian


def _fallen(curvature: np.ndarray, slope: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[float, np.ndarray]:
    x = bounded_minimum(curvature, slope, low, high)
    return -float(slope @ x + 0.5 * x @ curvature @ x), x


@dataclass(frozen=True, eq=False)
class Proposal:
    """A set of effects to be fitted: what it adds and drops, its expected gain less what is asked, where it starts."""

    added: tuple[Trial, ...]
    dropped: tuple[str, ...]
    gain: float
    score: float
    start: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Outlook:
    """What is to be expected of effects beside a fit, in the likelihood of its noise."""

    fitted: Fit
    columns: Mapping[Trial, Columns]
    _alone: dict[Trial, Proposal] = field(default_factory=dict)

    @cached_property
    def _whole(self) -> tuple[np.ndarray, np.ndarray, dict[Trial, list[int]]]:
        """Curvature and slope of half the squares over the fit's unknowns and all trials' numbers, and their places."""
        own = self.fitted.jacobian * self.fitted.free
        blocks, places, at = [own], {}, own.shape[1]
        for trial, columns in self.columns.items():
            blocks.append(columns.block)
            places[trial] = list(range(at, at + columns.block.shape[1]))
            at += columns.block.shape[1]
        stack = np.column_stack(blocks)
        curvature = stack.T @ stack
        known = np.zeros(at)
        known[: own.shape[1]] = np.diag(self.fitted.curvature) - np.diag(self.fitted.jacobian.T @ self.fitted.jacobian)
        curvature += np.diag(known)
        return curvature, stack.T @ self.fitted.weighed, places

    def gain(
        self, added: Sequence[Trial], moved: Mapping[int, float] | None = None
    ) -> tuple[float, dict[Trial, np.ndarray]]:
        """By how much the logarithm of the likelihood rises with these, and how far their numbers move; `moved` are
        unknowns of the fit that are taken elsewhere, as a search sees them.
        """
        curvature, slope, places = self._whole
        fixed = moved or {}
        count = len(self.fitted.unknowns)
        rest = [i for i in range(count) if i not in fixed]
        new = [i for trial in added for i in places[trial]]
        away = np.array(list(fixed.values()))
        shift = curvature[:, list(fixed)] @ away if fixed else np.zeros(slope.size)
        risen = (
            float(slope[list(fixed)] @ away + 0.5 * away @ curvature[np.ix_(list(fixed), list(fixed))] @ away)
            if fixed
            else 0.0
        )
        g, free = slope + shift, [*rest, *new]
        low = np.concatenate([np.full(len(rest), -np.inf), *(self.columns[trial].low for trial in added)])
        high = np.concatenate([np.full(len(rest), np.inf), *(self.columns[trial].high for trial in added)])
        x = bounded_minimum(curvature[np.ix_(free, free)], g[free], low, high)
        fallen = -float(g[free] @ x + 0.5 * x @ curvature[np.ix_(free, free)] @ x)
        reached, at = {}, len(rest)
        for trial in added:
            size = len(places[trial])
            reached[trial] = x[at : at + size]
            at += size
        return fallen - risen, reached

    def alone(self, trial: Trial, price: float) -> Proposal:
        """One trial, by the noise that it would leave itself."""
        if trial not in self._alone:
            columns = self.columns[trial]
            gain, x = gain_of(self.fitted, columns.change, columns.low, columns.high)
            self._alone[trial] = Proposal((trial,), (), gain, gain, columns.values(x))
        known = self._alone[trial]
        return replace(known, score=known.gain - price)

    def proposal(self, added: Sequence[Trial], dropped: Mapping[str, Mapping[int, float]], price: float) -> Proposal:
        """The set with these added and dropped, for what it costs."""
        moved = {i: away for own in dropped.values() for i, away in own.items()}
        gain, reached = self.gain(added, moved)
        start = {name: value for trial, x in reached.items() for name, value in self.columns[trial].values(x).items()}
        return Proposal(tuple(added), tuple(dropped), gain, gain - price, start)


def effects_of(trials: Collection[Trial]) -> tuple[str, ...]:
    """Their effects, in order, each once."""
    return tuple(dict.fromkeys(trial.effect for trial in trials))
