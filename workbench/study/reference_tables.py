"""[references.NAME]: what may stand there, and the signal that it becomes."""

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field, model_validator

from workbench import files
from workbench.errors import UserError, nearest
from workbench.simulation import references as signals
from workbench.study.schema import Hertz, Radian, Raw, Second
from workbench.units import factor, si


class ReferenceTable(files.Strict, ABC):
    """A reference; `unit` is that of its value: m, or that of the input that it is fed to."""

    kind: str

    @abstractmethod
    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        """The signal, with values in SI; a recorded one from a file in `folder`."""


class SineTable(ReferenceTable):
    amplitude: Raw
    frequency: Hertz = Field(gt=0.0)
    offset: Raw = 0.0
    phase: Radian = 0.0

    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        return signals.Sine(si(self.amplitude, unit), self.frequency, si(self.offset, unit), self.phase)


class StepsTable(ReferenceTable):
    levels: list[Raw] = Field(min_length=1)
    dwell: Second = Field(gt=0.0)
    start: Second = Field(0.0, ge=0.0)

    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        return signals.Steps(tuple(si(level, unit) for level in self.levels), self.dwell, self.start)


class RampTable(ReferenceTable):
    rate: Raw
    start: Second = Field(0.0, ge=0.0)
    stop: Second = np.inf

    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        return signals.Ramp(si(self.rate, f"{unit}/s"), self.start, self.stop)


class TriangleTable(ReferenceTable):
    amplitude: Raw
    frequency: Hertz | None = Field(None, gt=0.0)
    speed: Raw | None = None
    offset: Raw = 0.0

    @model_validator(mode="after")
    def _one_of(self) -> "TriangleTable":
        if (self.frequency is None) == (self.speed is None):
            raise ValueError("expected either frequency or speed")
        return self

    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        amplitude = si(self.amplitude, unit)
        frequency = self.frequency or si(self.speed, f"{unit}/s") / (4.0 * amplitude)
        return signals.Triangle(amplitude, frequency, si(self.offset, unit))


class MultisineTable(ReferenceTable):
    amplitude: Raw
    frequency: Hertz = Field(gt=0.0)
    harmonics: list[Annotated[int, Field(ge=1)]] = Field(min_length=1)

    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        return signals.Multisine(si(self.amplitude, unit), self.frequency, tuple(self.harmonics))


class ChirpTable(ReferenceTable):
    amplitude: Raw
    start_frequency: Hertz = Field(gt=0.0)
    end_frequency: Hertz = Field(gt=0.0)
    sweep: Second = Field(gt=0.0)

    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        return signals.Chirp(si(self.amplitude, unit), self.start_frequency, self.end_frequency, self.sweep)


class RecordedTable(ReferenceTable):
    file: str
    time: str
    value: str
    time_unit: str = "s"
    unit: str | None = None

    def build(self, unit: str, folder: Path) -> signals.ReferenceSignal:
        path = folder / self.file
        try:
            table = pd.read_csv(path, sep=None, engine="python")
        except FileNotFoundError:
            raise UserError(f"{path}: no such file") from None
        except (OSError, ValueError) as error:
            raise UserError(f"{path}: cannot be read as a table with a header ({error})") from None
        for column in (self.time, self.value):
            if column not in table:
                raise UserError(f'{path}: no column "{column}"; {nearest(column, map(str, table.columns))}')
        numbers = [pd.to_numeric(table[column], errors="coerce").to_numpy() for column in (self.time, self.value)]
        times, values = numbers[0] * factor(self.time_unit, "s"), numbers[1] * factor(self.unit or unit, unit)
        if not (np.all(np.isfinite(times)) and np.all(np.isfinite(values))):
            raise UserError(f"{path}: row {int(np.argmin(np.isfinite(times + values))) + 2} holds no finite number")
        if times.size < 4 or np.any(np.diff(times) <= 0.0):
            raise UserError(f"{path}: expected at least 4 rows with time rising from row to row")
        return signals.Recorded(times, values)


KINDS: dict[str, type[ReferenceTable]] = {
    "sine": SineTable,
    "steps": StepsTable,
    "ramp": RampTable,
    "triangle": TriangleTable,
    "multisine": MultisineTable,
    "chirp": ChirpTable,
    "recorded": RecordedTable,
}
"""The references by the name of their kind."""
