"""The figure of errors against paid power: who stands for each class in colour, all others that hold in grey."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.compare.candidates import CLASSES, Candidate, Cell, Class, sound
from workbench.compare.report.panels import (
    Bar,
    Candidates,
    ErrorAxis,
    Style,
    bar_of,
    draw_bars,
    draw_others,
    drawn,
    error_axis,
    shown,
)
from workbench.compare.result import Verdict
from workbench.compare.schema import ComparisonTable
from workbench.publish.style import COLOURS, plain_numbers

CLASS_STYLE: dict[Class, Style] = {
    "nothing": Style(COLOURS[6], "o", size=6),
    "compensate": Style(COLOURS[0], "s", size=6),
    "avoid": Style(COLOURS[1], "^", size=6),
    "both": Style(COLOURS[3], "D", size=6),
}


@dataclass(frozen=True)
class Standing:
    """Who stands for a class: its error at the power (W) that it pays."""

    kind: Class
    words: str
    bar: Bar


@dataclass(frozen=True)
class PowerPanel:
    """The numbers of a panel: paid power (W) and error (mm) of all that hold, and who stands for each class."""

    axis: ErrorAxis
    powers: Sequence[float]
    errors: Sequence[float]
    standing: Sequence[Standing]


def power_panel(table: ComparisonTable, cell: Cell, candidates: Sequence[Candidate], verdict: Verdict) -> PowerPanel:
    """The numbers of the panel of a cell."""
    holding, by_key = list(sound(candidates)), {each.key: each for each in candidates}
    standing = {kind: by_key[best.key] for kind, best in verdict.best.items() if best.key in by_key}
    return PowerPanel(
        error_axis(table, cell, candidates),
        [each.paid_power for each in holding],
        [shown(table, each.errors.mean()) for each in holding],
        [
            Standing(kind, standing[kind].words, bar_of(table, standing[kind], standing[kind].paid_power))
            for kind in CLASSES
            if kind in standing
        ],
    )


def power_figure(table: ComparisonTable, cells: Candidates, verdicts: Mapping[Cell, Verdict], title: str) -> Figure:
    """The figure of the cells of a scenario."""
    return drawn(title, cells, lambda cell, own: power_panel(table, cell, own, verdicts[cell]), _draw)


def _draw(axes: Axes, panel: PowerPanel) -> ErrorAxis:
    draw_others(axes, panel.powers, panel.errors, 5.0, "none")
    for each in panel.standing:
        draw_bars(axes, [each.bar], CLASS_STYLE[each.kind], f"{each.kind}: {each.words}")
    axes.set_xscale("log")
    plain_numbers(axes.xaxis)
    axes.tick_params(axis="x", labelsize="small")
    axes.set_xlabel("pump and motor terminals (W)")
    return panel.axis
