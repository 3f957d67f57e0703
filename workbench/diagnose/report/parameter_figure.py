"""The parameters of a diagnosis as a figure: fitted over declared, without and with what was found."""

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from workbench.diagnose.diagnose import Diagnosis
from workbench.diagnose.report.evidence import AFTER, BEFORE, WIDE, Picture, legend
from workbench.diagnose.report.names import REJECTED
from workbench.diagnose.report.parameters import Fitted, Row, parameter_rows
from workbench.diagnose.report.tables import INTERVAL
from workbench.publish.style import figure_style

WIDEST = 4.0
"""Ratio of the largest value to the smallest from which the axis is logarithmic."""

BEYOND = 3.0
"""Factor, or on a linear axis ranges of the values, by which intervals widen the axis beyond the values at most."""

FINE = 100.0
"""Ratio of the axis's ends up to which it has ticks between powers of ten."""


def parameters_figure(found: Diagnosis) -> Picture | None:
    """Fitted over declared values with 95 % intervals; None where nothing that was declared was fitted."""
    rows = {name: row for name, row in parameter_rows(found).items() if row.declared and row.baseline is not None}
    if not rows:
        return None
    last = "with what was rejected" if found.report["verdict"] == REJECTED else "with what was found"
    sides = [("declared plant, fitted", AFTER, "s", 0.0)]
    if found.found:
        sides = [("baseline: declared plant, fitted", BEFORE, "o", -0.14), (last, AFTER, "s", 0.14)]
    with figure_style():
        figure = Figure(figsize=(WIDE, 0.38 * len(rows) + 1.5))
        FigureCanvasAgg(figure)
        figure.suptitle("Parameters: fitted over declared")
        axes = figure.subplots()
        axes.axvline(1.0, color="black", linestyle="--", linewidth=1.0, label="declared")
        drawn = [[_over_declared(row, one) for one in _fits(row)[-len(sides) :]] for row in rows.values()]
        limits = _scaled(axes, [one for row in drawn for one in row])
        for place, row in enumerate(drawn):
            for (value, half, doubt), (said, colour, marker, shift) in zip(row, sides, strict=True):
                face = "white" if doubt else colour
                style: dict[str, Any] = {"color": colour, "markerfacecolor": face, "label": None if place else said}
                axes.plot(value, place + shift, marker, **style)
                _interval(axes, place + shift, (value - half, value + half), limits, colour)
        axes.plot([], [], "k>", linestyle="-", label="its interval goes on beyond the axis")
        axes.plot([], [], "ko", markerfacecolor="white", linestyle="", label="open: not identified")
        doubted = [name + (" (not identified)" if row.final.doubt else "") for name, row in rows.items()]
        axes.set_yticks(range(len(rows)), doubted)
        axes.set_ylim(len(rows) - 0.5, -0.5)
        axes.set_xlabel("fitted value over declared value")
        legend(figure, axes)
    caption = (
        "Each parameter that the fit may move, over its declared value, with its 95 % interval; autocorrelation of the "
        "residual is taken into account. An open marker is not identified: its standard deviation exceeds half its "
        "value, or the fit ran to the end of its range. The axis is chosen for the values; an arrow is an interval "
        "that goes on beyond it, or on a logarithmic axis to 0 and below."
    )
    return Picture(figure, caption)


def _fits(row: Row) -> list[Fitted]:
    return [row.final] if row.baseline is None else [row.baseline, row.final]


def _over_declared(row: Row, one: Fitted) -> tuple[float, float, str]:
    """Value and half an interval, over the declared value; why it is in doubt."""
    declared = row.declared or math.nan
    half = abs(INTERVAL * one.std / declared)
    return one.value / declared, half if math.isfinite(half) else 0.0, one.doubt


def _scaled(axes: Axes, drawn: Sequence[tuple[float, float, str]]) -> tuple[float, float]:
    """Choose the axis for the values, with their intervals as far as these are not much wider; return its ends."""
    values = [1.0, *(value for value, _, _ in drawn)]
    low, high = min(values), max(values)
    if low > 0.0 and high > WIDEST * low:
        ends = [end for value, half, _ in drawn for end in (value - half, value + half) if end > 0.0]
        left, right = max(min([low, *ends]), low / BEYOND) / 1.2, min(max([high, *ends]), high * BEYOND) * 1.2
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if right < FINE * left else (1.0,)))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter(NullFormatter())
    else:
        span = max(high - low, 0.1)
        ends = [end for value, half, _ in drawn for end in (value - half, value + half)]
        left = max(min([low, *ends]), low - BEYOND * span) - 0.1 * span
        right = min(max([high, *ends]), high + BEYOND * span) + 0.1 * span
    axes.set_xlim(left, right)
    return left, right


def _interval(axes: Axes, place: float, ends: tuple[float, float], limits: tuple[float, float], colour: str) -> None:
    """An interval within the axis; an arrow at an end that it goes beyond."""
    if ends[0] == ends[1]:
        return
    inside = max(ends[0], limits[0]), min(ends[1], limits[1])
    axes.plot(inside, (place, place), color=colour, zorder=1.8)
    for end, limit, beyond, arrow in (
        (ends[0], limits[0], ends[0] < limits[0], "<"),
        (ends[1], limits[1], ends[1] > limits[1], ">"),
    ):
        style: dict[str, Any] = {"color": colour, "clip_on": False} if beyond else {"color": colour}
        axes.plot(limit if beyond else end, place, arrow if beyond else "|", **style)
