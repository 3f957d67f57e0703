"""Every case of a study on its page: a table that sorts and filters, and the trajectory of the case that is clicked."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup

from plants.axis import LINEAR
from workbench.metrics.registry import axis_of
from workbench.publish.along import SHOWN
from workbench.publish.page.packed import in_script
from workbench.publish.style import COLOURS
from workbench.publish.tables import with_unit
from workbench.publish.words import plain_name
from workbench.simulation.run import COMPLETED, TRUE
from workbench.study.report.select import OUTCOME, axes_of
from workbench.study.report.shown_figures import FIGURES, column_along, shown_figure, shown_unit
from workbench.study.sketches import COMMAND, ERROR, MOST_CASES, POSITION, REFERENCE
from workbench.study.store import read_sketches
from workbench.study.study import DRAW

DIGITS = 4

MOST_CHOICES = 40
"""Values of an axis that can be chosen from a list."""


@dataclass(frozen=True)
class CaseRow:
    """A line of the table: its cells, and the case whose trajectory it shows, None without one."""

    cells: Sequence[str]
    case: int | None


@dataclass(frozen=True)
class Cases:
    """The table of all cases: headings, which of them are words, which can be chosen from a list, and what is shown.

    `sketches` are JSON that may stand in a script element.
    """

    headings: Sequence[str]
    words: Sequence[bool]
    choices: Sequence[int]
    rows: Sequence[CaseRow]
    notes: Sequence[str]
    views: Markup
    sketches: Mapping[int, str]


def cases_of(frame: pd.DataFrame, folder: Path) -> Cases:
    """The cases of results; draws of machines stand in one line, with the means of their figures."""
    axes = axes_of(frame.columns)
    apart = [name for name in axes if name != DRAW and frame[name].nunique(dropna=False) > 1]
    axis = axis_of([str(name) for name in frame.columns])
    figures = [(name, column_along(name, axis), words) for name, words in FIGURES]
    figures = [
        (name, column, words) for name, column, words in figures if column in frame and frame[column].notna().any()
    ]
    draws = frame[DRAW].nunique() if DRAW in frame else 1
    grouped, count = _groups(frame, apart)
    found = read_sketches(folder)
    wanted = (*apart, OUTCOME, *(column for _, column, _ in figures))
    columns = {name: frame[name].to_numpy() for name in wanted}
    cells = [_cells(columns, places, apart, figures, axis) for places in grouped]
    cases = [int(frame.index[places[0]]) for places in grouped]
    rows = [CaseRow(own, case if case in found else None) for own, case in zip(cells, cases, strict=True)]
    shown = {row.case for row in rows}
    return Cases(
        headings=[
            *(plain_name(name) for name in apart),
            OUTCOME,
            *(_heading(name, words, axis) for name, _, words in figures),
        ],
        words=[
            *(not pd.api.types.is_numeric_dtype(frame[name]) for name in apart),
            True,
            *(name == "limit_cycle" for name, *_ in figures),
        ],
        choices=[i for i, name in enumerate(apart) if frame[name].nunique() <= MOST_CHOICES],
        rows=rows,
        notes=_notes(count, draws, apart, bool(found)),
        views=Markup(in_script({"views": _views(axis), "names": list(range(len(apart)))})),
        sketches={case: text for case, text in found.items() if case in shown},
    )


def _groups(frame: pd.DataFrame, apart: Sequence[str]) -> tuple[list[list[int]], int]:
    """The places of the cases by what tells them apart, in their order: the draws of each together; the first
    `MOST_CASES`, and how many there are.
    """
    if not apart:
        return [[*range(len(frame))]], 1
    numbers = frame.groupby(list(apart), sort=False, dropna=False).ngroup().to_numpy()
    groups: dict[int, list[int]] = {}
    for place in np.flatnonzero(numbers < MOST_CASES).tolist():
        groups.setdefault(int(numbers[place]), []).append(place)
    return [*groups.values()], int(numbers.max()) + 1


def _cells(
    columns: Mapping[str, np.ndarray],
    places: Sequence[int],
    apart: Sequence[str],
    figures: Sequence[tuple[str, str, str]],
    axis: str,
) -> list[str]:
    """What stands in the line of the cases at these places, which are draws of one."""
    cells = [_axis_cell(columns[name][places[0]]) for name in apart]
    cells.append(_counted([str(columns[OUTCOME][place]) for place in places]))
    for name, column, _ in figures:
        own = (columns[column][place] for place in places)
        values = [value for value in own if value is not None and value == value]
        if not values:
            cells.append("")
        elif name == "limit_cycle":
            cells.append(_counted([plain_name(str(value)) for value in values]))
        else:
            cells.append(shown_figure(name, float(np.mean(np.array(values, dtype=float))), axis, DIGITS))
    return cells


def _axis_cell(value: object) -> str:
    if value is None or value != value:
        return ""
    return f"{value:.12g}" if isinstance(value, float) else plain_name(str(value))


def _counted(words: Sequence[str]) -> str:
    """What all draws share, or how many have what."""
    counts = {word: words.count(word) for word in dict.fromkeys(words)}
    if len(counts) == 1:
        return words[0]
    return ", ".join(f"{word} {count} of {len(words)}" for word, count in counts.items() if word != COMPLETED)


def _heading(name: str, words: str, axis: str) -> str:
    return words if name == "limit_cycle" else with_unit(words, shown_unit(name, axis)[0])


def _notes(count: int, draws: int, apart: Sequence[str], sketched: bool) -> list[str]:
    notes = []
    if draws > 1:
        notes.append(
            f"Figures are means over those of {draws} draws of the machine that have them; motions are those of the "
            "first draw."
        )
    if count > MOST_CASES:
        notes.append(f"The first {MOST_CASES} of {count}; all are in results.csv.")
    if any("." in name for name in apart):
        notes.append("Columns with a dot in their name are keys of the study, in SI.")
    if not sketched:
        notes.append("No trajectories are kept here: results.sqlite, which has them, is not in this folder.")
    return notes


def _views(axis: str) -> list[dict[str, Any]]:
    """What is drawn of a trajectory, in a reader's units."""
    along = SHOWN[axis]
    time = {"x": "time", "x_label": "time (s)", "x_factor": 1.0, "colours": COLOURS}
    length = {"y_factor": along.factor}
    position = "position" if axis == LINEAR else "angle"
    return [
        {
            **time,
            **length,
            "title": f"{position} and reference".capitalize(),
            "y_label": with_unit(position, along.unit),
            "curves": [{"name": "reference", "signal": REFERENCE}, {"name": position, "signal": POSITION}],
        },
        {
            **time,
            **length,
            "title": "Error",
            "y_label": with_unit(ERROR, along.unit),
            "curves": [{"name": ERROR, "signal": ERROR}],
        },
        {
            **time,
            "title": "Command",
            "y_label": COMMAND,
            "y_factor": 1.0,
            "curves": [{"name": COMMAND, "signal": COMMAND}],
        },
        {
            "title": "Friction against velocity",
            "x": "velocity",
            "x_label": with_unit("velocity", along.speed_unit),
            "x_factor": along.factor,
            "y_label": with_unit("friction", along.force_unit),
            "y_factor": 1.0,
            "curves": [{"name": "friction", "signal": TRUE}],
            "colours": COLOURS,
        },
    ]
