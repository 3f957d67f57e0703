"""Least squares of a balance's residual over parameters of the plant, and how well it holds on blocks left out."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Unknown, Values, unknown
from workbench.fitting.covariance import long_run_length, sandwich

BLOCKS = 10
"""Parts, each of one piece, into which the records are cut for cross-validation."""

LEAST_BLOCKS = 4
"""Parts of each record at least: blocks of several records must not be so few that none can be sure."""

STEP = 1e-4
"""Relative step of difference quotients; the residuals are exact functions of the parameters."""

ANCHOR = 0.003
"""Weight of a factor of e by which a positive parameter leaves its start, against the square of one sample at the
floor: nothing where the record knows better, enough to keep two that it cannot tell apart from running away
together."""

BOUNDED = 1e-3
"""Distance (of an unknown as the search sees it) to an end of its range at which a parameter has stopped there."""

THREADS = 2
"""In which the columns of a Jacobian are found."""

SHARES = (1.0, 0.6, 0.3)
"""Of a Gauss-Newton step, at which a candidate's promise is looked at: a long step of a logarithm goes too far."""

Residual = Callable[[Motion, Values], Sequence[np.ndarray]]
"""The residuals of a balance along a motion, one array or more."""


@dataclass(frozen=True, eq=False)
class Balance:
    """A physical balance of some records: its residual over parameter values, the noise floor of it, and its unit.

    The floor is `simulated` where it is the residual of a plant that lacks nothing, else the sensors' noise alone.
    `free` are the declared plant's own parameters that a fit moves before anything is called an effect. `parts` is the
    number of residuals that each motion gives. A `sharp` balance cannot be told where smoothing blurs what happened,
    and follows a contact from sample to sample; any other is evaluated on thinned motions alone.
    """

    name: str
    motions: Sequence[Motion]
    residual: Residual
    floor: float
    unit: str
    free: tuple[str, ...]
    effects: tuple[str, ...] = ()
    parts: int = 1
    sharp: bool = False
    simulated: bool = False

    def known(self, motion: Motion) -> np.ndarray:
        """At which of a motion's thinned instants the residual says something."""
        thin = motion.thinned
        return thin.valid & ~thin.blurred if self.sharp else thin.valid

    def residuals(self, motion: Motion, values: Values) -> list[np.ndarray]:
        """Residuals (in `unit`) of a motion at its thinned instants."""
        if self.sharp:
            return [part[:: motion.thinning] for part in self.residual(motion, values)]
        return list(self.residual(motion.thinned, values))

    def stacked(self, values: Values) -> np.ndarray:
        """Residuals of all records over the floor, 0 where nothing is known."""
        return np.concatenate(
            [
                np.where(self.known(motion), part, 0.0) / self.floor
                for motion in self.motions
                for part in self.residuals(motion, values)
            ]
        )

    @cached_property
    def series(self) -> list[list[slice]]:
        """Where the residuals of each record stand in the stack."""
        sizes = [motion.thinned.time.size for motion in self.motions for _ in range(self.parts)]
        ends = np.cumsum(sizes).tolist()
        slices = [slice(end - size, end) for end, size in zip(ends, sizes, strict=True)]
        return [slices[i : i + self.parts] for i in range(0, len(slices), self.parts)]

    @cached_property
    def blocks(self) -> list[np.ndarray]:
        """Rows of each block of the stack: pieces of time, with all residuals of a record in them."""
        per_record = max(BLOCKS // len(self.motions), LEAST_BLOCKS)
        return [
            np.concatenate(pieces)
            for slices in self.series
            for pieces in zip(
                *(np.array_split(np.arange(one.start, one.stop), per_record) for one in slices), strict=True
            )
        ]


@dataclass(frozen=True, eq=False)
class Fit:
    """A balance at its best over some free parameters.

    `residual` is over the floor; `validated` the same as predicted for each block by a fit without it; `jacobian`
    that of the residual by the `unknowns`; `bounded` are parameters that stopped at the end of their range.
    """

    balance: Balance
    names: tuple[str, ...]
    values: dict[str, float]
    deviations: dict[str, float]
    residual: np.ndarray
    validated: np.ndarray
    jacobian: np.ndarray
    unknowns: Sequence[Unknown]
    bounded: frozenset[str]

    @property
    def rms(self) -> float:
        """Of the residual, in floors."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def validated_rms(self) -> float:
        """Of the residual on blocks that were left out, in floors."""
        return float(np.sqrt(np.mean(self.validated**2)))

    def rise_without(self, neutral: Values) -> float:
        """By how much the mean square would rise, to first order, with these parameters at these values and the others
        fitted anew: d' S d / n, with S the Schur complement of J' J for them and d their distance.
        """
        own = [i for i, name in enumerate(self.names) if name in neutral]
        rest = [i for i in range(len(self.names)) if i not in own]
        whole = self.jacobian.T @ self.jacobian
        between = whole[np.ix_(own, rest)]
        schur = whole[np.ix_(own, own)] - between @ np.linalg.pinv(whole[np.ix_(rest, rest)]) @ between.T
        away = np.array(
            [
                self.unknowns[i].place(self.values[name]) - self.unknowns[i].place(neutral[name])
                for i, name in enumerate(self.names)
                if name in neutral
            ]
        )
        return float(away @ schur @ away) / self.residual.size

    @property
    def block_squares(self) -> np.ndarray:
        """Mean square of the left-out residual of each block."""
        return np.array([np.mean(self.validated[block] ** 2) for block in self.balance.blocks])


@dataclass(frozen=True)
class Search:
    """When a search ends: a step gains less of the sum of squares, or moves the unknowns less, or there were many."""

    flat: float = 1e-7
    near: float = 1e-6
    most_steps: int = 30


def fit(
    balance: Balance,
    values: Values,
    names: Sequence[str],
    bounds: Mapping[str, tuple[float, float]] | None = None,
    search: Search = Search(),
) -> Fit:
    """The best values of the parameters `names`, all others as in `values`."""
    unknowns = [unknown(name, values, bounds or {}) for name in names]

    def at(x: np.ndarray) -> dict[str, float]:
        return {**values, **{u.name: u.value(float(one)) for u, one in zip(unknowns, x, strict=True)}}

    anchors = np.array([1.0 if u.logarithmic else 0.0 for u in unknowns])

    def residual(x: np.ndarray) -> np.ndarray:
        stacked = np.nan_to_num(balance.stacked(at(x)), nan=1e6)
        return np.concatenate([stacked, np.sqrt(ANCHOR * stacked.size) * anchors * x])

    def jacobian(x: np.ndarray) -> np.ndarray:
        base = residual(x)

        def column(i: int) -> np.ndarray:
            step = STEP * max(1.0, abs(x[i]))
            step = step if x[i] + step < unknowns[i].high else -step
            moved = x.copy()
            moved[i] += step
            return np.asarray((residual(moved) - base) / step)

        with ThreadPoolExecutor(THREADS) as pool:  # compiled code lets other threads run
            return np.column_stack(list(pool.map(column, range(x.size))))

    low, high = np.array([u.low for u in unknowns]), np.array([u.high for u in unknowns])
    start = np.clip([u.first for u in unknowns], low + 1e-9, high - 1e-9)
    if unknowns:
        found = least_squares(
            residual,
            start,
            jac=jacobian,
            bounds=(low, high),
            xtol=search.near,
            ftol=search.flat,
            max_nfev=search.most_steps,
        )
        size = found.fun.size - len(unknowns)
        x, r, j = found.x, found.fun[:size], found.jac[:size] * (found.active_mask == 0)
    else:
        x, r = start, residual(start)
        j = np.zeros((r.size, 0))
    deviations = _deviations(j, r, [place for slices in balance.series for place in slices])
    return Fit(
        balance,
        tuple(names),
        at(x),
        {u.name: abs(u.slope(one)) * d for u, one, d in zip(unknowns, x, deviations, strict=True)},
        r,
        _validated(j, r, balance.blocks),
        j,
        unknowns,
        frozenset(u.name for u, one in zip(unknowns, x, strict=True) if min(one - u.low, u.high - one) < BOUNDED),
    )


def promise(before: Fit, names: Sequence[str], bounds: Mapping[str, tuple[float, float]]) -> float:
    """Residual rms (floors) after one Gauss-Newton step of a fit that also frees `names`: what a candidate promises."""
    balance, values = before.balance, before.values
    added = [unknown(name, values, bounds) for name in names if name not in before.names]
    kept = [replace(u, start=values[u.name]) if u.logarithmic else u for u in before.unknowns]
    x = [0.0 if u.logarithmic else values[u.name] / u.size for u in kept]
    start = np.array(x + [float(np.clip(u.first, u.low, u.high)) for u in added])

    def residual(point: np.ndarray) -> np.ndarray:
        moved = {u.name: u.value(float(one)) for u, one in zip([*kept, *added], point, strict=True)}
        return np.nan_to_num(balance.stacked({**values, **moved}), nan=1e6)

    base, columns = residual(start), []
    for i in range(len(kept), start.size):
        moved = start.copy()
        moved[i] += STEP * max(1.0, abs(start[i]))
        columns.append((residual(moved) - base) / (moved[i] - start[i]))
    jacobian = np.column_stack([before.jacobian, *columns])
    step = np.linalg.lstsq(jacobian, -base, rcond=1e-10)[0]
    low = np.array([u.low for u in [*kept, *added]])
    high = np.array([u.high for u in [*kept, *added]])
    reached = [residual(np.clip(start + share * step, low, high)) for share in SHARES]
    return float(np.sqrt(min(np.mean(one**2) for one in (base, *reached))))


def _deviations(jacobian: np.ndarray, residual: np.ndarray, series: list[slice]) -> np.ndarray:
    """Standard deviations of the unknowns, autocorrelation taken into account."""
    if not jacobian.shape[1]:
        return np.zeros(0)
    length = long_run_length([residual[place] for place in series])
    cov = sandwich(jacobian, residual, series, length, np.zeros(jacobian.shape[1]))
    return np.asarray(np.sqrt(np.maximum(np.diag(cov), 0.0)))


def _validated(jacobian: np.ndarray, residual: np.ndarray, blocks: Sequence[np.ndarray]) -> np.ndarray:
    """Residual of each block at the parameters that the others give, by one Gauss-Newton step from the whole fit."""
    if not jacobian.shape[1]:
        return residual
    whole = jacobian.T @ jacobian
    out = np.empty_like(residual)
    for block in blocks:
        own = jacobian[block]
        rest = whole - own.T @ own
        moved = np.linalg.lstsq(rest, own.T @ residual[block], rcond=1e-10)[0]
        out[block] = residual[block] + own @ moved
    return out
