"""Measured records: read from files, put on an even grid, and judged before anything is made of them.

What is wrong with a whole record is an error of one line. A short gap is kept as a gap: NaN in the channels and
False in `valid`; nobody fills it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from workbench.errors import UserError, nearest
from workbench.records.checks import LONGEST_GAP, check_alive, check_directions, check_ranges, gap_notes
from workbench.records.experiment import Experiment, RecordSpec
from workbench.records.tables import read_column, read_table

JITTER = 0.2
"""Share of the sample time by which an instant may be off its grid."""

FAR = 3.0
"""Steps of an even grid between two samples beyond which nothing is known there."""

FEWEST = 50
"""Samples below which there is nothing to identify."""


@dataclass(frozen=True, eq=False)
class Record:
    """A record in SI on an even grid from time 0; NaN where nothing was measured.

    `valid` is True where every channel has a value; `notes` say in words what was left out.
    """

    label: str
    path: Path
    use: str
    rpm: float
    time: np.ndarray
    channels: Mapping[str, np.ndarray]
    valid: np.ndarray
    notes: tuple[str, ...] = ()

    @property
    def sample_time(self) -> float:
        """Time between samples (s)."""
        return float(self.time[1] - self.time[0])


def read_records(experiment: Experiment, use: str | None = "fit") -> list[Record]:
    """The records of an experiment that are for that `use` (None: all), in the order of the file.

    Raises:
        UserError: a record that cannot be used, and why.
    """
    return [read_record(spec, experiment) for spec in experiment.records if use in (None, spec.use)]


def read_record(spec: RecordSpec, experiment: Experiment) -> Record:
    """One record, read, converted and validated.

    Raises:
        UserError: unreadable, a missing column, or numbers that cannot be what they are called.
    """
    table = read_table(spec.path)
    table = table.iloc[spec.skip : None if spec.rows is None else spec.skip + spec.rows]
    columns = {name: read_column(spec.path, table, name, channel) for name, channel in experiment.channels.items()}
    if spec.sample_time is not None:
        columns = _resampled(spec.path, columns, spec.sample_time)
    time, places, step = _grid(spec.path, columns.pop("time"))
    rpm = _rpm(spec, table)
    channels = {}
    for name, values in columns.items():
        channels[name] = np.full(time.size, np.nan)
        channels[name][places] = values
    valid = np.all([np.isfinite(values) for values in channels.values()], axis=0)
    notes = tuple(gap_notes(spec.path, channels, valid, step))
    for name, values in channels.items():
        check_alive(spec.path, name, values)
    check_ranges(spec.path, channels, experiment)
    check_directions(spec.path, channels, step)
    return Record(spec.label, spec.path, spec.use, rpm, time, channels, valid, notes)


def _rpm(spec: RecordSpec, table: pd.DataFrame) -> float:
    """The speed of rotation (rpm) of a record: as the experiment says, or the one value of the column it names."""
    if not isinstance(spec.rpm, str):
        return spec.rpm
    if spec.rpm not in table:
        raise UserError(f'{spec.path}: no column "{spec.rpm}" for rpm; {nearest(spec.rpm, map(str, table.columns))}')
    values = pd.to_numeric(table[spec.rpm], errors="coerce").unique()
    if values.size != 1 or not values[0] >= 0.0:
        raise UserError(f'{spec.path}: column "{spec.rpm}" holds no one speed of rotation; give rpm as a number')
    return float(values[0])


def _resampled(path: Path, columns: Mapping[str, np.ndarray], step: float) -> dict[str, np.ndarray]:
    """Channels on an even grid, linearly between their samples; NaN where samples are more than `FAR` steps apart."""
    time = columns["time"]
    _check_time(path, time)
    grid = time[0] + step * np.arange(int((time[-1] - time[0]) / step) + 1)
    after = np.clip(np.searchsorted(time, grid), 1, time.size - 1)
    far = (time[after] - time[after - 1] > FAR * step) & (time[after] != grid)
    resampled = {name: np.where(far, np.nan, np.interp(grid, time, values)) for name, values in columns.items()}
    gaps = np.diff(time)
    if np.any(gaps > LONGEST_GAP):
        row = int(np.argmax(gaps > LONGEST_GAP))
        raise UserError(
            f"{path}: the time jumps by {gaps[row]:g} s after {row + 1} rows of those taken; cut the record there, "
            "into two, by skip and rows of [[records]]"
        )
    return {**resampled, "time": grid}


def _check_time(path: Path, time: np.ndarray) -> None:
    """Raise UserError where times are too few, no numbers, or do not go on."""
    if time.size < FEWEST:
        raise UserError(f"{path}: holds {time.size} samples, expected at least {FEWEST}")
    if not np.all(np.isfinite(time)):
        raise UserError(f"{path}: row {int(np.argmin(np.isfinite(time))) + 2}: the time is no number")
    steps = np.diff(time)
    if np.any(steps <= 0.0):
        row = int(np.argmax(steps <= 0.0)) + 3
        word = "goes back" if steps[row - 3] < 0.0 else "stands still"
        raise UserError(f"{path}: row {row}: the time {word}, from {time[row - 3]:g} s to {time[row - 2]:g} s")


def _grid(path: Path, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """An even grid (s, from 0) that spans the record, the place of each row on it, and its step."""
    _check_time(path, time)
    steps = np.diff(time)
    step = float(np.median(steps))
    inside = steps < (1.0 + JITTER) * step
    step = float(np.mean(steps[inside]))  # the median is quantised where the times are rounded
    if np.any(steps > LONGEST_GAP + step):
        row = int(np.argmax(steps > LONGEST_GAP + step)) + 2
        raise UserError(
            f"{path}: row {row}: the time jumps by {steps[row - 2]:g} s (samples are {step:g} s apart); "
            "cut the record there, into two"
        )
    counts = np.maximum(np.rint(steps / step), 1.0)
    off = np.abs(steps - counts * step) > JITTER * step
    if np.any(off):
        row = int(np.argmax(off)) + 2
        raise UserError(
            f"{path}: row {row}: the next sample comes after {steps[row - 2]:g} s where {step:g} s are usual; "
            "expected even sampling"
        )
    places = np.concatenate([[0], np.cumsum(counts)]).astype(int)
    return step * np.arange(places[-1] + 1), places, step
