"""What sets of effects would gain in likelihood, to first order: from the columns of all, with no further fit."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np
from scipy.stats import chi2

from workbench.diagnose.residuals.balance import SIMULATION, Balance
from workbench.diagnose.residuals.fit import Fit, weighed_without
from workbench.diagnose.residuals.weighing import Weighing
from workbench.diagnose.selection.trials import Columns, Trial
from workbench.fitting.least_squares import bounded_minimum

FALSE_ALARMS = 0.01
"""Of a machine that lacks nothing: probability that any of its candidates is asked for less than it gains by noise."""


@lru_cache(maxsize=1024)
def asked(numbers: int, candidates: int) -> float:
    """Gain in the logarithm of the likelihood that an effect sized by so many numbers has to exceed, one of so many
    candidates, each of its shapes one: its quantile where there is none (Wilks 1938), each candidate with its share of
    `FALSE_ALARMS`.
    """
    return 0.5 * float(chi2.isf(FALSE_ALARMS / max(candidates, 1), numbers))


TIMES = 3
"""Times at most that noise is found anew as what is left with some columns."""

SETTLED = 0.1
"""Logarithm of the likelihood by which the noise that is left is likelier as noise of its own, up to which it is known.
"""


Left = tuple[Weighing, np.ndarray, float]
"""What is left of a record, how it weighs as noise, and half the squares by which unknowns are beside what is known of
them before any record.
"""


def gain_of(fitted: Fit, block: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[float, np.ndarray]:
    """By how much the logarithm of the likelihood rises, to first order, with columns (rows, numbers; not weighed)
    between bounds beside a fit's own unknowns, and how far these and they go.

    What is missing is coloured, and may pass for noise: with the columns and without them noise is what is left.
    """
    x, left = _settled(fitted, block, low, high)
    return gained(fitted.balance, left, own_noise(fitted)), x


def gained(balance: Balance, one: Left, other: Left) -> float:
    """By how much the logarithm of the likelihood of what is left is above that of what another leaves: of a simulation
    each by the noise that it is itself, of a balance, whose noise nobody knows, by that of the first.
    """
    (weighing, left, vague), (beside, rest, vaguer) = one, other
    if balance.name != SIMULATION:
        return 0.5 * float(np.sum(weighing(rest) ** 2) - np.sum(weighing(left) ** 2)) + vaguer - vague
    counts = weighing.counts & beside.counts
    return weighing.log_likelihood(left, counts) - beside.log_likelihood(rest, counts) + vaguer - vague


def _settled(fitted: Fit, block: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, Left]:
    """How far a fit's own unknowns go, and columns beside them, and what is left then."""
    count, weigh, own = len(fitted.unknowns), fitted.weighing, fitted.jacobian * fitted.free
    known, pull = np.zeros(count + block.shape[1]), np.zeros(count + block.shape[1])
    known[:count], pull[:count] = fitted.known, fitted.pull
    wide, weighed = np.full(count, np.inf), fitted.weighed
    low, high = np.concatenate([-wide, low]), np.concatenate([wide, high])
    for _ in range(TIMES):
        columns = np.column_stack([own, weigh(block)])
        x = bounded_minimum(columns.T @ columns + np.diag(known), columns.T @ weighed + pull, low, high)
        moved = fitted.changes @ (fitted.free * x[:count]) + block @ x[count:]
        left = np.where(fitted.residual != 0.0, fitted.residual + moved, 0.0)
        before, weigh = weigh, weighed_without(fitted, left)
        counts = before.counts & weigh.counts
        if weigh.log_likelihood(left, counts) - before.log_likelihood(left, counts) < SETTLED:
            break
        own, weighed = weigh(fitted.changes) * fitted.free, weigh(fitted.residual)
    vague = 0.5 * float(fitted.vague @ fitted.vague) + float(pull @ x + 0.5 * known @ x**2)
    return x, (weigh, left, vague)


def left_by(fitted: Fit) -> Left:
    """What a fit leaves, as it weighs there."""
    return fitted.weighing, fitted.residual, 0.5 * float(fitted.vague @ fitted.vague)


@lru_cache(maxsize=2)
def own_noise(fitted: Fit) -> Left:
    """What a fit leaves by itself."""
    nothing = np.zeros(0)
    return _settled(fitted, np.zeros((fitted.residual.size, 0)), nothing, nothing)[1]


@dataclass(frozen=True, eq=False)
class Proposal:
    """A set of effects to be fitted: what it adds and drops, its expected gain less what is asked, and where it starts:
    the values to which first order leads the numbers that it adds, and all others.
    """

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
        own, places = self.fitted.jacobian * self.fitted.free, dict[Trial, list[int]]()
        at = own.shape[1]
        for trial, columns in self.columns.items():
            places[trial] = list(range(at, at + len(columns.own)))
            at += len(columns.own)
        stack = np.empty((own.shape[0], at))
        stack[:, : own.shape[1]] = own
        for trial, columns in self.columns.items():
            stack[:, places[trial]] = columns.block
        curvature = stack.T @ stack
        known, slope = np.zeros(at), stack.T @ self.fitted.weighed
        known[: own.shape[1]] = self.fitted.known
        slope[: own.shape[1]] += self.fitted.pull
        curvature += np.diag(known)
        return curvature, slope, places

    def gain(self, added: Sequence[Trial], moved: Mapping[int, float] | None = None) -> tuple[float, dict[str, float]]:
        """By how much the logarithm of the likelihood rises with these, and the values of their numbers and of the
        fit's own parameters then; `moved` are unknowns of the fit that are taken elsewhere, as a search sees them.
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
        own = np.zeros(count)
        own[rest] = x[: len(rest)]
        return fallen - risen, self._reached(own, added, x[len(rest) :], rest)

    def _reached(self, own: np.ndarray, added: Sequence[Trial], x: np.ndarray, rest: Sequence[int]) -> dict[str, float]:
        """The values of those of the fit's own parameters that are the `rest`, moved by `own`, and of what is added."""
        unknowns = self.fitted.unknowns
        low, high = [u.low for u in unknowns], [u.high for u in unknowns]
        there = self.fitted.at(np.clip(self.fitted.places + own, low, high))
        names = [unknowns[i].name for i in rest]
        reached, at = {name: there[name] for name in names}, 0
        for trial in added:
            columns = self.columns[trial]
            reached |= columns.values(x[at : at + len(columns.own)])
            at += len(columns.own)
        return reached

    def alone(self, trial: Trial, price: float) -> Proposal:
        """One trial, by the noise that it would leave itself."""
        if trial not in self._alone:
            columns = self.columns[trial]
            gain, x = gain_of(self.fitted, columns.change, columns.low, columns.high)
            count = len(self.fitted.unknowns)
            reached = self._reached(x[:count], [trial], x[count:], range(count))
            self._alone[trial] = Proposal((trial,), (), gain, gain, reached)
        known = self._alone[trial]
        return replace(known, score=known.gain - price)

    def proposal(self, added: Sequence[Trial], dropped: Mapping[str, Mapping[int, float]], price: float) -> Proposal:
        """The set with these added and dropped, for what it costs."""
        moved = {i: away for own in dropped.values() for i, away in own.items()}
        gain, reached = self.gain(added, moved)
        return Proposal(tuple(added), tuple(dropped), gain, gain - price, reached)


def effects_of(trials: Collection[Trial]) -> tuple[str, ...]:
    """Their effects, in order, each once."""
    return tuple(dict.fromkeys(trial.effect for trial in trials))
