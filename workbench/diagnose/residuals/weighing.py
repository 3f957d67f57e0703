"""What a residual weighs against its noise: whitened by the noise's own spectrum, freed of what no parameter decides.

Noise that is coloured counts less often than it has samples. Of each residual an autoregression of its noise is found,

    e_t = (r_t + a_1 r_{t-1} + ... + a_p r_{t-p}) / s,

whose e is white with a standard deviation of 1, and sums of squares of e are those of a likelihood (Cochrane and Orcutt
1949; its order by Akaike's criterion). What does not depend on any parameter, such as where a simulation starts, is
projected off.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

HIGHEST_ORDER = 24
"""Of an autoregression."""

ROWS_A_NUMBER = 40
"""Rows of a series that an autoregression has for each of its numbers, at least."""

NEGLIGIBLE = 1e-9
"""Share of the largest of the directions that are projected off, below which one is none."""

Slices = Sequence[Sequence[slice]]
"""Where the residuals of each record stand in a stack: records, and the kinds of residual of each."""


@dataclass(frozen=True, eq=False)
class Weighing:
    """How rows of a stack become rows of a likelihood: a filter for each kind of residual, rows that count, directions
    that do not (for some rows an orthonormal basis each).
    """

    series: Slices
    filters: Sequence[np.ndarray]
    counts: np.ndarray
    beside: Sequence[tuple[np.ndarray, np.ndarray]] = ()

    def __call__(self, stack: np.ndarray) -> np.ndarray:
        """A residual, or the columns of its Jacobian: shape (rows,) or (rows, columns)."""
        out = np.zeros_like(stack)
        for slices in self.series:
            for place, numbers in zip(slices, self.filters, strict=True):
                out[place] = lfilter(numbers, 1.0, stack[place], axis=0)
        out[~self.counts] = 0.0
        for rows, basis in self.beside:
            out[rows] -= basis @ (basis.T @ out[rows])
        return out

    def times(self, factor: float) -> "Weighing":
        """The same of a residual that is in other units."""
        return Weighing(self.series, [factor * numbers for numbers in self.filters], self.counts, self.beside)

    def without(self, columns: np.ndarray, groups: Sequence[np.ndarray]) -> "Weighing":
        """The same, with these directions projected off: columns (rows, directions), in each group of rows alone."""
        if not groups:
            return self
        weighed, beside = replace(self, beside=())(columns), []
        for rows in groups:
            block = weighed[rows]
            norms = np.linalg.norm(block, axis=0)
            block = block[:, norms > NEGLIGIBLE * max(float(np.max(norms, initial=0.0)), 1e-300)]
            if block.size:
                left, sizes, _ = np.linalg.svd(block / np.linalg.norm(block, axis=0), full_matrices=False)
                beside.append((rows, left[:, sizes > NEGLIGIBLE]))
        return replace(self, beside=beside)


def without(residual: np.ndarray, columns: np.ndarray, groups: Sequence[np.ndarray]) -> np.ndarray:
    """A residual less what columns (rows, directions) take of it in each group of rows, where it is known."""
    out = residual.copy()
    for rows in groups:
        block = columns[rows] * (residual[rows] != 0.0)[:, None]
        sizes = np.linalg.norm(block, axis=0)
        block = block[:, sizes > 0.0] / sizes[sizes > 0.0]
        out[rows] -= block @ np.linalg.lstsq(block, residual[rows], rcond=NEGLIGIBLE)[0]
    return out


def plain(series: Slices, size: int) -> Weighing:
    """Every row as it is."""
    return Weighing(series, [np.ones(1)] * len(series[0]), np.ones(size, dtype=bool))


def by_scatter(series: Slices, residual: np.ndarray) -> Weighing:
    """Every row alike, by the residual's own scatter, or the floor where that is more, and as often as it has
    independent values: what is far from noise has a spectrum of what is missing, which must not be taken off.
    """
    known = residual[residual != 0.0]
    deviation = max(float(np.sqrt(np.mean(known**2))) if known.size else 1.0, 1.0)
    remembered = max((_remembered(residual[place]) for slices in series for place in slices), default=1.0)
    return Weighing(series, [np.array([1.0 / (deviation * np.sqrt(remembered))])] * len(series[0]), residual != 0.0)


def _remembered(values: np.ndarray) -> float:
    """1 + 2 (rho_1 + rho_2 + ...) of a series, to the first not above 0: so many values tell as much as one."""
    spectrum = np.abs(np.fft.rfft(values, 2 * values.size)) ** 2
    covariance = np.fft.irfft(spectrum)[: values.size // 2]
    if covariance.size < 2 or covariance[0] <= 0.0:
        return 1.0
    correlation = covariance[1:] / covariance[0]
    ends = np.flatnonzero(correlation <= 0.0)
    return 1.0 + 2.0 * float(np.sum(correlation[: ends[0] if ends.size else correlation.size]))


def weighing_of(series: Slices, residual: np.ndarray) -> Weighing:
    """How residuals like this one weigh, whose exact zeros say nothing: of each kind one noise in all records."""
    filters, counts = [], residual != 0.0
    for kind in range(len(series[0])):
        pieces = [residual[slices[kind]] for slices in series]
        filters.append(_whitening(pieces))
    for slices in series:
        for place, numbers in zip(slices, filters, strict=True):
            known = (residual[place] != 0.0).astype(float)
            reached = lfilter(np.ones(numbers.size), 1.0, known)
            counts[place] &= reached > numbers.size - 0.5
    return Weighing(series, filters, counts)


def _whitening(pieces: Sequence[np.ndarray]) -> np.ndarray:
    """(1, a_1 .. a_p) / s of the autoregression of these residuals, with the order that Akaike's criterion prefers."""
    known = sum(int(np.count_nonzero(piece)) for piece in pieces)
    if known < 2:
        return np.ones(1)
    most = max(min(HIGHEST_ORDER, known // ROWS_A_NUMBER), 0)
    sums, pairs = np.zeros(most + 1), np.zeros(most + 1)
    for piece in pieces:
        seen = (piece != 0.0).astype(float)
        for lag in range(min(most, piece.size - 1) + 1):
            sums[lag] += piece[lag:] @ piece[: piece.size - lag]
            pairs[lag] += seen[lag:] @ seen[: piece.size - lag]
    covariance = sums / np.maximum(pairs, 1.0)
    taper = 1.0 - np.arange(most + 1) / max(known, 1)  # keeps the autoregression stable
    covariance = covariance * taper
    covariance[0] *= 1.0 + 1e-9
    best, chosen = np.inf, np.ones(1)
    for order in range(most + 1):
        numbers = np.ones(1)
        if order:
            numbers = np.concatenate([[1.0], solve_toeplitz(covariance[:order], -covariance[1 : order + 1])])
        variance = float(numbers @ covariance[: order + 1])
        if variance <= 0.0:
            break
        criterion = known * np.log(variance) + 2.0 * order
        if criterion < best:
            best, chosen = criterion, numbers / np.sqrt(variance)
    return chosen
