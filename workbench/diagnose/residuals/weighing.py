"""What a residual weighs against its noise: whitened by the noise's own spectrum, freed of what no parameter decides.

Noise that is coloured counts less often than it has samples. Of each residual an autoregression of its noise is found,

    e_t = (r_t + a_1 r_{t-1} + ... + a_p r_{t-p}) / s,

whose e is white with a standard deviation of 1, and sums of squares of e are those of a likelihood (Cochrane and Orcutt
1949; its order by Akaike's criterion). The first p of a series have fewer before them, and are foreseen by those
alone: they count too, since they tell where a simulation starts. What does not depend on any parameter, such as where a
simulation starts, is projected off.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

HIGHEST_ORDER = 24
"""Of an autoregression."""

ROWS_A_NUMBER = 40
"""Rows of a series that an autoregression has for each of its numbers, at least."""

NEGLIGIBLE = 1e-9
"""Share of itself that is left of a direction where rows count, and of the largest of those that are projected off,
below which it is none: their units are those of each sensor."""

Slices = Sequence[Sequence[slice]]
"""Where the residuals of each record stand in a stack: records, and the kinds of residual of each."""


@dataclass(frozen=True, eq=False)
class Whitening:
    """(1, a_1 .. a_p) / s of an autoregression, and how the first p residuals become white, shape (p, p)."""

    numbers: np.ndarray
    head: np.ndarray

    @classmethod
    def of(cls, deviation: float) -> "Whitening":
        """That of residuals that are white."""
        return cls(np.array([1.0 / deviation]), np.zeros((0, 0)))

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """A series, or columns of several, shape (rows,) or (rows, columns), from its beginning on."""
        first = min(self.head.shape[0], values.shape[0])
        if not first:
            return np.asarray(self.numbers[0] * values)
        columns = values.reshape(values.shape[0], -1)
        out = np.empty(columns.shape)
        for place, column in enumerate(columns.T):
            out[:, place] = np.convolve(column, self.numbers)[: column.size]
        out[:first] = self.head[:first, :first] @ columns[:first]
        return out.reshape(values.shape)

    def times(self, factor: float) -> "Whitening":
        """The same of residuals in other units."""
        return Whitening(factor * self.numbers, factor * self.head)

    def counts(self, known: np.ndarray) -> np.ndarray:
        """Which residuals have all that they are foreseen by."""
        size = self.numbers.size
        whole = lfilter(np.ones(size), 1.0, known.astype(float)) > np.minimum(np.arange(known.size) + 1, size) - 0.5
        return np.asarray(known & whole)


@dataclass(frozen=True, eq=False)
class Weighing:
    """How rows of a stack become rows of a likelihood: a whitening for each kind of residual, rows that count,
    directions that do not (for some rows an orthonormal basis each).
    """

    series: Slices
    filters: Sequence[Whitening]
    counts: np.ndarray
    beside: "Directions" = ()

    def __call__(self, stack: np.ndarray) -> np.ndarray:
        """A residual, or the columns of its Jacobian: shape (rows,) or (rows, columns)."""
        out = np.zeros_like(stack)
        for slices in self.series:
            for place, white in zip(slices, self.filters, strict=True):
                out[place] = white(stack[place])
        out[~self.counts] = 0.0
        for rows, basis in self.beside:
            out[rows] -= basis @ (basis.T @ out[rows])
        return out

    def log_likelihood(self, residual: np.ndarray, counts: np.ndarray) -> float:
        """Logarithm of the likelihood, but for a constant, of rows of a residual that count as noise of this spectrum,
        less one for each number of its autoregressions (Akaike 1974): of two that whiten as well, that with fewer.
        """
        weighed = self(residual)[counts]
        scales = sum(
            float(np.log(white.numbers[0])) * int(np.count_nonzero(counts[place]))
            for slices in self.series
            for place, white in zip(slices, self.filters, strict=True)
        )
        orders = sum(white.numbers.size - 1 for white in self.filters)
        return scales - 0.5 * float(weighed @ weighed) - orders

    def times(self, factor: float) -> "Weighing":
        """The same of a residual that is in other units."""
        return Weighing(self.series, [white.times(factor) for white in self.filters], self.counts, self.beside)

    def without(self, columns: np.ndarray, groups: Sequence[np.ndarray]) -> "Weighing":
        """The same, with these directions projected off: columns (rows, directions), in each group of rows alone."""
        if not groups:
            return self
        weighed = replace(self, beside=())(columns)
        spans = [(rows, weighed[rows], columns[rows]) for rows in map(_span, groups)]
        bases = [(rows, basis_of(block, NEGLIGIBLE * _norms(bare))) for rows, block, bare in spans]
        return replace(self, beside=bases)


Changes = tuple[np.ndarray, Sequence[np.ndarray]]
"""Changes of a stack (rows, changes), and groups of its rows, of each of which they are told for itself."""

Directions = Sequence[tuple[slice | np.ndarray, np.ndarray]]
"""For some rows of a stack an orthonormal basis each, shape (rows, directions)."""


def beside_known(known: np.ndarray, columns: np.ndarray, groups: Sequence[np.ndarray]) -> Directions:
    """What columns (rows, directions) span in each group of rows, where a residual is `known`."""
    return [(rows, basis_of(columns[rows] * known[rows, None])) for rows in map(_span, groups)]


def basis_of(block: np.ndarray, least: np.ndarray | float = 0.0, share: float = NEGLIGIBLE) -> np.ndarray:
    """An orthonormal basis of what a block (rows, directions) spans, without those directions that are no larger than
    the `least` that counts, and those that are no more than a `share` of the largest.
    """
    sizes = _norms(block)
    there = sizes > least
    if not np.any(there):
        return np.zeros((block.shape[0], 0))
    left, strengths, _ = np.linalg.svd(block[:, there] / sizes[there], full_matrices=False)
    return np.asarray(left[:, strengths > share * strengths[0]])


def _norms(block: np.ndarray) -> np.ndarray:
    """Of each column."""
    return np.asarray(np.sqrt(np.einsum("ij,ij->j", block, block)))


def _span(rows: np.ndarray) -> slice | np.ndarray:
    """Rows as a slice, if they follow each other: no copy is made of what they hold."""
    if rows.size and rows[-1] - rows[0] == rows.size - 1:
        return slice(int(rows[0]), int(rows[-1]) + 1)
    return rows


def less(residual: np.ndarray, directions: Directions) -> np.ndarray:
    """A residual without what is along some directions."""
    out = residual.copy()
    for rows, basis in directions:
        out[rows] -= basis @ (basis.T @ residual[rows])
    return out


def without(residual: np.ndarray, columns: np.ndarray, groups: Sequence[np.ndarray]) -> np.ndarray:
    """A residual less what columns (rows, directions) take of it in each group of rows, where it is known."""
    return less(residual, beside_known(residual != 0.0, columns, groups))


def plain(series: Slices, size: int) -> Weighing:
    """Every row as it is."""
    return Weighing(series, [Whitening.of(1.0)] * len(series[0]), np.ones(size, dtype=bool))


def by_scatter(series: Slices, residual: np.ndarray) -> Weighing:
    """Every row alike, by the residual's own scatter, or the floor where that is more, and as often as it has
    independent values: what is far from noise has a spectrum of what is missing, which must not be taken off.
    """
    known = residual[residual != 0.0]
    deviation = max(float(np.sqrt(np.mean(known**2))) if known.size else 1.0, 1.0)
    remembered = max((_remembered(residual[place]) for slices in series for place in slices), default=1.0)
    white = Whitening.of(deviation * float(np.sqrt(remembered)))
    return Weighing(series, [white] * len(series[0]), residual != 0.0)


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
        for place, white in zip(slices, filters, strict=True):
            counts[place] = white.counts(counts[place])
    return Weighing(series, filters, counts)


def _whitening(pieces: Sequence[np.ndarray]) -> Whitening:
    """That of these residuals, with the order that Akaike's criterion prefers."""
    known = sum(int(np.count_nonzero(piece)) for piece in pieces)
    if known < 2:
        return Whitening.of(1.0)
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
    least, best, rows = np.inf, 0, list[np.ndarray]()
    numbers, variance = np.ones(1), float(covariance[0])
    for order in range(most + 1):
        if order:  # Levinson and Durbin: from each order the next
            reflected = float(numbers @ covariance[order:0:-1]) / variance
            longer = np.append(numbers, 0.0)
            numbers, variance = longer - reflected * longer[::-1], variance * (1.0 - reflected**2)
        if variance <= 0.0:
            break
        rows.append(numbers / np.sqrt(variance))
        criterion = known * np.log(variance) + 2.0 * order
        if criterion < least:
            least, best = criterion, order
    if not rows:
        return Whitening.of(1.0)
    head = np.array([np.pad(row[::-1], (0, best - row.size)) for row in rows[:best]]).reshape(best, best)
    return Whitening(rows[best], head)
