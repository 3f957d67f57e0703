"""Figures of a decision: error against power, the map of what suffices, error against speed."""

import math
from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from workbench.decide.candidate import KINDS, CandidateResult
from workbench.decide.order import non_dominated
from workbench.decide.report.answer import nearest
from workbench.decide.report.map import COLOURS as WORDS
from workbench.decide.report.map import MEANING, Field, failing, fields
from workbench.decide.report.names import ERRORS, MM, POWERS, choice, percent, speed_of
from workbench.decide.result import Decision
from workbench.decide.schema import DecideTable
from workbench.publish.pictures import Picture, save
from workbench.publish.style import COLOURS, PANEL_HEIGHT, WIDTH, figure_style, line_style, marker, plain_numbers
from workbench.publish.words import plain_name

SMALLEST, GROWTH = 4.0, 2.2
"""Points of the marker of the slowest rotation, and by how much that of the next is larger."""

RING = 15.0
"""Points of the ring about the non-dominated."""

LEGEND_ROWS = 4
"""Controllers, sizes and lines have columns of their own in the legend, of this height."""

CELL = 1.45, 1.0
"""Inches of a cell of the map."""

HATCH = "#00000038"


def write_figures(decision: Decision, folder: Path) -> list[Picture]:
    """Write the figures that the decision has: none of points without an error, of one cell, of a single speed."""
    plan, drawn = decision.plan, list[tuple[str, Figure, str]]()
    known = any(_is_known(row) for row in decision.asked.ordered)
    with figure_style():
        if known:
            drawn.append(("error_against_power", *_trade(decision)))
        if len(plan.speeds) * len(plan.spreads) > 1:
            drawn.append(("map", *_map(decision)))
        if known and len(plan.speeds) > 1:
            drawn.append(("error_against_speed", *_curves(decision)))
    return [Picture(save(figure, name, folder)[-1], caption) for name, figure, caption in drawn]


def _is_known(row: CandidateResult) -> bool:
    """Whether enough runs complete for an error and a power."""
    return math.isfinite(row.error) and math.isfinite(row.mean_power)


def _figure(width: float, height: float, title: str) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    return figure, figure.subplots()


def _error_label(decision: Decision) -> str:
    quantile = f", {percent(decision.table)} quantile" if decision.plan.several else ""
    return f"{ERRORS[decision.table.figure]}{quantile} (mm)"


def _where(decision: Decision) -> str:
    return f"{speed_of(decision.table.speed)}, friction spread by {decision.table.spread:g} std"


def _trade(decision: Decision) -> tuple[Figure, str]:
    """Every candidate that was asked about: error against power, limits, and the non-dominated set."""
    figure, axes = _figure(WIDTH * 1.15, PANEL_HEIGHT * 1.6, f"Error against power: {_where(decision)}")
    table = decision.table
    known = [row for row in decision.asked.ordered if _is_known(row)]
    names = list(dict.fromkeys(row.controller for row in decision.asked.rows))
    speeds = sorted({row.rpm for row in decision.asked.rows})
    for row in known:
        i = names.index(row.controller)
        size = SMALLEST + GROWTH * speeds.index(row.rpm)
        axes.plot(row.mean_power, row.error * MM, marker(i), color=line_style(i)["color"], ms=size, alpha=0.85)
    front = non_dominated(known)
    power, error = [row.mean_power for row in front], [row.error * MM for row in front]
    axes.plot(power, error, color="black", drawstyle="steps-post", linewidth=1.0, zorder=1.9)
    axes.plot(power, error, "o", color="black", fillstyle="none", markersize=RING)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.margins(0.12)
    _limits(axes, table)
    plain_numbers(axes.xaxis)
    plain_numbers(axes.yaxis)
    axes.set_xlabel(f"mean power (W): {POWERS[table.power_figure]}")
    axes.set_ylabel(_error_label(decision))
    handles = _trade_legend(decision, names, speeds)
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles) // LEGEND_ROWS)
    caption = (
        f"Every candidate at {_where(decision)}: marker by controller, size by rotation; shaded: what keeps to both "
        f"limits. The line joins the non-dominated set: {'; '.join(choice(row) for row in front) or 'empty'}."
    )
    left_out = len(decision.asked.search) - len(known)
    return figure, caption + (f" {left_out} not drawn: too few of their runs complete." if left_out else "")


def _limits(axes: Axes, table: DecideTable) -> None:
    """Accuracy and power as lines, and what keeps to both shaded."""
    accuracy = table.accuracy * MM
    axes.axhline(accuracy, color=COLOURS[1], linestyle="--")
    axes.axvline(table.power, color=COLOURS[1], linestyle=":")
    left, bottom = axes.get_xlim()[0], axes.get_ylim()[0]
    axes.fill_between([left, table.power], bottom, accuracy, color="#eeeeee", zorder=0)
    axes.set_xlim(left=left)
    axes.set_ylim(bottom=bottom)


def _trade_legend(decision: Decision, names: Sequence[str], speeds: Sequence[float]) -> list[Line2D]:
    table = decision.table
    controllers = [
        Line2D([], [], color=line_style(i)["color"], marker=marker(i), linestyle="none", label=plain_name(name))
        for i, name in enumerate(names)
    ]
    sizes = [
        Line2D([], [], color="#666666", marker="o", ms=SMALLEST + GROWTH * i, linestyle="none", label=f"{speed:g} rpm")
        for i, speed in enumerate(speeds)
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


def _map(decision: Decision) -> tuple[Figure, str]:
    """What suffices over speed and spread."""
    plan, table = decision.plan, decision.table
    width = max(WIDTH, CELL[0] * len(plan.speeds) + 0.9)
    figure, axes = _figure(
        width, CELL[1] * max(2, len(plan.spreads)) + 1.5, "What suffices, over speed and spread of friction"
    )
    rows = list(fields(decision).values())
    for i, spread in enumerate(plan.spreads):
        for j, speed in enumerate(plan.speeds):
            fails = [f"{row.kind}: {row.main_failure}" for row in failing(decision, decision.at(speed, spread))]
            _cell(axes, j, i, rows[i][j], fails)
    place = (plan.speeds.index(table.speed), plan.spreads.index(table.spread))
    axes.add_patch(Rectangle(place, 1, 1, fill=False, edgecolor="black", linewidth=3.0, zorder=3, clip_on=False))
    axes.set_xlim(0, len(plan.speeds))
    axes.set_ylim(0, len(plan.spreads))
    axes.set_xticks([j + 0.5 for j in range(len(plan.speeds))], [f"{speed * MM:g}" for speed in plan.speeds])
    axes.set_yticks([i + 0.5 for i in range(len(plan.spreads))], [f"{spread:g}" for spread in plan.spreads])
    axes.tick_params(length=0)
    axes.grid(visible=False)
    axes.set_xlabel("peak speed (mm/s)")
    axes.set_ylabel("spread of friction (std)")
    used = {field.word for row in rows for field in row}
    handles = [
        Patch(facecolor=colour, hatch=hatch, edgecolor=HATCH, label=MEANING[word])
        for word, (colour, hatch) in WORDS.items()
        if word in used
    ]
    asked = Patch(facecolor="none", edgecolor="black", linewidth=2.5, label="what was asked")
    figure.legend(handles=[*handles, asked], loc="outside lower center", ncols=2 if len(handles) > 2 else 3)
    return figure, (
        f"What suffices for an error of {table.accuracy * MM:g} mm within {table.power:g} W with a probability of "
        f"{table.probability:g}: in each field the choice (or the nearest), its probability"
        f"{' on fresh draws' * plan.several}, its power, and by what the simpler kinds fail, or "
        "that it cannot be told of them."
    )


def _cell(axes: Axes, j: int, i: int, field: Field, fails: Sequence[str]) -> None:
    """One field of the map with its choice, and what fails."""
    colour, hatch = WORDS[field.word]
    axes.add_patch(Rectangle((j, i), 1, 1, facecolor=colour, hatch=hatch, edgecolor=HATCH, linewidth=0.0))
    axes.add_patch(Rectangle((j, i), 1, 1, fill=False, edgecolor="#444444", linewidth=0.6))
    label = "\n".join(line for line in (field.choice, field.chance, field.price) if line)
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5}
    axes.text(j + 0.5, i + 0.93, label, ha="center", va="top", fontsize=6.5, bbox=box, zorder=4)
    told = "\n".join(
        [*(("fails by", *fails) if fails else ()), *(f"cannot be told of {kind}" for kind in field.doubtful)]
    )
    if told:
        axes.text(j + 0.5, i + 0.05, told, ha="center", va="bottom", fontsize=5.5, bbox=box, zorder=4)


def _curves(decision: Decision) -> tuple[Figure, str]:
    """Error against speed of the best choice of each kind where it was asked."""
    figure, axes = _figure(
        WIDTH, PANEL_HEIGHT * 1.25, f"Error against speed: friction spread by {decision.table.spread:g} std"
    )
    best = [nearest(decision, decision.table.speed, decision.table.spread, kind) for kind in KINDS]
    top = 0.0
    for i, row in enumerate(best):
        if row is not None:
            top = max(top, _curve(axes, decision, row, i))
    axes.axhline(decision.table.accuracy * MM, color="black", linestyle="--", linewidth=1.0, label="accuracy")
    axes.axvline(decision.table.speed * MM, color="#888888", linestyle=":", linewidth=1.0, label="asked speed")
    axes.set_xscale("log")
    axes.set_yscale("log")
    if top:
        axes.set_ylim(top=1.5 * max(top, decision.table.accuracy * MM))
    axes.set_xticks(
        [speed * MM for speed in decision.plan.speeds], [f"{speed * MM:g}" for speed in decision.plan.speeds]
    )
    axes.set_xticks([], minor=True)
    plain_numbers(axes.yaxis)
    axes.set_xlabel("peak speed (mm/s)")
    axes.set_ylabel(_error_label(decision))
    figure.legend(loc="outside lower center", ncols=2)
    band = "; bars: 95 % interval of the quantile, where the draws bound it" if decision.plan.several else ""
    return figure, f"The choice of each kind that does best where it was asked, at every speed{band}."


def _curve(axes: Axes, decision: Decision, row: CandidateResult, number: int) -> float:
    """One choice at every speed; returns the largest error drawn (mm)."""
    same = sorted(
        (
            each
            for cell in decision.cells
            for each in cell.rows
            if (each.candidate, each.spread) == (row.candidate, row.spread) and math.isfinite(each.error)
        ),
        key=lambda each: each.speed,
    )
    if not same:
        return 0.0
    speeds, errors = [each.speed * MM for each in same], [each.error * MM for each in same]
    label = f"{row.kind}: {choice(row)}"
    style = line_style(number)
    axes.plot(speeds, errors, **style, marker=marker(number), label=label)
    if decision.plan.several:
        bound = [each for each in same if math.isfinite(each.error_high)]
        low = [max(each.error_low, 1e-3 * each.error) * MM for each in bound]
        at = [each.speed * MM for each in bound]
        axes.vlines(at, low, [each.error_high * MM for each in bound], color=style["color"], alpha=0.35, linewidth=5.0)
    return max(errors)
