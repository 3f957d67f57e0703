"""Does the actuator hunt? The verdict over one dwell, a span in which the reference is constant.

How it is judged, on the second half of the dwell (the first is transient):

- Half waves between hysteretic crossings of the motion's own midline (`workbench.metrics.half_waves`): at least 4
  cycles. They count where they are regular, the standard deviation of their periods up to 25 % of the mean, or where
  they stand clear of the noise band: two tones and beats are irregular, and so is noise that touches its band.
- decaying: the amplitude falls (`workbench.metrics.envelope`), or the cycles end before the record does. Of a fast fall
  2.5 cycles are enough: each smaller than the one before, the last less than half the first.
- sustained: at least 4 cycles that do not. One that grows is on its way to its limit cycle.
- too_short: fewer than 4 cycles, and the motion is not over (`workbench.metrics.swings`: it swung back in the second
  half, and neither falls from swing to swing nor has been still for long), or the rod rests beside its reference while
  the command still grows, as that of an integral does until the rod breaks away. A longer dwell decides
  (`workbench.study.run_on`).
- none: everything else: at rest, or a creep that never comes back. While the last quarter still moves out of the noise
  it is not settled: part of a cycle slower than the dwell looks like an approach.
- What a controller forces on the plant, such as dither, is no limit cycle: the error is averaged over one period of it
  first, and a cycle of that period is none.

A verdict should be confirmed with half the step. A motion that beats with a period longer than what is judged is taken
for what it does there.
"""

from dataclasses import dataclass
from typing import get_args

import numpy as np

from workbench.metrics.envelope import dies
from workbench.metrics.half_waves import FEW_CYCLES, HalfWaves, find_half_waves
from workbench.metrics.swings import last_swings
from workbench.metrics.verdicts import Verdict
from workbench.simulation.run import STUCK_SPEED

HUNTING: tuple[Verdict, ...] = ("too_short", "sustained")
"""Verdicts of a loop that hunts, or of which the longest record cannot say that it does not."""

ORDER: tuple[Verdict, ...] = get_args(Verdict)
"""From the best to the worst."""

FLOOR = 1e-8
"""m. The band's least half-width: above the solver's error at its default tolerance, far below any sensor's step."""

LEAST_SAMPLES = 3

CLEAR = 2.0
"""Irregular half waves count from a mean height of this many times the band."""

SWING = 3.0
"""A swing counts from this many times the band, peak to peak: noise of a third of the band does not reach it."""

LEAST_SWING = 1e-6
"""m. Irregular half waves, or a few swings, that are smaller than this are nothing to wait for."""

STOPPED = 1.5
"""Cycles have ended where none has come for this many times the longest period."""

RESTING = 0.1
"""And where what comes after them is below this share of their amplitude, or within the noise."""

FALLEN = 0.25
"""A cycle that has fallen below this share of its strength within what is judged is taken to die."""

FORCED_SPREAD = 0.10
"""A cycle whose period is within this share of the forced one is the forced one."""

BLOCKS = 8
"""A creep is seen in the means of so many parts."""

STILL_GROWS = 0.8
"""A command still grows whose change over a quarter of the dwell is this share of that over the quarter before."""

STICKING_SHARE = 0.10
SLOW = 0.10
"""Sticking: more than `STICKING_SHARE` of the time slower than STUCK_SPEED and than `SLOW` times the mean speed of the
cycle. A sine spends 4 % of its time below a tenth of its mean speed, so that a small cycle is not a sticking one."""


@dataclass(frozen=True)
class LimitCycle:
    """Verdict over a dwell. `amplitude` (m, peak to peak) and `period` (s): means over the cycles; None without.

    `settled`: a longer dwell is not needed. One that is too short is not, nor one that still creeps, nor one that
    decays and has not fallen to `FALLEN` yet: it may be on its way to a smaller limit cycle.
    """

    verdict: Verdict
    amplitude: float | None = None
    period: float | None = None
    sticking: bool = False
    settled: bool = True


NONE = LimitCycle("none")


def judge(
    time: np.ndarray,
    error: np.ndarray,
    velocity: np.ndarray,
    band: float,
    transient: float = 0.0,
    forced: float = 0.0,
    command: np.ndarray | None = None,
) -> LimitCycle:
    """Verdict over one dwell from samples of time (s), tracking error (m) and velocity (m/s).

    What lies before `transient` (s) is left out, and at least the first half of the dwell.

    `band` (m) is the half-width of the hysteresis: the larger of three standard deviations of the position noise and
    the sensor's step; at least `FLOOR`. `forced` (s): period of what the controller itself puts on the plant; 0: none.
    `command`: what the controller asks of the plant, in any unit; without it a rod that rests is at rest.
    """
    begin = int(np.searchsorted(time, transient))
    start = max(time.size // 2, begin)
    if time.size - start < LEAST_SAMPLES:
        return NONE
    band = max(band, FLOOR)
    if forced:
        from scipy.ndimage import uniform_filter1d  # a run that nothing shakes does not wait for it

        error = uniform_filter1d(error, max(1, round(forced / (time[1] - time[0]))), mode="nearest")
    late, errors = time[start:], error[start:]
    waves = find_half_waves(late, errors, band) if np.ptp(errors) > 2.0 * band else None
    if waves is not None:
        return _of_cycles(waves, late, errors, velocity[start:], band, forced)
    fading = find_half_waves(late, errors, band, FEW_CYCLES)
    if fading is not None and _falls_fast(fading.amplitudes):
        return LimitCycle("decaying", float(np.mean(fading.amplitudes)), float(np.mean(fading.periods)))
    swing = max(SWING * band, LEAST_SWING)
    seen = last_swings(time[begin:], error[begin:], swing, time[start])
    if seen.ending == "falling":
        return LimitCycle("decaying", seen.size, seen.period)
    pushed = command is not None and _is_pushed(late, errors, command[start:], swing)
    if pushed or seen.ending == "going on":
        return LimitCycle("too_short", seen.size, seen.period, settled=False)
    return LimitCycle("none", settled=not _creeps(errors[errors.size // 2 :], max(0.5 * band, LEAST_SWING)))


def worst(verdicts: list[LimitCycle]) -> LimitCycle:
    """The verdict that counts for a run of several dwells: the last of `ORDER`, then the larger cycle."""
    return max(verdicts, key=lambda found: (ORDER.index(found.verdict), found.amplitude or 0.0))


def _of_cycles(
    waves: HalfWaves, time: np.ndarray, error: np.ndarray, velocity: np.ndarray, band: float, forced: float
) -> LimitCycle:
    """Verdict where there are enough half waves."""
    if not waves.regular and np.mean(waves.heights) < max(CLEAR * band, LEAST_SWING):
        return NONE
    amplitude, period = float(np.mean(waves.amplitudes)), float(np.mean(waves.periods))
    if forced and abs(period / forced - 1.0) < FORCED_SPREAD:
        return NONE
    cycling = (time >= waves.crossings[0]) & (time <= waves.crossings[-1])
    slow = min(STUCK_SPEED, SLOW * 2.0 * amplitude / period)
    sticking = bool(np.mean(np.abs(velocity[cycling]) < slow) > STICKING_SHARE)
    if _have_ended(waves, time, error, band):
        return LimitCycle("decaying", amplitude, period, sticking)
    if dies(waves.strengths):
        fallen = bool(waves.strengths[-1] < FALLEN * waves.strengths[0])
        return LimitCycle("decaying", amplitude, period, sticking, fallen)
    return LimitCycle("sustained", amplitude, period, sticking)


def _have_ended(waves: HalfWaves, time: np.ndarray, error: np.ndarray, band: float) -> bool:
    """Whether nothing comes after the last crossing: neither a crossing for long, nor a motion on a creep."""
    rest = time > waves.crossings[-1] + 0.5 * np.mean(waves.periods)
    if time[-1] - waves.crossings[-1] < STOPPED * np.max(waves.periods) or np.sum(rest) < LEAST_SAMPLES:
        return False
    left = np.ptp(error[rest] - np.polynomial.Polynomial.fit(time[rest], error[rest], 1)(time[rest]))
    amplitude = np.mean(waves.amplitudes)
    return bool(left < max(RESTING * amplitude, min(SWING * band, 0.5 * amplitude)))


def _falls_fast(amplitudes: np.ndarray) -> bool:
    """Whether each of few amplitudes (m) is smaller than the one before, and the last less than half the first."""
    return bool(np.all(np.diff(amplitudes) < 0.0)) and amplitudes[-1] < 0.5 * amplitudes[0]


def _creeps(error: np.ndarray, least: float) -> bool:
    """Whether an error moves on by more than `least` (m), noise averaged out."""
    if error.size < BLOCKS * LEAST_SAMPLES:
        return False
    return bool(np.ptp([np.mean(part) for part in np.array_split(error, BLOCKS)]) > least)


def _is_pushed(time: np.ndarray, error: np.ndarray, command: np.ndarray, least: float) -> bool:
    """Whether the rod rests beside its reference, by at least `least` (m), while the command grows along a line.

    Judged since it last slipped, by more than what is left, if that is not just now. A creep along which the command
    falls, or grows ever more slowly, is none.
    """
    moved = np.flatnonzero(np.abs(error - error[-1]) > max(least, abs(error[-1])))
    begin = min(moved[-1] + 1 if moved.size else 0, error.size // 2)
    time, error, command = time[begin:], error[begin:], command[begin:]
    half = time.size // 2
    beside = float(np.mean(error[half:]))
    if half < LEAST_SAMPLES or abs(beside) < least:
        return False
    first, second = (_growth(time[part], command[part]) for part in (slice(half), slice(half, None)))
    return abs(second) > STILL_GROWS * abs(first) and (second > 0.0) == (beside > 0.0)


def _growth(time: np.ndarray, command: np.ndarray) -> float:
    """Change of the command along its line; 0 where that is within what scatters about it."""
    line = np.polynomial.Polynomial.fit(time, command, 1)
    change = float(line(time[-1]) - line(time[0]))
    scatter = float(np.std(command - line(time)))
    least = max(1e-3 * float(np.max(np.abs(command))), 10.0 * scatter / np.sqrt(time.size))
    return change if abs(change) > least else 0.0
