"""The columns of logs as numbers: what can be told of each by its values alone."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.ndimage import uniform_filter1d

from workbench.errors import UserError, visible
from workbench.records.formats.interface import UNITS
from workbench.records.sampling.sight import window_points
from workbench.records.spelled import unit_named, without_unit
from workbench.records.tables import LARGEST, numbers_of, read_table, seconds

LINE = 0.99
"""Correlation below which no column is another one in other units."""

COARSE, DIGITS = 0.05, 1e-4
"""Shares of a column's deviation: steps up to which it is told from another one, and what rounding leaves of it."""

FEWEST = 50
"""Rows of numbers that a column has, at least."""


@dataclass(frozen=True, eq=False)
class Column:
    """A column: as an experiment names it, its name without a unit, the unit ("" without one), the numbers."""

    key: str | int
    name: str
    unit: str
    values: np.ndarray

    @cached_property
    def known(self) -> np.ndarray:
        """Its numbers without gaps, by lines."""
        finite = np.isfinite(self.values)
        places = np.arange(self.values.size)
        return np.interp(places, places[finite], self.values[finite])

    @property
    def low(self) -> float:
        """The smallest number."""
        return float(np.nanmin(self.values))

    @property
    def high(self) -> float:
        """The largest number."""
        return float(np.nanmax(self.values))

    @property
    def size(self) -> float:
        """The largest absolute number."""
        return max(abs(self.low), abs(self.high))

    @cached_property
    def whole(self) -> bool:
        """Whether all are whole numbers: counts, or rpm."""
        known = self.values[np.isfinite(self.values)]
        return bool(np.all(known == np.rint(known)))

    @cached_property
    def resolution(self) -> float:
        """The least step between its numbers."""
        return float(np.min(np.diff(np.unique(self.values[np.isfinite(self.values)]))))

    @property
    def is_clock(self) -> bool:
        """Whether the numbers go on nearly all the time."""
        steps = np.diff(self.known)
        return bool(np.mean(steps > 0.0) > 0.8 and self.known[-1] > self.known[0])

    @property
    def said(self) -> str:
        """Its range in words."""
        return f"{self.low:.4g} to {self.high:.4g}" + (f" {self.unit}" if self.unit else "")


def columns_of(path: Path) -> list[Column]:
    """The columns of a log that hold numbers which change, or dates.

    Raises:
        UserError: it cannot be read, or has no two of them.
    """
    table = read_table(path)
    units = table.attrs.get(UNITS, {})
    found = []
    for place in range(table.shape[1]):
        header, column = table.columns[place], table.iloc[:, place]
        values = numbers_of(column)
        dated = column.dtype.kind in "mM" or (not np.isfinite(values).any() and column.dtype.kind == "O")
        values = seconds(column) if dated else values
        values = np.where(np.abs(values) <= LARGEST, values, np.nan)
        if np.sum(np.isfinite(values)) < FEWEST or np.nanmin(values) == np.nanmax(values):
            continue
        name, unit = without_unit(header) if isinstance(header, str) else (str(header), "")
        own = unit_named(units.get(str(header).strip(), ""))
        key = header.strip() if isinstance(header, str) and visible(header) == header else int(place)
        found.append(Column(key, name, "s" if dated else own or unit, values))
    if len(found) < 2:
        raise UserError(f"{path}: no two columns of numbers that change, of at least {FEWEST} rows: nothing to import")
    return found


def time_of(columns: Sequence[Column], scored: Sequence[Column], path: Path) -> Column:
    """The column of the time: one that is called so and goes on, else the first that does.

    Raises:
        UserError: there is none.
    """
    for one in [*scored, *columns]:
        if one.is_clock:
            return one
    raise UserError(f"{path}: no column goes on as a time does; add one, or write the experiment by hand")


def time_unit(column: Column) -> tuple[str, str]:
    """The unit of a time, and why."""
    if column.unit in ("s", "ms", "us", "ns", "min"):
        return column.unit, f"as the file says; {_paced(column, column.unit)}"
    step = float(np.median(np.diff(column.known)))
    for unit, least in (("ns", 3e5), ("us", 999.0), ("ms", 0.5)):
        if step >= least:
            return unit, f"steps of {step:.4g}: {_paced(column, unit)}"
    return "s", f"steps of {step:.3g}: {_paced(column, 's')}"


SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}


def _paced(column: Column, unit: str) -> str:
    step = float(np.median(np.diff(column.known))) * SECONDS[unit]
    whole = (column.high - column.low) * SECONDS[unit]
    return f"{1.0 / step:.4g} Hz for {whole:.4g} s" if step > 0.0 else f"{whole:.4g} s"


def without_copies(
    columns: Sequence[Column], is_other: Callable[[Column, Column], bool]
) -> tuple[list[Column], dict[str, Column]]:
    """Columns without those that are another one in other units, and of each such one the one that stays: the last, as
    what is calibrated stands behind what is raw. `is_other` says of two that they are not the same by their names.
    """
    kept, copies = list[Column](), dict[str, Column]()
    for place, one in enumerate(columns):
        behind = [other for other in columns[place + 1 :] if not is_other(one, other)]
        later = next((other for other in behind if _is_copy(one, other)), None)
        if later is None:
            kept.append(one)
        else:
            copies[str(one.key)] = later
    return kept, copies


def _is_copy(first: Column, second: Column) -> bool:
    """Whether two columns are on one line, to the steps in which they count."""
    if abs(correlation(first.known, second.known)) < LINE:
        return False
    slope = float(np.std(second.known) / np.std(first.known))
    fit = np.polyval(np.polyfit(first.known, second.known, 1), first.known)
    size = float(np.std(second.known))
    step = min(slope * first.resolution + second.resolution, COARSE * size)
    return float(np.std(second.known - fit)) <= max(step, DIGITS * size)


def correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Of two columns; 0 where one does not change."""
    if not np.std(first) or not np.std(second):
        return 0.0
    return float(np.corrcoef(first, second)[0, 1])


def step_of(time: Column, scale: float) -> float:
    """The time between two rows (s), of a clock whose unit has so many seconds; its median, 0 where it stands."""
    steps = np.diff(time.known) * scale
    forward = steps[steps > 0.0]
    return float(np.median(forward)) if forward.size else 0.0


class Motion:
    """Columns smoothed alike, and slopes, over the rows of a log: a clock's jitter hardly counts there."""

    def __init__(self, time: Column, scale: float) -> None:
        self.step = step_of(time, scale)
        self.points = window_points(self.step)

    def smooth(self, column: Column) -> np.ndarray:
        """A column's means over a window."""
        return np.asarray(uniform_filter1d(column.known, self.points))

    def slope(self, column: Column) -> np.ndarray:
        """Its rate (unit/s)."""
        return np.asarray(np.gradient(self.smooth(column), self.step))

    def way(self, column: Column) -> np.ndarray:
        """The direction in which a position moves: 1, -1, and 0 where it hardly does."""
        slope = self.slope(column)
        fast = 0.1 * float(np.percentile(np.abs(slope), 98.0))
        return np.where(np.abs(slope) > fast, np.sign(slope), 0.0)

    def roughness(self, column: Column) -> float:
        """How much of a column is gone when it is smoothed: next to nothing of a position."""
        spread = float(np.std(column.known))
        return float(np.std(column.known - self.smooth(column))) / spread if spread > 0.0 else 0.0


def rounded_up(value: float) -> float:
    """The next of 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten; 1 of nothing, or of what has no measure."""
    if not 1e-300 < value < 1e300:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    nice = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
    return power * next(step for step in nice if step * power >= value * (1.0 - 1e-9))
