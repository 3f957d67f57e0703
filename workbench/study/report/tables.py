"""Thesis-style tables: ours beside each published value and the difference, as CSV, Markdown and LaTeX."""

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pandas as pd

from workbench.errors import UserError
from workbench.publish.tables import (
    REMARK,
    Table,
    shown_number,
    with_unit,
    write_frame,
)
from workbench.publish.words import listed
from workbench.study.names import matches, shown_factor, unit_of_column
from workbench.study.report.schema import SHARES, Column, Row, TableSpec
from workbench.study.report.select import OUTCOME, alike, axes_of, which
from workbench.study.report.summary import count_of, counted, in_words, summary_unit, taken
from workbench.study.report.table_layout import Heading, lay_out
from workbench.study.report.unusual import SOLVER_ERRORS, unusual

OURS, DIFFERENCE, PERCENT = "this program", "difference", "difference (%)"

PLACES = "In brackets the place in the column."
BRACKETS = "In square brackets how many of the cases have the figure; the others are left out of it."
NO_CASE = "No case has what this table shows."

Values: TypeAlias = Mapping[str, Sequence[Any]]
"""Columns of the results by name, a value for each case: a number or words, NaN or None without."""


def make_table(spec: TableSpec, frame: pd.DataFrame) -> pd.DataFrame:
    """The table of a spec, as text ready to be shown. A figure that does not apply is empty.

    Raises:
        UserError: a row asks for a case that does not exist, or a place of the table for two cases.
    """
    return _made(spec, frame)[0]


def _made(spec: TableSpec, frame: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """A table, and what each of its figures is taken of where they are over several cases."""
    try:
        table, taken_of = _of_rows(spec, frame) if spec.rows else _over_axis(spec, frame)
    except ValueError as error:
        raise UserError(f"table {spec.name}: {error}") from None
    notes = [f"Over {listed(spec.over)}: {'; '.join(taken_of)}."] if taken_of else []
    return table, [*notes, BRACKETS] if taken_of and any("[" in str(cell) for cell in table.to_numpy().flat) else notes


@dataclass(frozen=True)
class Cell:
    """A figure as text in the unit shown, as a number in it if it is one, and of how many of how many cases it is.

    A magnitude below `floor` says nothing.
    """

    text: str = ""
    number: float | None = None
    floor: float = 0.0
    taken_of: tuple[int, int] = (0, 0)


EMPTY = Cell()


def _cell(columns: Values, places: Sequence[int], figure: Column | Row) -> Cell:
    """The figure of the cases at these places: of one, or what is taken of all."""
    values = [columns[figure.result][place] for place in places]
    value, count = taken(values, figure, figure.result), count_of(values, figure)
    if value is None:
        return EMPTY if figure.take is None else Cell(taken_of=count)
    if isinstance(value, str):
        return Cell(value, taken_of=count)
    factor = shown_factor(summary_unit(figure, figure.result), figure.unit)
    number, floor = value * factor, _floor(columns, places, figure, factor)
    text = f"< {shown_number(floor, 1)}" if abs(number) < floor else shown_number(number, figure.digits)
    some = "" if figure.take is None or count[0] == count[1] else f" [{count[0]} of {count[1]}]"
    return Cell(f"{text}{some}", number, floor, count)


def _floor(columns: Values, places: Sequence[int], figure: Column | Row, factor: float) -> float:
    """The magnitude, in the unit shown, below which a figure of these cases says nothing."""
    own = next((name for name in SOLVER_ERRORS if figure.result.endswith(name.removeprefix("solver"))), None)
    if own is None or own not in columns or figure.result == own or figure.take in SHARES:
        return figure.least
    errors = [float(error) for error in (columns[own][place] for place in places) if error is not None]
    return max([figure.least, *(error * factor for error in errors if not math.isnan(error))])


def _values(frame: pd.DataFrame, figures: Iterable[Column | Row], axes: Sequence[str]) -> Values:
    """What tells cases apart, and what a table shows of them, by column."""
    shown = {figure.result for figure in figures}
    names = [name for name in map(str, frame.columns) if name in shown or name in axes or name in SOLVER_ERRORS]
    return {name: frame[name].tolist() for name in names}


def _compared(number: float | None, reference: float | None, digits: int) -> tuple[str, str, str]:
    """A reference's value, how far ours is from it, and by how many percent."""
    if number is None or reference is None:
        return "" if reference is None else f"{reference:g}", "", ""
    difference = number - reference
    percent = f"{100.0 * difference / reference:+.2f}" if reference else ""
    sign = "+" if difference > 0.0 else ""
    shown = sign + shown_number(difference, min(digits, 3))
    return f"{reference:g}", shown, "0.00" if percent in ("+0.00", "-0.00") else percent


def _beside(
    number: float | None, references: Mapping[str, float | None], digits: int, label: str = ""
) -> dict[str, str]:
    """Each reference's value under its name, and the difference from it, which is named where there are several."""
    cells: dict[str, str] = {}
    for name, value in references.items():
        of = f"{name}, " if len(references) > 1 else ""
        headings = (name, f"{of}{DIFFERENCE}", f"{of}{PERCENT}")
        cells |= dict(zip(headings, _compared(number, value, digits), strict=True))
    return {f"{label}, {heading}" if label else heading: cell for heading, cell in cells.items()}


def _over_axis(spec: TableSpec, frame: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    conditions = [{**spec.where, **column.where} for column in spec.columns]
    axes = axes_of(frame.columns)
    asked = np.logical_or.reduce([which(frame, where) for where in conditions])
    columns = _values(frame[asked], spec.columns, [*axes, str(spec.index), *itertools.chain(*conditions)])
    layout = lay_out(spec, columns, axes)
    several = sum(bool(column.published or column.against) for column in spec.columns) > 1
    headed = {spec.index: spec.index_label or str(spec.index)}
    table = pd.DataFrame(
        [{headed.get(name, name): _label(value) for name, value in line.values.items()} for line in layout.lines]
    )
    if not layout.lines:
        titles = [with_unit(_heading(heading), _unit(heading.column)) for heading in layout.headings]
        return pd.DataFrame(columns=[*headed.values(), *titles]), []
    taken_of = []
    for number, heading in enumerate(layout.headings):
        cells = [_cell(columns, line.cases[number], heading.column) for line in layout.lines]
        found = _beneath(spec, heading, cells, [line.values[str(spec.index)] for line in layout.lines], several)
        table = pd.concat([table, pd.DataFrame(found)], axis=1)
        if spec.over:
            taken_of.append(_taken_of(heading.column, _heading(heading), cells))
    return table, taken_of


def _taken_of(figure: Column | Row, label: str, cells: Sequence[Cell]) -> str:
    """What a figure is of how many cases, in words."""
    counts = [cell.taken_of for cell in cells if cell.taken_of[1]]
    return f'"{label}" is the {in_words(figure, figure.result)} of {counted(counts)}'


def _unit(figure: Column | Row) -> str:
    """The unit in which a figure is shown: as it is stored, in SI, unless it says so."""
    return summary_unit(figure, figure.result) if figure.unit == "1" else figure.unit


def _heading(heading: Heading) -> str:
    column = heading.column
    return column.label if heading.across is None else f"{column.label}, {_label(heading.across)}"


def _beneath(
    spec: TableSpec, heading: Heading, cells: Sequence[Cell], values: Sequence[object], several: bool
) -> list[dict[str, str]]:
    """What stands under a heading, line by line: a figure with its place, or beside its published value."""
    column = heading.column
    title = with_unit(_heading(heading), _unit(column))
    if heading.across is not None and spec.places is not False:
        return [{title: text} for text in _placed(column, cells)]
    by_reference: dict[str, dict[str, float]] = {spec.compared_with: column.published} if column.published else {}
    by_reference |= {name: column.against[name] for name in spec.references if name in column.against}
    if not by_reference:
        return [{title: cell.text} for cell in cells]
    found = []
    for cell, value in zip(cells, values, strict=True):
        references = {name: _at(known, value) for name, known in by_reference.items()}
        beside = _beside(cell.number, references, column.digits, column.label if several else "")
        found.append({f"{title}, {OURS}": cell.text} | beside)
    return found


def _placed(column: Column, cells: Sequence[Cell]) -> list[str]:
    """Figures with their places: the smallest in magnitude first, a power by its value; what says nothing is 0."""
    places = pd.Series([_size(column, cell) for cell in cells], dtype=float).rank(method="min")
    return [
        cell.text if math.isnan(place) else f"{cell.text} ({place:.0f})"
        for cell, place in zip(cells, places, strict=True)
    ]


def _size(column: Column, cell: Cell) -> float | None:
    """By what a figure is ordered."""
    if cell.number is None or abs(cell.number) >= cell.floor:
        signed = cell.number is None or unit_of_column(column.result) == "W"
        return cell.number if signed else abs(cell.number or 0.0)
    return 0.0


def _at(known: Mapping[str, float], value: object) -> float | None:
    """A reference's figure at this value of the axis."""
    return next((number for key, number in known.items() if matches({"": value}, {"": key})), None)


def _label(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _of_rows(spec: TableSpec, frame: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    lines, taken_of = [], []
    for row in spec.rows:
        cell = _of_row(spec, row, frame)
        lines.append(_line(spec, row, cell))
        if spec.over:
            taken_of.append(_taken_of(row, row.label, [cell]))
    table = pd.DataFrame(lines)
    return table.drop(columns=[name for name in table.columns if not table[name].any()]), taken_of


def _of_row(spec: TableSpec, row: Row, frame: pd.DataFrame) -> Cell:
    found = alike(frame, {**spec.where, **row.where}, spec.over, f'table {spec.name}, row "{row.label}"')
    return _cell(_values(found, [row], ()), range(len(found)), row)


def _line(spec: TableSpec, row: Row, cell: Cell) -> dict[str, str]:
    published: dict[str, float | None] = (
        {spec.compared_with: row.published} if any(each.published is not None for each in spec.rows) else {}
    )
    references = published | {name: row.against.get(name) for name in spec.references}
    return {
        "quantity": row.label,
        "unit": "" if (unit := _unit(row)) == "1" else unit,
        OURS: cell.text,
        **_beside(cell.number, references, row.digits),
        REMARK: row.remark,
    }


def write_table(spec: TableSpec, frame: pd.DataFrame, folder: Path) -> list[Path]:
    """Write a table as NAME.csv, NAME.md and NAME.tex; returns the paths."""
    own: dict[str, str] = {spec.compared_with: spec.source} if spec.source else {}
    table, taken_of = _made(spec, frame)
    notes = _notes(spec, frame, taken_of)
    return write_frame(spec.name, Table(spec.title, table, notes, {**own, **spec.references}), folder)


def _notes(spec: TableSpec, frame: pd.DataFrame, taken_of: Sequence[str]) -> list[str]:
    has_places = spec.across is not None and spec.places is not False
    conditions = [*(column.where for column in spec.columns), *(row.where for row in spec.rows)]
    shown = np.logical_or.reduce([which(frame, {**spec.where, **where}) for where in conditions])
    told = [name for name in frame.columns if name in (*axes_of(frame.columns), OUTCOME, *SOLVER_ERRORS)]
    lines = [f"{line}." for line in unusual(frame.loc[shown, told], frame)]
    empty = "" if shown.any() else NO_CASE
    return [text for text in (PLACES if has_places else "", spec.note, empty, *taken_of, *lines) if text]
