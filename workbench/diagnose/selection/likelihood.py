"""What sets of effects would gain in likelihood, to first order: from the columns of all, with no further fit."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.stats import chi2

from workbench.diagnose.residuals.fit import Fit, weighed_again
from workbench.diagnose.residuals.weighing import plain
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
    """By how much the logarithm of the likelihood rises, to first order, with weighed columns (rows, numbers) between
    bounds beside a fit's own unknowns, and how far they go: noise is what is left with them. What is missing is
    coloured, and would else pass for noise.
    """
    own = fitted.jacobian * fitted.free
    vague = fitted.curvature - fitted.jacobian.T @ fitted.jacobian
    count, residual = own.shape[1], fitted.weighed
    stack, wide = np.column_stack([own, block]), np.full(count, np.inf)
    low, high = np.concatenate([-wide, low]), np.concatenate([wide, high])
    gain, x = 0.0, np.zeros(stack.shape[1])
    weigh = replace(plain(fitted.balance.series, residual.size), counts=residual != 0.0)
    for _ in range(TIMES):
        columns, left = weigh(stack), weigh(residual)
        curvature, slope = columns.T @ columns, columns.T @ left
        curvature[:count, :count] += vague
        before = _fallen(curvature[:count, :count], slope[:count], low[:count], high[:count])[0]
        fallen, x = _fallen(curvature, slope, low, high)
        gain = fallen - before
        weigh = weighed_again(fitted, np.where(residual != 0.0, residual + stack @ x, 0.0))
    return gain, x[count:]


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
        columns = self.columns[trial]
        gain, x = gain_of(self.fitted, columns.block, columns.low, columns.high)
        return Proposal((trial,), (), gain, gain - price, columns.values(x))

    def proposal(self, added: Sequence[Trial], dropped: Mapping[str, Mapping[int, float]], price: float) -> Proposal:
        """The set with these added and dropped, for what it costs."""
        moved = {i: away for own in dropped.values() for i, away in own.items()}
        gain, reached = self.gain(added, moved)
        start = {name: value for trial, x in reached.items() for name, value in self.columns[trial].values(x).items()}
        return Proposal(tuple(added), tuple(dropped), gain, gain - price, start)


def effects_of(trials: Collection[Trial]) -> tuple[str, ...]:
    """Their effects, in order, each once."""
    return tuple(dict.fromkeys(trial.effect for trial in trials))
