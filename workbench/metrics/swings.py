"""Is a motion over, where the record holds too few cycles to judge them? Its last swings, from extreme to extreme.

A swing ends where the motion comes back by more than a threshold: unlike a crossing it needs no midline, so that one
slow cycle is seen on any creep slower than itself.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from plants.compiled import njit

Ending = Literal["over", "falling", "going on"]

FADING = 0.7
"""A swing below this share of the one before falls: a cycle that does so twice in a row will soon be gone."""

SILENT = 2.5
"""A motion that has not swung for this many times the longest interval between its last swings is over."""


@dataclass(frozen=True)
class Swings:
    """How a motion ends; where it swings, the mean of its last swings (m) and twice their mean interval (s)."""

    ending: Ending
    size: float | None = None
    period: float | None = None


OVER = Swings("over")


def last_swings(time: np.ndarray, error: np.ndarray, threshold: float, judged_from: float) -> Swings:
    """What has become of the swings of an error (m) over a whole dwell: over before `judged_from` (s), or not.

    The first swing is the approach: a motion that comes back once does not swing yet. The last may be unfinished, and
    is left out where it is smaller than the one before.
    """
    turns = _turns(error, threshold)[-6:]
    if turns.size > 2 and abs(error[turns[-1]] - error[turns[-2]]) < FADING * abs(error[turns[-2]] - error[turns[-3]]):
        turns = turns[:-1]
    if turns.size < 4:
        return OVER
    passed = np.array([time[_middle(error, a, b)] for a, b in pairwise(turns)])
    if passed[-1] < judged_from or time[-1] - passed[-1] > SILENT * np.max(np.diff(passed)):
        return OVER
    sizes = np.abs(np.diff(error[turns]))[1:]
    falls = bool(np.all(sizes[1:] <= FADING * sizes[:-1])) and sizes.size > 2
    return Swings("falling" if falls else "going on", float(np.mean(sizes)), 2.0 * float(np.mean(np.diff(passed[1:]))))


def _middle(error: np.ndarray, start: int, stop: int) -> int:
    """Sample at which a swing last passes half its way."""
    half = 0.5 * (error[start] + error[stop])
    below = (error[start : stop + 1] < half) == (error[start] < half)
    return start + int(np.flatnonzero(below)[-1])


@njit(cache=True, nogil=True)
def _turns(values: np.ndarray, threshold: float) -> np.ndarray:
    """Samples at which `values` turns round by more than `threshold`, with the first and the last extreme."""
    turns = [0]
    low = high = rising = 0
    for i in range(1, values.size):
        if values[i] > values[high]:
            high = i
        if values[i] < values[low]:
            low = i
        if rising <= 0 and values[i] - values[low] > threshold:
            if rising < 0:
                turns.append(low)
            else:
                turns[0] = low
            rising, high = 1, i
        elif rising >= 0 and values[high] - values[i] > threshold:
            if rising > 0:
                turns.append(high)
            else:
                turns[0] = high
            rising, low = -1, i
    if rising > 0:
        turns.append(high)
    elif rising < 0:
        turns.append(low)
    return np.array(turns)
