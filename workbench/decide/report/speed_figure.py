"""The figure of error against speed: of each kind the candidate that does best where it was asked."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.decide.candidate import KINDS, CandidateResult
from workbench.decide.report.answer import nearest
from workbench.decide.report.axes import error_label, panel
from workbench.decide.report.names import MM, choice
from workbench.decide.result import Decision
from workbench.publish.style import PANEL_HEIGHT, WIDTH, line_style, marker, plain_numbers

LEAST_BOUND = 1e-3
"""Of the error: a bar begins no lower, since its axis is logarithmic."""


@dataclass(frozen=True, eq=False)
class KindCurve:
    """The candidate of a kind, numbered as `KINDS`, at every speed at which it has an error, from the slowest on."""

    number: int
    label: str
    rows: Sequence[CandidateResult]


def kind_curves(decision: Decision) -> list[KindCurve]:
    """The numbers of the figure of a decision."""
    curves = []
    for number, kind in enumerate(KINDS):
        best = nearest(decision, decision.table.speed, decision.table.spread, kind)
        if best is None:
            continue
        rows = [
            row
            for cell in decision.cells
            for row in cell.rows
            if (row.candidate, row.spread) == (best.candidate, best.spread) and math.isfinite(row.error)
        ]
        if rows:
            curves.append(KindCurve(number, f"{kind}: {choice(best)}", sorted(rows, key=lambda row: row.speed)))
    return curves


def speed_figure(decision: Decision) -> tuple[Figure, str]:
    """The figure, and its caption."""
    table, curves = decision.table, kind_curves(decision)
    figure, axes = panel(WIDTH, PANEL_HEIGHT * 1.25, f"Error against speed: friction spread by {table.spread:g} std")
    for curve in curves:
        _draw(axes, curve, decision.plan.several)
    axes.axhline(table.accuracy * MM, color="black", linestyle="--", linewidth=1.0, label="accuracy")
    axes.axvline(table.speed * MM, color="#888888", linestyle=":", linewidth=1.0, label="asked speed")
    axes.set_xscale("log")
    axes.set_yscale("log")
    if curves:
        top = max(row.error * MM for curve in curves for row in curve.rows)
        axes.set_ylim(top=1.5 * max(top, table.accuracy * MM))
    axes.set_xticks(
        [speed * MM for speed in decision.plan.speeds], [f"{speed * MM:g}" for speed in decision.plan.speeds]
    )
    axes.set_xticks([], minor=True)
    plain_numbers(axes.yaxis)
    axes.set_xlabel("peak speed (mm/s)")
    axes.set_ylabel(error_label(decision))
    figure.legend(loc="outside lower center", ncols=2)
    band = "; bars: 95 % interval of the quantile, where the draws bound it" if decision.plan.several else ""
    return figure, f"The choice of each kind that does best where it was asked, at every speed{band}."


def _draw(axes: Axes, curve: KindCurve, several: bool) -> None:
    speeds, errors = [row.speed * MM for row in curve.rows], [row.error * MM for row in curve.rows]
    style = line_style(curve.number)
    axes.plot(speeds, errors, **style, marker=marker(curve.number), label=curve.label)
    if several:
        bound = [row for row in curve.rows if math.isfinite(row.error_high)]
        low = [max(row.error_low, LEAST_BOUND * row.error) * MM for row in bound]
        high = [row.error_high * MM for row in bound]
        axes.vlines([row.speed * MM for row in bound], low, high, color=style["color"], alpha=0.35, linewidth=5.0)
