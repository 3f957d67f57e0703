"""What can be seen at a rate: the window over which a record is smoothed, and what is too fast for it."""

import math

WINDOW = 0.06
"""s over which channels are smoothed: 61 points at 1 kHz."""

FEWEST = 7
"""Points of the shortest window."""

SLOW = 0.02
"""s between samples beyond which a record does not show its inputs between them, nor what a force does at once."""

SHORTEST, LONGEST = 1e-7, 1e6
"""s between samples of any record: outside, its clock is in another unit, or none."""

LAG = math.sqrt(3.0) / (2.0 * math.pi)
"""Time constant, over the period that a first-order lag halves."""


def sample_time_mistake(sample_time: float) -> str:
    """Why a record cannot have this sample time (s), in words; "" where it can."""
    if SHORTEST <= sample_time <= LONGEST:
        return ""
    return (
        f"{sample_time:.3g} s between samples, expected {SHORTEST:g} to {LONGEST:g} s: is the unit of its time right?"
    )


def window_points(sample_time: float) -> int:
    """Points of the smoothing window, odd."""
    return max(_points(sample_time), FEWEST)


def _points(sample_time: float) -> int:
    return 2 * round(0.5 * WINDOW / sample_time) + 1


def sight_note(sample_time: float) -> str:
    """What a record of this sample time (s) cannot show; empty where the window is as short as that of a fast one.

    A Hann window of n points halves what has a period of n + 1 samples; so does a first-order lag of
    `LAG` such periods. How late a channel is shows by a part of a sample, since the slope from sample
    to sample is measured, but the path between them is not.
    """
    if _points(sample_time) >= FEWEST:
        return ""
    period = (FEWEST + 1) * sample_time
    return (
        f"at {1.0 / sample_time:.3g} Hz nothing is seen that is faster than {_two(1.0 / period)} Hz: no time constant "
        f"below {_two(1e3 * period * LAG)} ms, and a delay to a fraction of a sample of "
        f"{_two(1e3 * sample_time)} ms"
    )


def _two(number: float) -> str:
    return f"{float(f'{number:.2g}'):g}"
