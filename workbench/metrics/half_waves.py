"""Half waves of a motion about its own midline, however it creeps: when it crosses, and how high each one is.

The midline is a polynomial: it is fitted to all samples by least squares, and where that shows cycles, once more to
the middles between their extremes, since cycles tilt the first. A straight line serves a slow drift; a cubic and a
quintic serve a cycle that rides on a creep faster than itself. No smooth creep can be taken for cycles: what remains of
a monotone approach crosses zero at most twice more than the degree says, and that many more half waves are asked for.

A crossing counts when the error goes from beyond one edge of a band to beyond the other; its instant is the last zero
crossing in between. The band is the noise's; where the half waves so found are irregular, a quarter and a half of the
motion's own height are tried as well, so that a second, smaller tone is not counted.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

LEAST_CYCLES, FEW_CYCLES = 4.0, 2.5
"""That a verdict needs, and that a fast decay does."""

PERIOD_SPREAD = 0.25
"""Standard deviation of the period over its mean, up to which cycles are regular."""

DEGREES = (1, 3, 5)
BANDS = (0.0, 0.25, 0.5)
"""Half-widths of the band that are tried, in shares of the motion's height."""

COMMON = (0.05, 0.95)
"""Quantiles between which a motion has twice its height."""


@dataclass(frozen=True)
class HalfWaves:
    """Instants of the crossings (s), height (m) and mean square (m^2) of each half wave between two of them."""

    crossings: np.ndarray
    heights: np.ndarray
    squares: np.ndarray

    @property
    def amplitudes(self) -> np.ndarray:
        """Peak to peak (m) of each cycle, half a cycle apart: the mean of an upward and a downward swing."""
        heights = self.heights
        return 0.5 * (heights[:-2] + heights[2:]) + heights[1:-1]

    @property
    def strengths(self) -> np.ndarray:
        """Root mean square (m) of each cycle, half a cycle apart."""
        lasted = np.diff(self.crossings)
        energy = self.squares * lasted
        return np.sqrt((energy[1:] + energy[:-1]) / (lasted[1:] + lasted[:-1]))

    @property
    def periods(self) -> np.ndarray:
        """Of each cycle (s), half a cycle apart: every crossing begins one."""
        return self.crossings[2:] - self.crossings[:-2]

    @property
    def spread(self) -> float:
        """Standard deviation of the period over its mean."""
        return float(np.std(self.periods) / np.mean(self.periods))

    @property
    def regular(self) -> bool:
        """Whether the periods agree."""
        return self.spread <= PERIOD_SPREAD


def find_half_waves(time: np.ndarray, error: np.ndarray, band: float, cycles: float = LEAST_CYCLES) -> HalfWaves | None:
    """The half waves of an error (m) over time (s): the first regular ones, else the most regular; None: too few.

    `band` (m): half-width of the hysteresis. `cycles`: how many there have to be.
    """
    best: HalfWaves | None = None
    for degree in DEGREES:
        fewest = 2.0 * cycles + degree - 1.0
        for share in BANDS if time.size > 2 * fewest else ():
            waves = _half_waves(time, error, degree, band, share)
            if waves.heights.size < fewest:
                break
            if waves.regular:
                return waves
            best = waves if best is None or waves.spread < best.spread else best
    return best


def _half_waves(time: np.ndarray, error: np.ndarray, degree: int, band: float, share: float) -> HalfWaves:
    level = error - Polynomial.fit(time, error, degree)(time)
    width = _width(level, band, share)
    before = _last_before_crossing(level, width)
    tops = _tops(level, before)
    if tops.size >= degree + 4:
        midline = Polynomial.fit(_middles(time[tops]), _middles(error[tops]), degree)
        level = error - midline(time)
        before = _last_before_crossing(level, width)
        tops = _tops(level, before)
    step = time[before + 1] - time[before]
    crossings = time[before] + step * level[before] / (level[before] - level[before + 1])
    energy = np.concatenate([[0.0], np.cumsum(np.square(level))])[before + 1]
    return HalfWaves(crossings, np.abs(level[tops]), np.diff(energy) / np.maximum(np.diff(before), 1))


def _width(level: np.ndarray, band: float, share: float) -> float:
    if not share:
        return band
    low, high = np.quantile(level, COMMON)
    return max(band, share * 0.5 * float(high - low))


def _last_before_crossing(level: np.ndarray, band: float) -> np.ndarray:
    """Samples after which `level` (m) changes sign for the last time on its way across the band of half-width (m)."""
    side = np.where(level > band, 1, np.where(level < -band, -1, 0))
    beyond = np.flatnonzero(side)
    arrivals = beyond[1:][side[beyond[1:]] != side[beyond[:-1]]]
    flips = np.flatnonzero((level[1:] > 0.0) != (level[:-1] > 0.0))
    return flips[np.searchsorted(flips, arrivals) - 1] if arrivals.size else arrivals


def _tops(level: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Sample of the extreme of each half wave between crossings."""
    spans = zip(before[:-1] + 1, before[1:] + 1, strict=True)
    return np.array([a + np.argmax(np.abs(level[a:b])) for a, b in spans], dtype=int)


def _middles(extremes: np.ndarray) -> np.ndarray:
    """Middle between each extreme and the mean of its neighbours: exact for a periodic motion on a straight line."""
    return 0.25 * (extremes[:-2] + extremes[2:]) + 0.5 * extremes[1:-1]
