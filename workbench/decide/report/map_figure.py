"""The figure of the map: what suffices over speed and spread, and what fails of what is simpler."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from workbench.decide.report.axes import panel
from workbench.decide.report.map import COLOURS as WORDS
from workbench.decide.report.map import MEANING, Field, failing, fields
from workbench.decide.report.names import MM
from workbench.decide.result import Decision
from workbench.publish.style import WIDTH

CELL = 1.45, 1.0
"""Inches of a cell of the map."""

HATCH = "#00000038"
"""Black, mostly transparent: hatches that leave the words legible."""


def failures(decision: Decision, speed: float, spread: float) -> list[str]:
    """What fails most at a speed (m/s) and a spread, of each kind that is simpler than the choice."""
    return [f"{row.kind}: {row.main_failure}" for row in failing(decision, decision.at(speed, spread))]


def map_figure(decision: Decision) -> tuple[Figure, str]:
    """The figure, and its caption."""
    plan, table = decision.plan, decision.table
    width = max(WIDTH, CELL[0] * len(plan.speeds) + 0.9)
    figure, axes = panel(
        width, CELL[1] * max(2, len(plan.spreads)) + 1.5, "What suffices, over speed and spread of friction"
    )
    rows = list(fields(decision).values())
    for i, spread in enumerate(plan.spreads):
        for j, speed in enumerate(plan.speeds):
            _cell(axes, j, i, rows[i][j], failures(decision, speed, spread))
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
