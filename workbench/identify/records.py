"""Measured records: read from CSV, Parquet or MAT, converted to SI, and judged before anything is made of them.

What is wrong with a whole record is an error of one line. A short gap is kept as a gap: NaN in the channels and
False in `valid`; nobody fills it.
"""

import csv
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.io import loadmat

from workbench.errors import UserError, nearest
from workbench.identify.experiment import ChannelSpec, Experiment, RecordSpec

JITTER = 0.2
"""Share of the sample time by which an instant may be off its grid."""

LONGEST_GAP = 0.1
"""s. What is missing for longer is no small gap."""

MOST_MISSING = 0.05
"""Share of a record that may be missing in small gaps."""

SATURATED_SHARE = 0.05
"""Share of samples at the very same largest or smallest value from which a channel is saturated."""

LINES_LOOKED_AT = 100
"""Of a CSV file, to see whether its numbers have a decimal comma."""

DECIMAL_COMMA, DECIMAL_POINT = (re.compile(rf"[+-]?\d*{mark}\d+([eE][+-]?\d+)?") for mark in (",", r"\."))

BEYOND = 1.05
"""A position or pressure beyond its range by more than a sensor's error: 5 %."""

LEAST_PRESSURE = {1: 1e-3, 2: 0.02}
"""Share of the supply pressure that the pressures reach, of one channel and of both chambers: one of them is fed."""

FAR = 3.0
"""Steps of an even grid between two samples beyond which nothing is known there."""

ARRIVAL = 10
"""Samples before a channel rests at its extreme: in them one that was held there creeps, one cut off still moves."""

FEWEST = 50
"""Samples below which there is nothing to identify."""

MOVING = ("position", "pressure_1", "pressure_2", "rotation_angle", "force")
"""Channels that cannot be constant to the last digit unless they are stuck."""


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
    table = _table(spec.path)
    table = table.iloc[spec.skip : None if spec.rows is None else spec.skip + spec.rows]
    columns = {name: _column(spec.path, table, name, channel) for name, channel in experiment.channels.items()}
    if spec.sample_time is not None:
        columns = _resampled(spec.path, columns, spec.sample_time)
    time, places, step = _grid(spec.path, columns.pop("time"))
    rpm = _rpm(spec, table)
    channels = {}
    for name, values in columns.items():
        channels[name] = np.full(time.size, np.nan)
        channels[name][places] = values
    valid = np.all([np.isfinite(values) for values in channels.values()], axis=0)
    notes = tuple(_gaps(spec.path, channels, valid, step))
    for name, values in channels.items():
        _check_alive(spec.path, name, values)
    _check_ranges(spec.path, channels, experiment)
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


def _table(path: Path) -> pd.DataFrame:
    if not path.exists():
        raise UserError(f"{path}: no such file; make the records first, or correct `file` of [[records]]")
    try:
        if path.suffix == ".parquet":
            return pd.read_parquet(path)
        if path.suffix == ".mat":
            return _mat(path)
        return _text(path)
    except (OSError, EOFError, ValueError, csv.Error, NotImplementedError) as error:
        raise UserError(f"{path}: cannot be read as a table ({' '.join(str(error).split())})") from None


def _text(path: Path) -> pd.DataFrame:
    """A text file of any separator, also compressed (.gz); a first row of numbers alone is no header, but data."""
    if path.suffix != ".gz" and (separator := _european(path)):
        return pd.read_csv(path, sep=separator, decimal=",", skipinitialspace=True)
    first = pd.read_csv(path, sep=None, engine="python", skipinitialspace=True, header=None, nrows=1).iloc[0]
    header = None if pd.to_numeric(first, errors="coerce").notna().all() else 0
    return pd.read_csv(path, sep=None, engine="python", skipinitialspace=True, header=header)


def _european(path: Path) -> str:
    """The separator of a CSV file whose numbers have a decimal comma; empty for any other."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        lines = [line.rstrip("\r\n") for line, _ in zip(file, range(LINES_LOOKED_AT), strict=False) if line.strip()]
    for separator in (";", "\t"):
        rows = [line.split(separator) for line in lines[1:]]
        fields = [field.strip() for row in rows for field in row]
        if not lines or separator not in lines[0] or any(DECIMAL_POINT.fullmatch(field) for field in fields):
            continue
        if any(DECIMAL_COMMA.fullmatch(field) for field in fields):
            return separator
    return ""


def _mat(path: Path) -> pd.DataFrame:
    """All vectors of a MAT file (to version 7.2) that are as long as its longest."""
    content = {name: np.ravel(value) for name, value in loadmat(path).items() if not name.startswith("__")}
    numeric = {name: value for name, value in content.items() if value.dtype.kind in "iuf" and value.size > 1}
    longest = max((value.size for value in numeric.values()), default=0)
    return pd.DataFrame({name: value for name, value in numeric.items() if value.size == longest})


def _column(path: Path, table: pd.DataFrame, name: str, channel: ChannelSpec) -> np.ndarray:
    """A channel in SI; text that is no number becomes NaN."""
    numbers = pd.to_numeric(table.iloc[:, _place(path, table, name, channel)], errors="coerce").to_numpy(dtype=float)
    if not np.any(np.isfinite(numbers)):
        raise UserError(f'{path}: column "{channel.column}" ({name}) holds no numbers')
    return numbers * channel.factor + channel.offset


def _place(path: Path, table: pd.DataFrame, name: str, channel: ChannelSpec) -> int:
    """The number, from 0, of a channel's column."""
    count = table.shape[1]
    if isinstance(channel.column, int):
        if channel.column >= count:
            raise UserError(
                f"{path}: no column {channel.column} for {name}: it has {count} columns, and they count from 0 to "
                f"{count - 1}"
            )
        return channel.column
    headers = [str(column).strip() for column in table.columns]
    if channel.column in headers:
        return headers.index(channel.column)
    if not any(isinstance(column, str) for column in table.columns):
        raise UserError(
            f'{path}: no column "{channel.column}" for {name}: the file has no header; give the number of the column '
            f"from 0 to {count - 1}, such as column = 0"
        )
    raise UserError(f'{path}: no column "{channel.column}" for {name}; {nearest(channel.column, headers)}')


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


def spans(mask: np.ndarray) -> Iterator[tuple[int, int]]:
    """First place, and one beyond the last, of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def _gaps(path: Path, channels: Mapping[str, np.ndarray], valid: np.ndarray, step: float) -> Iterator[str]:
    """What is missing, in words; too much of it is an error."""
    for name, values in channels.items():
        for first, last in spans(~np.isfinite(values)):
            if (last - first) * step > LONGEST_GAP:
                raise UserError(
                    f"{path}: {name} is missing from {first * step:g} s to {last * step:g} s; cut the record there"
                )
    missing = np.mean(~valid)
    if missing > MOST_MISSING:
        raise UserError(f"{path}: {100.0 * missing:.0f} % of the samples lack a value, expected at most 5 %")
    if missing > 0.0:
        count = len(list(spans(~valid)))
        yield f"{int(np.sum(~valid))} samples in {count} gap{'s' * (count > 1)} are left out"


def _check_alive(path: Path, name: str, values: np.ndarray) -> None:
    """A stuck channel has one value; a saturated one rests at its extreme and nowhere near it."""
    known = values[np.isfinite(values)]
    low, high = float(np.min(known)), float(np.max(known))
    if low == high:
        if name in MOVING:
            raise UserError(f"{path}: {name} is stuck: {low:g} throughout; is this its column?")
        return
    if name not in MOVING:
        return
    for extreme, word in ((high, "largest"), (low, "smallest")):
        at = values == extreme
        first, last = max(spans(at), key=lambda span: span[1] - span[0])
        longest = last - first
        beside = np.unique(known)
        held = abs(values[max(first - ARRIVAL, 0)] - extreme) < 2.5 * float(np.min(np.diff(beside)))
        next_to = float(beside[-2] if extreme == high else beside[1])
        # Slow motion rests at a converter's step, but at the next one as long; what is cut off piles up at its wall.
        crowded = np.sum(at) > 5 * max(1, int(np.sum(known == next_to)))
        if longest > SATURATED_SHARE * values.size and crowded and not held:
            raise UserError(
                f"{path}: {name} is saturated: at its {word} value {extreme:g} for {longest} samples on end; "
                "use a sensor or an amplifier of larger range, or cut the record"
            )


def _check_ranges(path: Path, channels: Mapping[str, np.ndarray], experiment: Experiment) -> None:
    """Positions outside the stroke, pressures above supply, rates too low: mostly wrong units."""
    values = experiment.values
    if "position" in channels and np.isfinite(values.get("stroke", np.inf)):
        span = float(np.nanmax(channels["position"]) - np.nanmin(channels["position"]))
        if span > BEYOND * values["stroke"]:
            raise UserError(
                f"{path}: the position spans {span:g} m, and the stroke is {values['stroke']:g} m; "
                f"is the unit of channel position right?{_unit_hint(span, values['stroke'])}"
            )
    supply = values.get("supply_pressure")
    for name in ("pressure_1", "pressure_2"):
        if supply is None or name not in channels:
            continue
        largest = float(np.nanmax(np.abs(channels[name])))
        if largest > BEYOND * supply:
            raise UserError(
                f"{path}: {name} reaches {largest:g} Pa, and the supply is {supply:g} Pa; "
                f"is the unit of channel {name} right?{_unit_hint(largest, supply)}"
            )
        both = [channels[other] for other in ("pressure_1", "pressure_2") if other in channels]
        if max(float(np.nanmax(np.abs(values))) for values in both) < LEAST_PRESSURE[len(both)] * supply:
            raise UserError(
                f"{path}: {name} stays below {largest:g} Pa, and the supply is {supply:g} Pa; "
                f"is the unit of channel {name} right?{_unit_hint(largest, supply)}"
            )


def _unit_hint(got: float, expected: float) -> str:
    ratio = got / expected
    power = round(np.log10(ratio))
    return f" (it seems {10.0**power:g} times off)" if abs(power) >= 2 else ""
