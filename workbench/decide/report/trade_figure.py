"""The figure of error against power: every candidate where it was asked, the limits, and the non-dominated set."""

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from workbench.decide.candidate import CandidateResult
from workbench.decide.order import non_dominated
from workbench.decide.report.axes import error_label, is_known, panel
from workbench.decide.report.names import MM, POWERS, choice, speed_of
from workbench.decide.result import Decision
from workbench.decide.schema import DecideTable
from workbench.publish.style import COLOURS, PANEL_HEIGHT, WIDTH, line_style, marker, plain_numbers
from workbench.publish.words import plain_name

SMALLEST, GROWTH = 4.0, 2.2
"""Points of the marker of the slowest rotation, and by how much that of the next is larger."""

RING = 15.0
"""Points of the ring about the non-dominated."""

LEGEND_ROWS = 4
"""Controllers, sizes and lines have columns of their own in the legend, of this height."""


@dataclass(frozen=True, eq=False)
class Trade:
    """The numbers of the figure: candidates with an error and a power, the non-dominated of them, how many have none,
    and the controllers and rpm of all.
    """

    known: Sequence[CandidateResult]
    front: Sequence[CandidateResult]
    left_out: int
    controllers: Sequence[str]
    speeds: Sequence[float]


def trade(decision: Decision) -> Trade:
    """The numbers of the figure of a decision."""
    cell = decision.asked
    known = [row for row in cell.ordered if is_known(row)]
    return Trade(
        known,
        non_dominated(known),
        len(cell.search) - len(known),
        list(dict.fromkeys(row.controller for row in cell.rows)),
        sorted({row.rpm for row in cell.rows}),
    )


def trade_figure(decision: Decision) -> tuple[Figure, str]:
    """The figure, and its caption."""
    data, table = trade(decision), decision.table
    where = f"{speed_of(table.speed)}, friction spread by {table.spread:g} std"
    figure, axes = panel(WIDTH * 1.15, PANEL_HEIGHT * 1.6, f"Error against power: {where}")
    for row in data.known:
        i = data.controllers.index(row.controller)
        size = SMALLEST + GROWTH * data.speeds.index(row.rpm)
        axes.plot(row.mean_power, row.error * MM, marker(i), color=line_style(i)["color"], ms=size, alpha=0.85)
    power, error = [row.mean_power for row in data.front], [row.error * MM for row in data.front]
    axes.plot(power, error, color="black", drawstyle="steps-post", linewidth=1.0, zorder=1.9)
    axes.plot(power, error, "o", color="black", fillstyle="none", markersize=RING)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.margins(0.12)
    _limits(axes, table)
    plain_numbers(axes.xaxis)
    plain_numbers(axes.yaxis)
    axes.set_xlabel(f"mean power (W): {POWERS[table.power_figure]}")
    axes.set_ylabel(error_label(decision))
    handles = _legend(table, data)
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles) // LEGEND_ROWS)
    caption = (
        f"Every candidate at {where}: marker by controller, size by rotation; shaded: what keeps to both "
        f"limits. The line joins the non-dominated set: {'; '.join(choice(row) for row in data.front) or 'empty'}."
    )
    return figure, caption + (f" {data.left_out} not drawn: too few of their runs complete." if data.left_out else "")


def _limits(axes: Axes, table: DecideTable) -> None:
    """Accuracy and power as lines, and what keeps to both shaded."""
    accuracy = table.accuracy * MM
    axes.axhline(accuracy, color=COLOURS[1], linestyle="--")
    axes.axvline(table.power, color=COLOURS[1], linestyle=":")
    left, bottom = axes.get_xlim()[0], axes.get_ylim()[0]
    axes.fill_between([left, table.power], bottom, accuracy, color="#eeeeee", zorder=0)
    axes.set_xlim(left=left)
    axes.set_ylim(bottom=bottom)


def _legend(table: DecideTable, data: Trade) -> list[Line2D]:
    controllers = [
        Line2D([], [], color=line_style(i)["color"], marker=marker(i), linestyle="none", label=plain_name(name))
        for i, name in enumerate(data.controllers)
    ]
    sizes = [
        Line2D([], [], color="#666666", marker="o", ms=SMALLEST + GROWTH * i, linestyle="none", label=f"{speed:g} rpm")
        for i, speed in enumerate(data.speeds)
    ]
    lines = [
        Line2D(
            [], [], color="black", marker="o", ms=0.5 * RING, fillstyle="none", linewidth=1.0, label="non-dominated"
        ),
        Line2D([], [], color=COLOURS[1], linestyle="--", label=f"accuracy, {table.accuracy * MM:g} mm"),
        Line2D([], [], color=COLOURS[1], linestyle=":", label=f"power, {table.power:g} W"),
    ]
    blank = Line2D([], [], linestyle="none", label=" ")
    return [each for group in (controllers, sizes, lines) for each in [*group, *[blank] * (-len(group) % LEGEND_ROWS)]]
