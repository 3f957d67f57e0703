"""Tables of text, as CSV, Markdown and LaTeX (siunitx, booktabs), and numbers as a reader sees them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.publish.folders import anew, made
from workbench.publish.latex.table import latex_table
from workbench.publish.markdown import in_cell, in_line

if TYPE_CHECKING:
    import pandas as pd

REMARK = "remark"

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


@dataclass(frozen=True, eq=False)
class Table:
    """A table of text with its title, and what a reader must know of it.

    `sources` say of headings, or of what they end in behind a comma, where the values come from.
    """

    title: str
    cells: "pd.DataFrame"
    notes: Sequence[str] = ()
    sources: Mapping[str, str] = field(default_factory=dict)


def shown_number(number: float, digits: int) -> str:
    """`number` with `digits` significant digits, in plain notation where that is readable."""
    if number == 0.0 or not 1e-4 <= abs(number) < 1e6:
        return f"{number:.{digits - 1}e}" if number else "0"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(number))))
    return f"{number:.{decimals}f}"


def shown_interval(low: float, high: float, digits: int) -> str:
    """Both ends, with so many digits that they differ, `digits` at least."""
    width, size = abs(high - low), max(abs(low), abs(high))
    if 0.0 < width < size:
        digits = max(digits, min(2 + math.ceil(math.log10(size / width)), 12))
    return f"{shown_number(low, digits)} to {shown_number(high, digits)}"


def with_unit(label: str, unit: str) -> str:
    """A label with its unit, unless it ends in it already."""
    shown = f" ({unit})"
    return label if unit == "1" or label.endswith(shown) else label + shown


def write_frame(name: str, table: Table, folder: Path) -> list[Path]:
    """Write a table, with its notes, as NAME.csv, NAME.md and NAME.tex; returns the paths."""
    paths = [anew(made(folder) / f"{name}.{ending}") for ending in ("csv", "md", "tex")]
    table.cells.to_csv(paths[0], index=False, lineterminator="\n")
    paths[1].write_text(_markdown(table), encoding="utf-8")
    paths[2].write_text(_latex(name, table), encoding="utf-8")
    return paths


def _markdown(table: Table) -> str:
    numeric = [name not in WORDS for name in table.cells.columns]
    align = ["right" if right else "left" for right in numeric]
    shown = table.cells.rename(columns=lambda name: in_cell(str(name))).map(lambda cell: in_cell(str(cell)))
    body = shown.to_markdown(index=False, colalign=align, disable_numparse=True)
    sources = [f"{name[:1].upper()}{name[1:]}: {source}." for name, source in table.sources.items()]
    return "\n\n".join([f"**{in_line(table.title)}**", body, *map(in_line, (*sources, *table.notes))]) + "\n"


def _latex(name: str, table: Table) -> str:
    cells = {str(heading): column.astype(str).tolist() for heading, column in table.cells.items()}
    return latex_table(name, table.title, cells, table.notes, table.sources, WORDS)
