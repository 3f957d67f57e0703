"""Least squares of a balance's residual over parameters of the plant, and how well it holds on blocks left out."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.unknowns import Unknown, Values, unknown
from workbench.fitting.covariance import long_run_length, sandwich

STEP = 1e-4
"""Relative step of difference quotients; the residuals are exact functions of the parameters."""

ANCHOR = 0.003
"""Weight of a factor of e by which a positive parameter leaves its start, against the square of one sample at the
floor: nothing where the record knows better, enough to keep two that it cannot tell apart from running away
together."""

BOUNDED = 1e-3
"""Distance (of an unknown as the search sees it) to an end of its range at which a parameter has stopped there."""

THREADS = 2
"""Threads in which the columns of a Jacobian are found, beside one another."""


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
    most_steps: int = 100


def fit(
    balance: Balance,
    values: Values,
    names: Sequence[str],
    bounds: Mapping[str, tuple[float, float]] | None = None,
    search: Search = Search(),
) -> Fit:
    """The best values of the parameters `names`, all others as in `values`."""
    unknowns = [unknown(name, values, bounds or {}, balance.scales) for name in names]

    def at(x: np.ndarray) -> dict[str, float]:
        return {**values, **{u.name: u.value(float(place)) for u, place in zip(unknowns, x, strict=True)}}

    anchors = np.array([1.0 if u.logarithmic else 0.0 for u in unknowns])

    def residual(x: np.ndarray) -> np.ndarray:
        stacked = np.nan_to_num(balance.stacked(at(x)), nan=1e6)
        return np.concatenate([stacked, np.sqrt(ANCHOR * stacked.size) * anchors * x])

    latest: list[np.ndarray] = []

    def tried(x: np.ndarray) -> np.ndarray:
        latest[:] = x.copy(), residual(x)
        return latest[1]

    def jacobian(x: np.ndarray) -> np.ndarray:
        base = latest[1] if np.array_equal(x, latest[0]) else residual(x)  # it is asked for where a step was taken to

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
        solution = least_squares(
            tried,
            start,
            jac=jacobian,
            bounds=(low, high),
            xtol=search.near,
            ftol=search.flat,
            max_nfev=search.most_steps,
        )
        size = solution.fun.size - len(unknowns)
        x, r, j = solution.x, solution.fun[:size], solution.jac[:size] * (solution.active_mask == 0)
    else:
        x, r = start, residual(start)
        j = np.zeros((r.size, 0))
    deviations = _deviations(j, r, [place for slices in balance.series for place in slices])
    places = list(zip(unknowns, x, strict=True))
    return Fit(
        balance=balance,
        names=tuple(names),
        values=at(x),
        deviations={u.name: abs(u.slope(place)) * std for (u, place), std in zip(places, deviations, strict=True)},
        residual=r,
        validated=_validated(j, r, balance.blocks),
        jacobian=j,
        unknowns=unknowns,
        bounded=frozenset(u.name for u, place in places if min(place - u.low, u.high - place) < BOUNDED),
    )


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
