"""Thesis-style tables: ours beside the published value and the difference, as CSV, Markdown and LaTeX (booktabs)."""

import math
from pathlib import Path
from typing import Any

import pandas as pd

from workbench.report.select import one_row, rows
from workbench.study.names import matches, shown_factor, unit_of_column
from workbench.study.report_schema import Column, Row, TableSpec

OURS, DIFFERENCE, PERCENT, REMARK = "this program", "difference", "difference (%)", "remark"

WORDS = (
    "quantity",
    "law",
    "model",
    "account",
    "direction",
    "parameter",
    "candidate",
    "method",
    "breaks",
    "unit",
    REMARK,
)
"""Columns of text, which are aligned to the left."""


def make_table(spec: TableSpec, frame: pd.DataFrame) -> pd.DataFrame:
    """The table of a spec, as text ready to be shown. A figure that does not apply is empty.

    Raises:
        UserError: a row asks for a case that does not exist.
    """
    if spec.rows:
        return _of_rows(spec, frame)
    return _over_axis(spec, frame) if spec.across is None else _side_by_side(spec, frame)


def _shown(value: Any, column: str, unit: str, digits: int) -> tuple[str, float | None]:
    """A result as text in `unit` with `digits` significant digits, and as a number if it is one."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "", None
    if isinstance(value, str):
        return value, None
    number = float(value) * shown_factor(unit_of_column(column), unit)
    return shown_number(number, digits), number


def shown_number(number: float, digits: int) -> str:
    """`number` with `digits` significant digits, in plain notation where that is readable."""
    if number == 0.0 or not 1e-4 <= abs(number) < 1e6:
        return f"{number:.{digits - 1}e}" if number else "0"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(number))))
    return f"{number:.{decimals}f}"


def _compared(number: float | None, published: float | None, digits: int, heading: str) -> dict[str, str]:
    """The published (or reference) value under its heading, and how far ours is from it."""
    if number is None or published is None:
        return {heading: "" if published is None else f"{published:g}", DIFFERENCE: "", PERCENT: ""}
    difference = number - published
    percent = f"{100.0 * difference / published:+.2f}" if published else ""
    sign = "+" if difference > 0.0 else ""
    return {
        heading: f"{published:g}",
        DIFFERENCE: sign + shown_number(difference, min(digits, 3)),
        PERCENT: "0.00" if percent in ("+0.00", "-0.00") else percent,
    }


def with_unit(label: str, unit: str) -> str:
    """A label with its unit, unless it ends in it already."""
    shown = f" ({unit})"
    return label if unit == "1" or label.endswith(shown) else label + shown


def _over_axis(spec: TableSpec, frame: pd.DataFrame) -> pd.DataFrame:
    found = rows(frame, spec.where)
    index = str(spec.index)
    several = sum(bool(column.published) for column in spec.columns) > 1
    axes = [str(name) for name in found.columns[: list(found.columns).index("outcome")]]
    others = [name for name in axes if name != index and found[name].nunique(dropna=False) > 1]
    lines = []
    for _, row in found.iterrows():
        line = {spec.index_label or index: _label(row[index]), **{name: _label(row[name]) for name in others}}
        for column in spec.columns:
            text, number = _shown(row[column.result], column.result, column.unit, column.digits)
            heading = with_unit(column.label, column.unit)
            if not column.published:
                line[heading] = text
                continue
            line[f"{heading}, {OURS}"] = text
            beside = _compared(number, _published(column, row[index]), column.digits, spec.compared_with)
            for name, cell in beside.items():
                line[f"{column.label}, {name}" if several else name] = cell
        lines.append(line)
    return pd.DataFrame(lines)


def _side_by_side(spec: TableSpec, frame: pd.DataFrame) -> pd.DataFrame:
    """One result over two axes, each value with its place in its column."""
    found, (column,), index = rows(frame, spec.where), spec.columns, str(spec.index)
    table = pd.DataFrame({spec.index_label or index: [_label(value) for value in found[index].unique()]})
    for value, part in found.groupby(str(spec.across), sort=False):
        places = part[column.result].rank(method="min")
        cells = {}
        for row, place in zip(part.to_dict("records"), places, strict=True):
            text, number = _shown(row[column.result], column.result, column.unit, column.digits)
            cells[_label(row[index])] = text if number is None else f"{text} ({place:.0f})"
        table[with_unit(f"{column.label}, {_label(value)}", column.unit)] = table.iloc[:, 0].map(cells).fillna("")
    return table


def _published(column: Column, value: Any) -> float | None:
    """The published figure at this value of the axis."""
    return next((number for key, number in column.published.items() if matches({"": value}, {"": key})), None)


def _label(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _of_rows(spec: TableSpec, frame: pd.DataFrame) -> pd.DataFrame:
    lines = [_single(spec, row, frame) for row in spec.rows]
    table = pd.DataFrame(lines)
    return table.drop(columns=[name for name in table.columns if not table[name].any()])


def _single(spec: TableSpec, row: Row, frame: pd.DataFrame) -> dict[str, str]:
    found = one_row(frame, {**spec.where, **row.where}, f'table {spec.name}, row "{row.label}"')
    text, number = _shown(found[row.result], row.result, row.unit, row.digits)
    return {
        "quantity": row.label,
        "unit": row.unit if row.unit != "1" else "",
        OURS: text,
        **_compared(number, row.published, row.digits, spec.compared_with),
        REMARK: row.remark,
    }


def write_table(spec: TableSpec, frame: pd.DataFrame, folder: Path) -> list[Path]:
    """Write a table as NAME.csv, NAME.md and NAME.tex; returns the paths."""
    return write_frame(spec.name, spec.title, make_table(spec, frame), _notes(spec), folder)


def write_frame(name: str, title: str, table: pd.DataFrame, notes: list[str], folder: Path) -> list[Path]:
    """Write a table of text, with its notes, as NAME.csv, NAME.md and NAME.tex; returns the paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{name}.{ending}" for ending in ("csv", "md", "tex")]
    table.to_csv(paths[0], index=False, lineterminator="\n")
    paths[1].write_text(_markdown(title, table, notes), encoding="utf-8")
    paths[2].write_text(_latex(name, title, table, notes), encoding="utf-8")
    return paths


def _notes(spec: TableSpec) -> list[str]:
    return [
        text
        for text in (f"{spec.compared_with.capitalize()}: {spec.source}." if spec.source else "", spec.note)
        if text
    ]


def _markdown(title: str, table: pd.DataFrame, notes: list[str]) -> str:
    numeric = [name not in WORDS for name in table.columns]
    align = ["right" if right else "left" for right in numeric]
    shown = table.rename(columns=_piped).map(_piped)
    body = shown.to_markdown(index=False, colalign=align, disable_numparse=True)
    return "\n\n".join([f"**{title}**", body, *notes]) + "\n"


def _piped(text: str) -> str:
    return str(text).replace("|", r"\|")


def _latex(name: str, title: str, table: pd.DataFrame, notes: list[str]) -> str:
    columns = "".join({REMARK: "p{45mm}"}.get(column, "l" if column in WORDS else "r") for column in table.columns)
    caption = " ".join([f"{title}.", *notes])
    headed = table.rename(columns=_escaped).map(_escaped)
    return str(
        headed.style.hide(axis="index").to_latex(
            hrules=True,
            caption=_escaped(caption),
            label=f"tab:{name}",
            column_format=columns,
            position_float="centering",
        )
    )


_SPECIAL = str.maketrans(
    {
        **{character: f"\\{character}" for character in "%&_#${}"},
        "^": r"\textasciicircum{}",
        "~": r"\textasciitilde{}",
        "\\": r"\textbackslash{}",
    }
)


def _escaped(text: str) -> str:
    return str(text).translate(_SPECIAL)
