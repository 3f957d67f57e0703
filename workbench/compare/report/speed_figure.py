"""The figure of errors against real rpm: of each family the controller with the least error in colour, others grey."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.compare.candidates import Candidate, Cell, Family, order, sound
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
from workbench.compare.schema import ComparisonTable
from workbench.publish.style import COLOURS
from workbench.publish.words import plain_name

FAMILY_STYLE: dict[Family, Style] = {
    "plain": Style(COLOURS[0], "o", "-"),
    "pressure": Style(COLOURS[1], "s", "--"),
    "friction model": Style(COLOURS[2], "^", "-."),
}


@dataclass(frozen=True)
class SpeedPoint:
    """A candidate at its real speed (rpm): its error (mm), that with its interval, and whether it has a flaw."""

    real_rpm: float
    error: float
    bar: Bar
    flawed: bool


@dataclass(frozen=True)
class SpeedLine:
    """A controller over the speed of rotation; `best`: that of its family with the least error that holds."""

    controller: str
    family: Family
    best: bool
    points: Sequence[SpeedPoint]


@dataclass(frozen=True)
class SpeedPanel:
    """The numbers of a panel: a line a controller, and the commanded speeds (rpm)."""

    axis: ErrorAxis
    lines: Sequence[SpeedLine]
    commands: Sequence[float]


def speed_panel(table: ComparisonTable, cell: Cell, candidates: Sequence[Candidate]) -> SpeedPanel:
    """The numbers of the panel of a cell."""
    by_controller: dict[str, list[Candidate]] = {}
    for candidate in sorted(candidates, key=lambda each: each.rpm):
        if not np.isnan(candidate.errors).all():
            by_controller.setdefault(candidate.controller, []).append(candidate)
    best = best_of_families(candidates)
    lines = [
        SpeedLine(name, own[0].family, name in best, [_point(table, each) for each in own])
        for name, own in by_controller.items()
    ]
    return SpeedPanel(error_axis(table, cell, candidates), lines, sorted({each.rpm for each in candidates}))


def _point(table: ComparisonTable, candidate: Candidate) -> SpeedPoint:
    place = candidate.rpm if candidate.rpm == 0 else candidate.real_rpm
    error = shown(table, float(np.nanmean(candidate.errors)))
    return SpeedPoint(place, error, bar_of(table, candidate, place), bool(candidate.flaw))


def best_of_families(candidates: Sequence[Candidate]) -> set[str]:
    """The controller of each family with the least error that holds."""
    best: dict[Family, Candidate] = {}
    for candidate in sorted(sound(candidates), key=order):
        best.setdefault(candidate.family, candidate)
    return {candidate.controller for candidate in best.values()}


def speed_figure(table: ComparisonTable, cells: Candidates, title: str) -> Figure:
    """The figure of the cells of a scenario."""
    return drawn(title, cells, lambda cell, own: speed_panel(table, cell, own), _draw)


def _draw(axes: Axes, panel: SpeedPanel) -> ErrorAxis:
    for line in panel.lines:
        if line.best:
            label = f"{plain_name(line.controller)} ({line.family})"
            draw_bars(axes, [point.bar for point in line.points], FAMILY_STYLE[line.family], label)
        else:
            rpm, errors = [point.real_rpm for point in line.points], [point.error for point in line.points]
            draw_others(axes, rpm, errors, 3.0, "-")
        flawed = [(point.real_rpm, point.error) for point in line.points if point.flawed]
        if flawed:
            axes.plot(*zip(*flawed, strict=True), "x", color="#444444", markersize=5, zorder=3)
    least = next((rpm for rpm in panel.commands if rpm > 0), 1.0)
    axes.set_xscale("symlog", linthresh=least, linscale=0.6)
    axes.set_xticks(panel.commands, [f"{rpm:g}" for rpm in panel.commands])
    axes.minorticks_off()
    axes.set_xlim(-0.15 * least, 1.3 * max(*panel.commands, least))
    axes.set_xlabel("real mean speed (rpm)")
    return panel.axis
