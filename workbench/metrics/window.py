"""Which samples of a run count: a window without the transient, and the dwells of the reference within it."""

import math
from dataclasses import dataclass

import numpy as np

from workbench.simulation.references import ReferenceSignal

SLACK = 1e-6
"""Instants this close, in samples, are the same; a whole number of periods may lack this fraction of one."""


@dataclass(frozen=True)
class Window:
    """The samples from `start` to the end of the run. `periods` of the reference fit, 0: it has none, or none fits."""

    start: int
    periods: int

    @property
    def samples(self) -> slice:
        """The window as a slice of arrays over time."""
        return slice(self.start, None)


def find_window(time: np.ndarray, reference: ReferenceSignal | None, transient: float) -> Window | None:
    """The last whole number of periods that fits in [transient, end], else all of it; None with too few samples.

    Whole periods T leave out their first instant: n T / h samples, so that no instant counts twice. `time` and
    `transient` in s.
    """
    if time.size < 2:
        return None
    start, periods = first_sample(time, transient), 0
    period = reference.period if reference is not None else None
    if period is not None:
        periods = whole_periods(float(time[-1]) - transient, period)
    if periods > 0:
        sample_time = time[1] - time[0]
        start = max(0, time.size - round(periods * float(period or 0.0) / sample_time))
    return Window(start, periods) if time.size - start >= 2 else None


def whole_periods(duration: float, period: float) -> int:
    """How many periods (s) fit in a `duration` (s)."""
    return max(0, math.floor(duration / period + SLACK))


def first_sample(time: np.ndarray, instant: float) -> int:
    """Index of the first sample at or after `instant` (s)."""
    return int(np.searchsorted(time, instant - SLACK * (time[1] - time[0])))


def find_dwells(time: np.ndarray, reference: ReferenceSignal | None, transient: float) -> list[slice]:
    """Samples of each dwell that ends after `transient` (s); at a jump the sample belongs to the later dwell."""
    if reference is None:
        return []
    found = []
    for begin, end in reference.dwells(float(time[-1])):
        stop = time.size if end >= time[-1] else first_sample(time, end)
        start = first_sample(time, begin)
        if end > transient and stop > start:
            found.append(slice(start, stop))
    return found
