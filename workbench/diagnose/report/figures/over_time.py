"""Residual over time: a row for each side of each record, a column a residual of the balance."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.diagnose.report.figures.frame import FLOOR, Side, legend, panels_of
from workbench.diagnose.report.figures.residuals import Residuals
from workbench.publish.pictures import Picture
from workbench.publish.style import figure_style

MOST_RECORDS = {"fit": 3, "held-out": 2}
"""Of each use that are drawn: more would make a figure that no page holds."""


@dataclass(frozen=True, eq=False)
class TimePanel:
    """A residual of one record over time (s), with one model; it is drawn up to `limit` on either side of 0."""

    row: int
    column: int
    title: str
    side: Side
    time: np.ndarray
    residual: np.ndarray
    limit: float


@dataclass(frozen=True, eq=False)
class OverTime:
    """The panels in a grid of `rows` and `columns`; `left_out` counts the records that are not drawn."""

    residuals: Residuals
    rows: int
    columns: int
    panels: Sequence[TimePanel]
    left_out: int


def over_time_data(residuals: Residuals) -> OverTime:
    """The numbers of the figure, in the balance's unit."""
    labels = list(dict.fromkeys((part.use, part.label) for part in residuals.parts))
    shown = [key for use, most in MOST_RECORDS.items() for key in [key for key in labels if key[0] == use][:most]]
    sides = residuals.sides
    panels = []
    for part in residuals.parts:
        if (part.use, part.label) not in shown:
            continue
        for row, side in enumerate(sides, len(sides) * shown.index((part.use, part.label))):
            which = f", {side.key}" if len(sides) > 1 else ""
            title = f'{residuals.what(part.number)}, {part.use} record "{part.label}"{which}'
            limit = residuals.highest(side)
            panels.append(TimePanel(row, part.number, title, side, part.time, part.of(side.key), limit))
    rows, columns = len(shown) * len(sides), len(residuals.numbers)
    return OverTime(residuals, rows, columns, panels, len(labels) - len(shown))


def draw_over_time(data: OverTime) -> Picture:
    """The figure."""
    residuals, sides = data.residuals, data.residuals.sides
    with figure_style():
        title = f"{residuals.title}: what the plant leaves unexplained over time"
        figure, grid = panels_of(data.rows, data.columns, title)
        for panel in data.panels:
            axes, side = grid[panel.row, panel.column], panel.side
            axes.axhspan(-residuals.floor, residuals.floor, label="noise floor (± 1 std)", **FLOOR)
            axes.plot(panel.time, panel.residual, color=side.colour, linewidth=0.7, label=side.label)
            axes.set_title(panel.title, fontsize="small")
            axes.set_ylim(-panel.limit, panel.limit)
            axes.set_ylabel(f"residual ({residuals.unit})")
            axes.set_xlabel("time (s)")
        legend(figure, *grid[: len(sides), 0])
    caption = (
        f"Residual of the {residuals.words} balance in {residuals.unit}. A complete model leaves noise that "
        "keeps to the grey band in two thirds of the time."
        + (" Before and after have scales of their own." if len(sides) > 1 else "")
        + " Gaps: there the balance cannot be told, as something "
        "happened faster than the smoothing follows, or near the ends. Rare peaks (1 %) may go beyond the axis."
        + (f" {data.left_out} further record{'s are' if data.left_out > 1 else ' is'} not drawn." * bool(data.left_out))
    )
    return Picture(figure, caption, residuals.balance)
