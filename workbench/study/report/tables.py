"""Thesis-style tables: ours beside each published value and the difference, as CSV, Markdown and LaTeX."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

import pandas as pd

from workbench.errors import UserError
from workbench.publish.tables import (
    REMARK,
    Table,
    shown_number,
    with_unit,
    write_frame,
)
from workbench.study.names import matches, shown_factor, unit_of_column
from workbench.study.report.schema import Column, Row, TableSpec
from workbench.study.report.select import axes_of, one_row, rows
from workbench.study.report.table_layout import Heading, LayoutError, lay_out
from workbench.study.report.unusual import SOLVER_ERRORS, unusual

OURS, DIFFERENCE, PERCENT = "this program", "difference", "difference (%)"

PLACES = "In brackets the place in the column."

ResultRow: TypeAlias = Mapping[str, float | str | None]
"""A row of the results, by column."""


def make_table(spec: TableSpec, frame: pd.DataFrame) -> pd.DataFrame:
    """The table of a spec, as text ready to be shown. A figure that does not apply is empty.

    Raises:
        UserError: a row asks for a case that does not exist, or a place of the table for two cases.
    """
    return _of_rows(spec, frame) if spec.rows else _over_axis(spec, frame)


def _shown(row: ResultRow, figure: Column | Row) -> tuple[str, float | None]:
    """A figure of a case as text in the unit shown, and as a number in it if it is one."""
    value = row[figure.result]
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "", None
    if isinstance(value, str):
        return value, None
    number = float(value) * shown_factor(unit_of_column(figure.result), figure.unit)
    floor = _floor(row, figure)
    return (f"< {shown_number(floor, 1)}" if abs(number) < floor else shown_number(number, figure.digits)), number


def _floor(row: ResultRow, figure: Column | Row) -> float:
    """The magnitude, in the unit shown, below which a figure of a case says nothing."""
    own = next((name for name in SOLVER_ERRORS if figure.result.endswith(name.removeprefix("solver"))), None)
    solver_error = None if own is None else row.get(own)
    if figure.result == own or isinstance(solver_error, str | None) or math.isnan(solver_error):
        return figure.least
    return max(figure.least, float(solver_error) * shown_factor(unit_of_column(figure.result), figure.unit))


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


def _over_axis(spec: TableSpec, frame: pd.DataFrame) -> pd.DataFrame:
    for column in spec.columns:
        rows(frame.head(0), {**spec.where, **column.where})  # names that the results lack are told
    own = rows(frame, spec.where)
    records = [{str(name): value for name, value in row.items()} for row in own.to_dict("records")]
    axes = axes_of(frame.columns)
    try:
        layout = lay_out(spec, records, axes)
    except LayoutError as error:
        raise UserError(f"table {spec.name}: {error}") from None
    several = sum(bool(column.published or column.against) for column in spec.columns) > 1
    headed = {spec.index: spec.index_label or str(spec.index)}
    table = pd.DataFrame(
        [{headed.get(name, name): _label(value) for name, value in line.values.items()} for line in layout.lines]
    )
    for number, heading in enumerate(layout.headings):
        places = [line.cases[number] for line in layout.lines]
        cases = [None if place is None else records[place] for place in places]
        found = _cells(spec, heading, cases, [line.values[str(spec.index)] for line in layout.lines], several)
        table = pd.concat([table, pd.DataFrame(found)], axis=1)
    return table


def _unit(figure: Column | Row) -> str:
    """The unit in which a figure is shown: as it is stored, in SI, unless it says so."""
    return unit_of_column(figure.result) if figure.unit == "1" else figure.unit


def _cells(
    spec: TableSpec,
    heading: Heading,
    cases: Sequence[ResultRow | None],
    values: Sequence[object],
    several: bool,
) -> list[dict[str, str]]:
    """What stands under a heading, line by line: a figure with its place, or beside its published value."""
    column = heading.column
    shown = [("", None) if case is None else _shown(case, column) for case in cases]
    label = column.label if heading.across is None else f"{column.label}, {_label(heading.across)}"
    title = with_unit(label, _unit(column))
    if heading.across is not None and spec.places is not False:
        return [{title: text} for text in _placed(column, shown, cases)]
    by_reference: dict[str, dict[str, float]] = {spec.compared_with: column.published} if column.published else {}
    by_reference |= {name: column.against[name] for name in spec.references if name in column.against}
    if not by_reference:
        return [{title: text} for text, _ in shown]
    found = []
    for (text, number), value in zip(shown, values, strict=True):
        references = {name: _at(known, value) for name, known in by_reference.items()}
        beside = _beside(number, references, column.digits, column.label if several else "")
        found.append({f"{title}, {OURS}": text} | beside)
    return found


def _placed(column: Column, shown: Sequence[tuple[str, float | None]], cases: Sequence[ResultRow | None]) -> list[str]:
    """Figures with their places: the smallest in magnitude first, a power by its value; what says nothing is 0."""
    sizes = [
        None if number is None or case is None else _size(column, number, _floor(case, column))
        for (_, number), case in zip(shown, cases, strict=True)
    ]
    places = pd.Series(sizes, dtype=float).rank(method="min")
    texts = [text for text, _ in shown]
    return [text if math.isnan(place) else f"{text} ({place:.0f})" for text, place in zip(texts, places, strict=True)]


def _size(column: Column, number: float, floor: float) -> float:
    """By what a figure is ordered."""
    if abs(number) < floor:
        return 0.0
    return number if unit_of_column(column.result) == "W" else abs(number)


def _at(known: Mapping[str, float], value: object) -> float | None:
    """A reference's figure at this value of the axis."""
    return next((number for key, number in known.items() if matches({"": value}, {"": key})), None)


def _label(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _of_rows(spec: TableSpec, frame: pd.DataFrame) -> pd.DataFrame:
    lines = [_single(spec, row, frame) for row in spec.rows]
    table = pd.DataFrame(lines)
    return table.drop(columns=[name for name in table.columns if not table[name].any()])


def _single(spec: TableSpec, row: Row, frame: pd.DataFrame) -> dict[str, str]:
    found = one_row(frame, {**spec.where, **row.where}, f'table {spec.name}, row "{row.label}"')
    text, number = _shown({str(name): value for name, value in found.items()}, row)
    published: dict[str, float | None] = (
        {spec.compared_with: row.published} if any(each.published is not None for each in spec.rows) else {}
    )
    references = published | {name: row.against.get(name) for name in spec.references}
    return {
        "quantity": row.label,
        "unit": "" if (unit := _unit(row)) == "1" else unit,
        OURS: text,
        **_beside(number, references, row.digits),
        REMARK: row.remark,
    }


def write_table(spec: TableSpec, frame: pd.DataFrame, folder: Path) -> list[Path]:
    """Write a table as NAME.csv, NAME.md and NAME.tex; returns the paths."""
    own: dict[str, str] = {spec.compared_with: spec.source} if spec.source else {}
    return write_frame(
        spec.name, Table(spec.title, make_table(spec, frame), _notes(spec, frame), {**own, **spec.references}), folder
    )


def _notes(spec: TableSpec, frame: pd.DataFrame) -> list[str]:
    has_places = spec.across is not None and spec.places is not False
    conditions = [*(column.where for column in spec.columns), *(row.where for row in spec.rows)]
    shown = pd.concat([rows(frame, {**spec.where, **where}) for where in conditions])
    lines = [f"{line}." for line in unusual(shown[~shown.index.duplicated()], frame)]
    return [text for text in (PLACES if has_places else "", spec.note, *lines) if text]
