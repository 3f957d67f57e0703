"""Does the actuator hunt? The verdict over one dwell, a span in which the reference is constant.

How it is judged, on the second half of the dwell (the first is transient):

- A straight line is taken off the error. A mean alone would leave the creep that remains after a step, and an
  oscillation that rides on a creep would not cross zero. The line is fitted to all samples by least squares, and where
  that shows cycles, once more to the middles between their extremes, since cycles tilt the first.
- A crossing counts when the error goes from beyond one edge of the band to beyond the other; its instant is the last
  zero crossing in between. Noise inside the band makes no crossing, nor does ringing that stays on one side of zero.
- The extremes between crossings give the swings. The mean of an upward and a downward swing is the amplitude of a
  cycle, peak to peak. Every crossing begins a period.
- decaying: at least three amplitudes (2.5 cycles), each smaller than the one before, the last less than half the first;
  or the logarithm of the amplitude falls along a line that chance explains in fewer than 1 of 1000 cases, by
  more than 2 % in all; or regular cycles that end before the record does.
- sustained: not decaying; at least 4 cycles, standard deviation of the period under 10 % of its mean, every amplitude
  within 0.9 to 1.1 of the one a cycle before, or none smaller (an oscillation that grows is still on its way to its
  limit cycle), and the cycles last to the end of the record.
- none: everything else.
- What a controller forces on the plant, such as dither, is no limit cycle: the error is averaged over one period of it
  first, and a cycle of that period is none.

A slow fall is looked for before amplitudes are compared with their neighbours, because friction of Coulomb's kind
alone converges so slowly that neighbours agree within 10 %, and it is no limit cycle (Ruderman 2020). A verdict should
be confirmed with twice the dwell and half the step. Irregular motion is no limit cycle.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.polynomial import Polynomial
from scipy.ndimage import uniform_filter1d
from scipy.stats import linregress

from workbench.simulation.simulate import STUCK_SPEED

Verdict = Literal["none", "decaying", "sustained"]

FLOOR = 1e-8
"""m. The band's least half-width: above the solver's error at its default tolerance, far below any sensor's step."""

LEAST_SAMPLES = 3
LEAST_CYCLES = 4
PERIOD_SPREAD = 0.10
"""Standard deviation of the period over its mean, up to which cycles are regular."""
AMPLITUDE_RATIO = (0.9, 1.1)
"""Amplitude over that of a cycle before, within which a cycle is sustained."""

LEAST_AMPLITUDES = 3
FALL, CHANCE = 0.02, 1e-3
"""Relative fall of the amplitude over the record that counts, and the probability that it is chance."""

STICKING_SHARE = 0.10
SLOW = 0.10
"""Sticking: more than `STICKING_SHARE` of the time slower than STUCK_SPEED and than `SLOW` times the mean speed of the
cycle. A sine spends 4 % of its time below a tenth of its mean speed, so that a small cycle is not a sticking one."""


@dataclass(frozen=True)
class LimitCycle:
    """Verdict over a dwell. `amplitude` (m, peak to peak) and `period` (s): means over the cycles; None without."""

    verdict: Verdict
    amplitude: float | None = None
    period: float | None = None
    sticking: bool = False


NONE = LimitCycle("none")


def judge(
    time: np.ndarray, error: np.ndarray, velocity: np.ndarray, band: float, transient: float = 0.0, forced: float = 0.0
) -> LimitCycle:
    """Verdict over one dwell from samples of time (s), tracking error (m) and velocity (m/s).

    What lies before `transient` (s) is left out, and at least the first half of the dwell.

    `band` (m) is the half-width of the hysteresis: the larger of three standard deviations of the position noise and
    the sensor's step; at least `FLOOR`. `forced` (s): period of what the controller itself puts on the plant; 0: none.
    """
    start = max(time.size // 2, int(np.searchsorted(time, transient)))
    time, error, velocity = time[start:], error[start:], velocity[start:]
    if time.size < LEAST_SAMPLES:
        return NONE
    if forced:
        error = uniform_filter1d(error, max(1, round(forced / (time[1] - time[0]))), mode="nearest")
    crossings, heights = _half_waves(time, error, max(band, FLOOR))
    if heights.size < LEAST_AMPLITUDES + 2:
        return NONE
    amplitudes = 0.5 * (heights[:-2] + heights[2:]) + heights[1:-1]
    periods = crossings[2:] - crossings[:-2]
    verdict = _verdict(amplitudes, periods, time[-1] - crossings[-1])
    if verdict == "none":
        return NONE
    amplitude, period = float(np.mean(amplitudes)), float(np.mean(periods))
    if forced and abs(period / forced - 1.0) < PERIOD_SPREAD:
        return NONE
    cycling = (time >= crossings[0]) & (time <= crossings[-1])
    slow = min(STUCK_SPEED, SLOW * 2.0 * amplitude / period)
    return LimitCycle(verdict, amplitude, period, bool(np.mean(np.abs(velocity[cycling]) < slow) > STICKING_SHARE))


def worst(verdicts: list[LimitCycle]) -> LimitCycle:
    """The verdict that counts for a run of several dwells: sustained before decaying before none, then the larger."""
    order = ("none", "decaying", "sustained")
    return max(verdicts, key=lambda found: (order.index(found.verdict), found.amplitude or 0.0))


def _half_waves(time: np.ndarray, error: np.ndarray, band: float) -> tuple[np.ndarray, np.ndarray]:
    """Instants of the crossings (s), and the height (m) of each half wave between them, above or below the trend."""
    level = error - Polynomial.fit(time, error, 1)(time)
    before = _last_before_crossing(level, band)
    tops = _tops(level, before)
    if tops.size >= LEAST_AMPLITUDES + 2:
        midline = Polynomial.fit(_middles(time[tops]), _middles(error[tops]), 1)
        level = error - midline(time)
        before = _last_before_crossing(level, band)
        tops = _tops(level, before)
    step = time[before + 1] - time[before]
    return time[before] + step * level[before] / (level[before] - level[before + 1]), np.abs(level[tops])


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


def _verdict(amplitudes: np.ndarray, periods: np.ndarray, silence: float) -> Verdict:
    """Verdict from amplitudes (m) and periods (s), half a cycle apart, and the time (s) since the last crossing."""
    if _falls_steadily(amplitudes):
        return "decaying"
    ratios = amplitudes[2:] / amplitudes[:-2]
    level = np.all((ratios >= AMPLITUDE_RATIO[0]) & (ratios <= AMPLITUDE_RATIO[1]))
    regular = (
        periods.size >= 2 * LEAST_CYCLES - 1
        and np.std(periods) < PERIOD_SPREAD * np.mean(periods)
        and (level or np.all(ratios >= 1.0))
    )
    if not regular:
        return "none"
    return "sustained" if silence < 1.5 * np.mean(periods) else "decaying"


def _falls_steadily(amplitudes: np.ndarray) -> bool:
    """Whether amplitudes (m), half a cycle apart, fall: quickly in every step or slowly along a trend."""
    if np.all(np.diff(amplitudes) < 0.0) and amplitudes[-1] < 0.5 * amplitudes[0]:
        return True
    apart = amplitudes[::2]  # neighbours half a cycle apart share a swing: their scatter is not independent
    if apart.size < LEAST_AMPLITUDES:
        return False
    trend = linregress(np.arange(apart.size), np.log(apart))
    fall = 1.0 - np.exp(trend.slope * (apart.size - 1))
    return bool(fall > FALL and trend.pvalue < CHANCE)
