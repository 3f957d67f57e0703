"""Whether channels that show the same motion agree: a measured velocity and the slope of the position."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from workbench.records.sampling.sight import window_points

ALIKE = 0.7
"""Correlation from which one channel is the rate of another, and the ratio of their sizes says something."""

EQUAL = 1.1
"""Ratio of their sizes up to which they agree."""

RATES = (("velocity", "position"), ("acceleration", "velocity"))
"""Channels, and those of which they are the rates."""


def agreement_notes(pieces: Sequence[Mapping[str, np.ndarray]], step: float) -> Iterator[str]:
    """In words how measured rates compare with the slopes of what was measured, by the channels of a record's pieces;
    `step` (s) is the time between samples.

    Means of the rate over a smoothing window are held against the way over it: noise of either hardly counts. The
    ratio is that of their deviations, which noise of either lowers or raises alike.
    """
    points = window_points(step)
    for rate, of in RATES:
        if rate not in pieces[0] or of not in pieces[0]:
            continue
        parts = [_both(channels[rate], channels[of], points, step) for channels in pieces]
        mean, slope = (np.concatenate([part[place] for part in parts]) for place in (0, 1))
        if mean.size < 3 or not np.std(slope):
            continue
        if not np.std(mean):
            yield f"{rate} is {mean[0]:g} throughout, and {of} changes: is this its column?"
            continue
        alike, ratio = float(np.corrcoef(mean, slope)[0, 1]), float(np.std(mean) / np.std(slope))
        if abs(alike) < ALIKE:
            yield f"{rate} does not follow the slope of {of} (correlation {alike:.2g}): is this its column?"
        elif alike < 0.0:
            yield f"{rate} goes against the slope of {of}: one of the two has the wrong sign"
        elif not 1.0 / EQUAL < ratio < EQUAL:
            yield f"{rate} is {ratio:.3g} times the slope of {of}: one of the two has a wrong unit or scale"
        else:
            yield f"{rate} agrees with the slope of {of}: {ratio:.3g} times it"


def _both(rate: np.ndarray, values: np.ndarray, points: int, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Means of a rate over windows one after the other, and the slope of what it is the rate of; none in gaps."""
    count = (values.size - 1) // points
    edges = values[: count * points + 1 : points]
    slope = np.diff(edges) / (points * step)
    middle = 0.5 * (rate[:-1] + rate[1:])[: count * points]
    mean = middle.reshape(count, points).mean(axis=1)
    known = np.isfinite(mean) & np.isfinite(slope)
    return mean[known], slope[known]
