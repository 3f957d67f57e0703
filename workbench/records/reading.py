"""Measured records: read from files, put on an even grid, and judged before anything is made of them.

What is wrong with a whole record is an error of one line. A short gap is kept as a gap: NaN in the channels and
False in `valid`; nobody fills it. At a long one a record is cut into pieces, each a record of its own.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd

from workbench.errors import UserError, nearest
from workbench.records.agreement import agreement_notes
from workbench.records.checks import alive_notes, check_directions, check_pace, check_ranges
from workbench.records.experiment import Experiment, RecordSpec
from workbench.records.sampling.clock import stamps_of
from workbench.records.sampling.pieces import Piece, Series, pieces_of
from workbench.records.sampling.sight import sight_note
from workbench.records.tables import numbers_of, read_column, read_table


@dataclass(frozen=True, eq=False)
class Record:
    """A record, or a piece of one, in SI on an even grid from time 0; NaN where nothing was measured.

    `valid` is True where every channel has a value; `notes` say in words what was left out. `piece` is the number of a
    piece, from 1, and 0 of a record that is whole; `start` (s) is where it begins in its record, and `log` the number
    of that in its experiment, which the pieces have in common.
    """

    label: str
    path: Path
    use: str
    rpm: float
    time: np.ndarray
    channels: Mapping[str, np.ndarray]
    valid: np.ndarray
    notes: tuple[str, ...] = ()
    piece: int = 0
    start: float = 0.0
    log: int = 0

    @property
    def sample_time(self) -> float:
        """Time between samples (s)."""
        return float(self.time[1] - self.time[0])

    @property
    def name(self) -> str:
        """The label, and which piece of the record this is."""
        return f"{self.label}, piece {self.piece} from {self.start:.3g} s" if self.piece else self.label


def by_log(records: Iterable[Record]) -> list[list[Record]]:
    """The pieces of each record together."""
    logs: dict[tuple[int, Path], list[Record]] = {}
    for record in records:
        logs.setdefault((record.log, record.path), []).append(record)
    return list(logs.values())


def read_records(experiment: Experiment, use: str | None = "fit") -> list[Record]:
    """The records of an experiment that are for that `use` (None: all), in the order of the file, each in its pieces.

    Raises:
        UserError: a record that cannot be used, and why.
    """
    specs = [spec for spec in experiment.records if use in (None, spec.use)]
    records = [piece for spec in specs for piece in read_pieces(spec, experiment)]
    check_differ(records)
    return records


def check_differ(records: Sequence[Record]) -> None:
    """No record is another one under another name: held out it would test nothing, and fitted it would count twice.

    Raises:
        UserError: one is.
    """
    for record, other in combinations(records, 2):
        alike = record.path != other.path and record.time.size == other.time.size
        if alike and all(
            np.array_equal(values, other.channels[name], equal_nan=True) for name, values in record.channels.items()
        ):
            raise UserError(
                f"{other.path}: holds the same samples as {record.path}; expected another motion, or one of both alone"
            )


def read_pieces(spec: RecordSpec, experiment: Experiment) -> list[Record]:
    """One record, read, converted, cut at its gaps and validated: its pieces, or the whole of it.

    What was done to the record is in the notes of its first piece.

    Raises:
        UserError: unreadable, a missing column, or numbers that cannot be what they are called.
    """
    places = {name: spec.places.get(name, spec.path) for name in experiment.channels if name != "time"}
    tables = {path: _rows(spec, read_table(path)) for path in dict.fromkeys(places.values())}
    series = [
        _series(path, table, [name for name, place in places.items() if place == path], experiment)
        for path, table in tables.items()
    ]
    pieces, notes = pieces_of(spec.path, series, spec.sample_time)
    step = pieces[0].step
    notes += [sight_note(step)] * bool(sight_note(step))
    notes += [channel.doubt for channel in experiment.channels.values() if channel.doubt]
    notes += agreement_notes([piece.channels for piece in pieces], step)
    together = _together(pieces)
    for name, values in together.items():
        notes += alive_notes(spec.path, name, values, step)
    check_ranges(spec.path, together, experiment)
    check_directions(spec.path, [piece.channels for piece in pieces], step)
    check_pace(spec.path, [piece.channels for piece in pieces], step, experiment)
    rpm, log = _rpm(spec, tables[spec.path]), experiment.records.index(spec)
    records = []
    for number, piece in enumerate(pieces, 1):
        records.append(
            Record(
                spec.label,
                spec.path,
                spec.use,
                rpm,
                step * np.arange(piece.size),
                piece.channels,
                piece.valid,
                tuple(notes) if number == 1 else (),
                piece=number if len(pieces) > 1 else 0,
                start=piece.start,
                log=log,
            )
        )
    return records


def _rows(spec: RecordSpec, table: pd.DataFrame) -> pd.DataFrame:
    """The rows of a table that are taken.

    Raises:
        UserError: none is left.
    """
    if spec.skip >= len(table) > 0:
        raise UserError(f"{spec.path}: skip = {spec.skip} leaves none of its {len(table)} rows; expected fewer")
    return table.iloc[spec.skip : None if spec.rows is None else spec.skip + spec.rows]


def _series(path: Path, table: pd.DataFrame, names: Sequence[str], experiment: Experiment) -> Series:
    """The channels of one file with its clock, in SI."""
    stamps = stamps_of(path, read_column(path, table, "time", experiment.channels["time"]))
    columns = {name: read_column(path, table, name, experiment.channels[name]) for name in names}
    return Series(stamps, {name: values[stamps.rows] for name, values in columns.items()})


def _together(pieces: Sequence[Piece]) -> dict[str, np.ndarray]:
    """Channels of all pieces, one after the other."""
    return {name: np.concatenate([piece.channels[name] for piece in pieces]) for name in pieces[0].channels}


def _rpm(spec: RecordSpec, table: pd.DataFrame) -> float:
    """The speed of rotation (rpm) of a record: as the experiment says, or the one value of the column it names."""
    if not isinstance(spec.rpm, str):
        return spec.rpm
    if spec.rpm not in table:
        raise UserError(f'{spec.path}: no column "{spec.rpm}" for rpm; {nearest(spec.rpm, map(str, table.columns))}')
    values = np.unique(numbers_of(table[spec.rpm]))
    if values.size != 1 or not 0.0 <= values[0] < np.inf:
        raise UserError(f'{spec.path}: column "{spec.rpm}" holds no one speed of rotation; give rpm as a number')
    return float(values[0])
