"""[references.NAME]: what may stand there, and the signal that it becomes."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from plants.plugins import Registry, reason_of
from workbench.errors import UserError, nearest, shortened, spelled
from workbench.simulation import references as signals
from workbench.toml import reading as files
from workbench.toml.quantities import Hertz, Radian, Raw, Second
from workbench.toml.units import QuantityError, factor, si

if TYPE_CHECKING:
    import pandas as pd

MOST_HARMONICS = 1000
"""Of a multisine: its scale is found on 200 points of the fastest one's period, over the whole of the slowest's."""


class ReferenceTable(files.Strict, ABC):
    """A reference; `unit` is that of its value: m or rad, or that of the input that it is fed to."""

    kind: str

    @abstractmethod
    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        """The signal, with values in SI; a recorded one from a file in `folder`.

        Raises:
            SchemaError: a setting of the wrong unit, or one that makes no such signal.
            UserError: a record that cannot be used.
        """


def quantity(table: ReferenceTable, name: str, unit: str) -> float:
    """A setting in SI."""
    return _converted(getattr(table, name), unit, (name,))


def _converted(value: float | str, unit: str, key: files.Key) -> float:
    try:
        return si(value, unit)
    except QuantityError as error:
        raise files.SchemaError(key, str(error)) from None


class SineTable(ReferenceTable):
    amplitude: Raw
    """Half of peak to peak."""
    frequency: Hertz = Field(gt=0.0)
    """Of the sine."""
    offset: Raw = 0.0
    """Added to it."""
    phase: Radian = 0.0
    """At t = 0."""

    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        amplitude, offset = quantity(self, "amplitude", unit), quantity(self, "offset", unit)
        return signals.Sine(amplitude, self.frequency, offset, self.phase)


class StepsTable(ReferenceTable):
    levels: list[Raw] = Field(min_length=1)
    """One after the other."""
    dwell: Second = Field(gt=0.0)
    """At each level."""
    start: Second = Field(0.0, ge=0.0)
    """Of the first; 0 before it."""

    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        levels = tuple(_converted(level, unit, ("levels", i)) for i, level in enumerate(self.levels))
        return signals.Steps(levels, self.dwell, self.start)


class RampTable(ReferenceTable):
    rate: Raw
    """Of the ramp."""
    start: Second = Field(0.0, ge=0.0)
    """Of the motion."""
    stop: Second = np.inf
    """Of the motion; it rests then."""

    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        return signals.Ramp(quantity(self, "rate", f"{unit}/s"), self.start, self.stop)


class TriangleTable(ReferenceTable):
    amplitude: Raw
    """Half of peak to peak."""
    frequency: Hertz | None = Field(None, gt=0.0)
    """Either this"""
    speed: Raw | None = None
    """or this, of its sides."""
    offset: Raw = 0.0
    """Added to it."""

    @model_validator(mode="after")
    def _one_of(self) -> "TriangleTable":
        if (self.frequency is None) == (self.speed is None):
            raise ValueError("expected either frequency or speed")
        return self

    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        amplitude, offset = quantity(self, "amplitude", unit), quantity(self, "offset", unit)
        if self.frequency is not None:
            return signals.Triangle(amplitude, self.frequency, offset)
        speed = quantity(self, "speed", f"{unit}/s")
        for name, number in (("amplitude", amplitude), ("speed", speed)):
            if number <= 0.0:
                raise files.SchemaError((name,), f"got {spelled(getattr(self, name))}, expected a value above 0")
        return signals.Triangle(amplitude, speed / (4.0 * amplitude), offset)


class MultisineTable(ReferenceTable):
    amplitude: Raw
    """The peak of the sum."""
    frequency: Hertz = Field(gt=0.0)
    """Of the fundamental."""
    harmonics: list[Annotated[int, Field(ge=1, le=MOST_HARMONICS)]] = Field(min_length=1, max_length=MOST_HARMONICS)
    """Whole numbers, of equal amplitude."""

    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        return signals.Multisine(quantity(self, "amplitude", unit), self.frequency, tuple(self.harmonics))


class ChirpTable(ReferenceTable):
    amplitude: Raw
    """Half of peak to peak."""
    start_frequency: Hertz = Field(gt=0.0)
    """At t = 0."""
    end_frequency: Hertz = Field(gt=0.0)
    """At the end of the sweep."""
    sweep: Second = Field(gt=0.0)
    """Time that it takes."""

    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        amplitude = quantity(self, "amplitude", unit)
        return signals.Chirp(amplitude, self.start_frequency, self.end_frequency, self.sweep)


class RecordedTable(ReferenceTable):
    file: str
    """A table with a header, relative to the study."""
    time: str
    """The column of the time."""
    value: str
    """The column of the values."""
    time_unit: str = "s"
    """Of that column."""
    unit: str | None = None
    """Of the values; by default SI."""

    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        import pandas as pd  # slow to import, and no other reference needs it

        path = folder / self.file
        files.check_regular(path)
        try:
            table = pd.read_csv(path, sep=None, engine="python")
        except FileNotFoundError:
            raise UserError(f"{path}: no such file") from None
        except Exception as error:  # noqa: BLE001 - of a damaged file the libraries raise anything
            raise UserError(f"{path}: cannot be read as a table with a header ({reason_of(error)})") from None
        for column in (self.time, self.value):
            if column not in table:
                raise UserError(f'{path}: no column "{column}"; {nearest(column, map(str, table.columns))}')
        numbers = [_numbers(path, table[column]) for column in (self.time, self.value)]
        times, values = numbers[0] * _factor("time_unit", self.time_unit, "s"), numbers[1]
        if self.unit is not None:
            values = values * _factor("unit", self.unit, unit)
        if times.size < 4:
            raise UserError(f"{path}: holds {times.size} rows, expected at least 4")
        if np.any(np.diff(times) <= 0.0):
            row = int(np.argmax(np.diff(times) <= 0.0)) + 3
            raise UserError(f"{path}: row {row}: expected a time after that of the row before")
        return signals.Recorded(times, values)


def _numbers(path: Path, column: "pd.Series[Any]") -> np.ndarray:
    """The numbers of a column.

    Raises:
        UserError: one is none, or not finite; and in which row.
    """
    from workbench.records.tables import numbers_of  # a study without records waits for no pandas

    numbers = numbers_of(column)
    finite = np.isfinite(numbers)
    if not finite.all():
        row = int(np.argmin(finite))
        got = shortened(str(column.iloc[row]))
        raise UserError(
            f'{path}: row {row + 2} holds no finite number in column "{column.name}": got "{got}"; '
            "numbers have a point, and columns are parted by commas, semicolons or tabs"
        )
    return numbers


def _factor(name: str, given: str, unit: str) -> float:
    try:
        return factor(given, unit)
    except QuantityError:
        raise files.SchemaError((name,), f'got "{given}", expected a unit such as "{unit}"') from None


@dataclass(frozen=True)
class Kind:
    """A kind of reference: the `name` that [references.NAME] gives as its kind, and what may stand in the table."""

    name: str
    table: type[ReferenceTable]


def _check(kind: Kind) -> None:
    if not issubclass(kind.table, ReferenceTable):
        raise TypeError(f"{kind.table.__name__}: expected a ReferenceTable")


_OURS = (
    Kind("sine", SineTable),
    Kind("steps", StepsTable),
    Kind("ramp", RampTable),
    Kind("triangle", TriangleTable),
    Kind("multisine", MultisineTable),
    Kind("chirp", ChirpTable),
    Kind("recorded", RecordedTable),
)

REFERENCES = Registry("friction_workbench.references", Kind, {kind.name: kind for kind in _OURS}, _check)
"""The references by the name of their kind: ours, and those that other packages bring by entry point."""
