"""A record cut at its gaps, and each piece of it on one even grid.

Where samples come evenly they keep their values, and what is missing between them is NaN. Where they do not, channels
are put on a grid by a curve through their samples that does not overshoot, at the record's own rate. A line would round
what bends between samples: from a log with a clock that jitters a delay comes out milliseconds short then.
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from workbench.errors import UserError
from workbench.records.sampling.clock import FEWEST, Stamps, spans
from workbench.records.sampling.sight import sample_time_mistake

JITTER = 0.2
"""Share of the sample time by which an instant may be off its grid."""

FAR = 3.0
"""Steps between two samples of a channel beyond which nothing is known there, and a record may be cut."""

SHORT_GAP = 0.1
"""s. What is missing no longer than this is a small gap, however many samples that are: a line may bridge an input."""

SPARSE = 1.5
"""Rows from one value of a channel to the next, in the middle, from which it has a slower clock of its own."""


@dataclass(frozen=True, eq=False)
class Series:
    """Channels with the stamps of one clock; NaN where a row has no value."""

    stamps: Stamps
    channels: Mapping[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class Piece:
    """Channels on an even grid of `step` (s), from `start` (s) after the record's first stamp on; NaN in small gaps."""

    start: float
    step: float
    channels: Mapping[str, np.ndarray]

    @property
    def size(self) -> int:
        """Its samples."""
        return next(iter(self.channels.values())).size

    @property
    def valid(self) -> np.ndarray:
        """Where every channel has a value."""
        return np.asarray(np.all([np.isfinite(values) for values in self.channels.values()], axis=0))


def longest_gap(step: float) -> float:
    """s that may be missing without a cut: `SHORT_GAP`, but of a slow record as much as `FAR` steps leave out."""
    return max(SHORT_GAP, (FAR - 1.0) * step)


def pieces_of(path: Path, series: Sequence[Series], sample_time: float | None) -> tuple[list[Piece], list[str]]:
    """The pieces of a record, in order, and in words what was done to its clock and is not in them.

    Raises:
        UserError: no piece is long enough, or no record has such a sample time.
    """
    notes = [note for one in series for note in one.stamps.notes]
    if sample_time is not None and (wrong := sample_time_mistake(sample_time)):
        raise UserError(f"{path}: sample_time: {wrong}")
    if len(series) == 1:
        found, said = _of_one_clock(series[0], sample_time)
    else:
        found, said = _of_many_clocks(path, series, sample_time)
    notes += said
    parts = [part for piece in found for part in _without_gaps(piece)]
    long = [part for part in parts if int(np.sum(part.valid)) >= FEWEST]
    notes += list(_missing(found))
    if not long:
        most = max((int(np.sum(part.valid)) for part in parts), default=0)
        raise UserError(
            f"{path}: its gaps leave pieces of at most {most} samples, expected {FEWEST}: {'; '.join(notes)}"
        )
    if len(parts) > 1:
        whole = sum(part.size * part.step for part in long)
        notes.insert(0, f"cut at its gaps into {len(long)} piece{'s' * (len(long) > 1)} of {whole:.4g} s in all")
    if short := [part for part in parts if part not in long]:
        seconds = sum(part.size * part.step for part in short)
        words = "1 shorter piece is" if len(short) == 1 else f"{len(short)} shorter pieces are"
        notes.append(f"{words} left out, of {seconds:.3g} s in all")
    return long, notes


def _of_one_clock(one: Series, sample_time: float | None) -> tuple[list[Piece], list[str]]:
    """The pieces between gaps of the clock itself."""
    time, starts = one.stamps.time, np.array(one.stamps.starts, dtype=int)
    steps = np.diff(time)
    anew = np.zeros(steps.size, dtype=bool)
    anew[starts - 1] = True
    step = float(np.median(steps[~anew]))
    step = float(np.mean(steps[~anew & (steps < (1.0 + JITTER) * step)]))  # the median is quantised where times are
    counts = np.maximum(np.rint(steps / step), 1.0)
    cut = anew | (steps > longest_gap(step) + step)
    off = ~cut & (np.abs(steps - counts * step) > JITTER * step)
    sparse = {name: own for name, values in one.channels.items() if (own := _own_step(values, time, step))}
    notes = []
    slow = max(sparse.values(), default=step)
    asked = sample_time is not None
    if sparse:
        names = " and ".join(sparse)
        notes.append(f"{names} ha{'s' if len(sparse) == 1 else 've'} a value every {slow:.3g} s alone")
    even = not asked and not sparse and not np.any(off)
    grid = sample_time if sample_time is not None else slow if sparse else float(np.median(steps[~anew]))
    if not even and not asked:
        notes.append(
            f"{100.0 * np.mean(off):.2g} % of the samples are off an even clock by over {100.0 * JITTER:.0f} % of its "
            f"step: all are put on an even grid of {1e3 * grid:.3g} ms, by a curve through the samples"
            if np.any(off)
            else f"all is put on an even grid of {1e3 * grid:.3g} ms"
        )
    edges = [0, *(np.flatnonzero(cut) + 1).tolist(), time.size]
    passed = np.concatenate([[0.0], np.cumsum(np.where(anew, step, steps))])  # a clock set back goes on
    found = []
    for first, last in itertools.pairwise(edges):
        part = {name: values[first:last] for name, values in one.channels.items()}
        if even:
            places = np.concatenate([[0], np.cumsum(counts[first : last - 1])]).astype(int)
            found.append(Piece(float(passed[first]), step, _placed(part, places)))
        elif last - first > 1:
            stamps = passed[first:last]
            points = stamps[0] + grid * np.arange(int((stamps[-1] - stamps[0]) / grid * (1.0 + 1e-12)) + 1)
            far = FAR * max(grid, slow, step)
            found.append(
                Piece(
                    float(stamps[0]),
                    grid,
                    {name: _between(points, stamps, values, far) for name, values in part.items()},
                )
            )
    return found, notes


def _of_many_clocks(path: Path, series: Sequence[Series], sample_time: float | None) -> tuple[list[Piece], list[str]]:
    """One piece over the time that all clocks have, on the grid of the coarsest; their gaps are in it as NaN.

    Raises:
        UserError: a clock starts anew, or they have no time in common.
    """
    if any(one.stamps.starts for one in series):
        raise UserError(f"{path}: a clock that starts anew cannot be put beside others; cut its file there, into two")
    own = [float(np.median(np.diff(one.stamps.time))) for one in series]
    step = sample_time if sample_time is not None else max(own)
    first = max(float(one.stamps.time[0]) for one in series)
    last = min(float(one.stamps.time[-1]) for one in series)
    if last - first < FEWEST * step:
        ranges = "; ".join(f"{one.stamps.time[0]:g} to {one.stamps.time[-1]:g} s" for one in series)
        raise UserError(f"{path}: the clocks of its files have {max(last - first, 0.0):.3g} s in common ({ranges})")
    points = first + step * np.arange(int((last - first) / step * (1.0 + 1e-12)) + 1)
    channels = {
        name: _between(points, one.stamps.time, values, FAR * max(step, mine))
        for one, mine in zip(series, own, strict=True)
        for name, values in one.channels.items()
    }
    return [Piece(0.0, step, channels)], [f"{len(series)} clocks are put on an even grid of {1e3 * step:.4g} ms"]


def _own_step(values: np.ndarray, time: np.ndarray, step: float) -> float:
    """The step (s) of a channel that has a value only every few rows; 0 of one that has its value in most."""
    rows = np.flatnonzero(np.isfinite(values))
    if rows.size < 2 or float(np.median(np.diff(rows))) < SPARSE:
        return 0.0
    return max(float(np.median(np.diff(time[rows]))), step)


def _placed(channels: Mapping[str, np.ndarray], places: np.ndarray) -> dict[str, np.ndarray]:
    """Channels at their places of a grid, NaN at others."""
    found = {}
    for name, values in channels.items():
        found[name] = np.full(int(places[-1]) + 1, np.nan)
        found[name][places] = values
    return found


def _between(points: np.ndarray, stamps: np.ndarray, values: np.ndarray, far: float) -> np.ndarray:
    """A channel at other instants, by a curve through its values that does not overshoot (Fritsch and Carlson 1980).

    NaN where these are more than `far` (s) apart.
    """
    known = np.isfinite(values)
    stamps, values = stamps[known], values[known]
    if stamps.size < 2:
        return np.full(points.size, np.nan)
    after = np.clip(np.searchsorted(stamps, points), 1, stamps.size - 1)
    apart = stamps[after] - stamps[after - 1]
    lost = ((apart > far) & (stamps[after] != points)) | (points < stamps[0]) | (points > stamps[-1])
    return np.where(lost, np.nan, PchipInterpolator(stamps, values)(points))


def _without_gaps(piece: Piece) -> Iterator[Piece]:
    """A piece cut where a channel is missing for longer than a small gap; ends without a value are cut off."""
    most = longest_gap(piece.step)
    cuts = [(a, b) for a, b in spans(~piece.valid) if (b - a) * piece.step > most or a == 0 or b == piece.size]
    edges = [0, *(place for cut in cuts for place in cut), piece.size]
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        if last > first:
            part = {name: values[first:last] for name, values in piece.channels.items()}
            yield Piece(piece.start + first * piece.step, piece.step, part)


def _missing(found: Sequence[Piece]) -> Iterator[str]:
    """Which channels are missing for long, and how much is in small gaps."""
    long: dict[str, list[tuple[float, float]]] = {}
    small, count = 0, 0
    for piece in found:
        most = longest_gap(piece.step)
        for name, values in piece.channels.items():
            for first, last in spans(~np.isfinite(values)):
                if (last - first) * piece.step > most:
                    ends = (piece.start + first * piece.step, piece.start + last * piece.step)
                    long.setdefault(name, []).append(ends)
        gaps = [b - a for a, b in spans(~piece.valid) if (b - a) * piece.step <= most]
        small, count = small + sum(gaps), count + len(gaps)
    for name, gaps_of in long.items():
        words = f"{name} is missing from {gaps_of[0][0]:g} s to {gaps_of[0][1]:g} s"
        rest = sum(end - begin for begin, end in gaps_of[1:])
        yield words + (f", and {len(gaps_of) - 1} times more, {rest:.3g} s in all" if rest else "")
    if small:
        samples = "1 sample" if small == 1 else f"{small} samples"
        yield f"{samples} in {count} gap{'s' * (count > 1)} {'is' if small == 1 else 'are'} left out"
