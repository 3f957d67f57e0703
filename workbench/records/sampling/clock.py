"""The stamps of a record's clock: those that are no numbers, are repeated or late, and a clock that starts anew."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.errors import UserError
from workbench.records.sampling.sight import sample_time_mistake

FEWEST = 50
"""Samples below which there is nothing to identify."""

LATE = 10
"""Stamps on end before the latest one up to which they were sent late; more are a clock that was set back."""

MOST_LOST = 0.5
"""Share of the stamps that may be out of order."""

MOST_STARTS = 100
"""Times that a clock may be set back: one that is more often is none."""


@dataclass(frozen=True, eq=False)
class Stamps:
    """Rows of a table whose stamps go on, in order; where among them the clock starts anew; what was dropped, in words.

    Of `time` (s) each part goes on, from one start of the clock to the next.
    """

    rows: np.ndarray
    time: np.ndarray
    starts: tuple[int, ...]
    notes: tuple[str, ...]


def spans(mask: np.ndarray) -> Iterator[tuple[int, int]]:
    """First place, and one beyond the last, of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def stamps_of(path: Path, time: np.ndarray) -> Stamps:
    """The stamps (s) of a table that can be used.

    Dropped are those that are no numbers, lone ones ahead of those that follow, and those that are not after all before
    them. After more than `LATE` such stamps on end the clock was set back, and starts anew.

    Raises:
        UserError: too few are left, or most are out of order.
    """
    rows = np.flatnonzero(np.isfinite(time))
    lost = time.size - rows.size
    notes = [f"{_rows(lost)} without a time {_are(lost)} dropped"] if lost else []
    ahead = _ahead(time[rows])
    rows = rows[~ahead]
    kept, starts, late, repeated = list[np.ndarray](), list[int](), 0, 0
    while rows.size:
        stamps = time[rows]
        latest = np.concatenate([[-np.inf], np.maximum.accumulate(stamps)[:-1]])
        behind = stamps <= latest
        back = next((a for a, b in spans(behind) if b - a > LATE and stamps[a] < latest[a]), rows.size)
        repeated += int(np.sum(stamps[:back] == latest[:back]))
        late += int(np.sum(stamps[:back] < latest[:back]))
        kept.append(rows[:back][~behind[:back]])
        rows = rows[back:]
        starts += [sum(part.size for part in kept)] * bool(rows.size)
        if len(starts) > MOST_STARTS:
            break
    out = late + repeated + int(np.sum(ahead))
    if len(starts) > MOST_STARTS or out > MOST_LOST * time.size:
        raise UserError(f"{path}: {_disorder(out, repeated, time.size, len(starts))}")
    for count, words in (
        (repeated, "whose time repeats the one before"),
        (late, "whose time is before that of an earlier one"),
        (int(np.sum(ahead)), "whose time is ahead of those that follow"),
    ):
        notes += [f"{_rows(count)} {words} {_are(count)} dropped"] * bool(count)
    found = np.concatenate([*kept, np.empty(0, dtype=int)]).astype(int)
    if found.size < FEWEST:
        left = f" with a time that goes on ({time.size} rows)" if found.size < time.size else ""
        held = "1 sample" if found.size == 1 else f"{found.size} samples"
        raise UserError(f"{path}: holds {held}{left}, expected at least {FEWEST}")
    steps = np.diff(time[found])
    if wrong := sample_time_mistake(float(np.median(steps[steps > 0.0]))):
        raise UserError(f"{path}: {wrong}")
    if starts:
        notes.append(f"the clock starts anew {len(starts)} time{'s' * (len(starts) > 1)}: cut there")
    return Stamps(found, time[found], tuple(starts), tuple(notes))


def _ahead(stamps: np.ndarray) -> np.ndarray:
    """Lone stamps that are after those that follow, which go on from the ones before."""
    ahead = np.zeros(stamps.size, dtype=bool)
    if stamps.size > 3:
        before, own, after, later = stamps[:-3], stamps[1:-2], stamps[2:-1], stamps[3:]
        ahead[1:-2] = (own > after) & (own > later) & (before < after) & (after < later)
    return ahead


def _disorder(out: int, repeated: int, size: int, starts: int) -> str:
    if starts > MOST_STARTS:
        return f"the time goes back again and again, more than {MOST_STARTS} times: is this its column?"
    share = f"{100.0 * out / size:.0f} % of the time stamps are out of order"
    if 2 * repeated > out:
        return f"{share}, repeated most of them: is the time rounded? Give a column with all its digits"
    return f"{share}: is this the column of the time?"


def _rows(count: int) -> str:
    return f"{count} row{'s' * (count != 1)}"


def _are(count: int) -> str:
    return "is" if count == 1 else "are"
