"""The parameters of a diagnosis as a figure: fitted over declared, without and with what was found."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from workbench.diagnose.report.figures.frame import WIDE, Side, legend
from workbench.diagnose.report.parameters import parameter_rows
from workbench.diagnose.report.tables import INTERVAL
from workbench.diagnose.result import Diagnosis, FittedParameter
from workbench.publish.pictures import Picture
from workbench.publish.style import figure_style
from workbench.publish.words import plain_name

WIDEST = 4.0
"""Ratio of the largest value to the smallest from which the axis is logarithmic."""

BEYOND = 3.0
"""Factor, or on a linear axis ranges of the values, by which intervals widen the axis beyond the values at most."""

FINE = 100.0
"""Ratio of the axis's ends up to which it has ticks between powers of ten."""

MARKERS, SHIFT = {"before": "o", "after": "s"}, 0.14
"""Marker of each side, and the part of a row by which both stand off its middle."""


OPEN: Mapping[str, Any] = MappingProxyType({"linestyle": "", "markerfacecolor": "white"})
"""Style of a marker of what is not identified."""


@dataclass(frozen=True)
class RelativeFit:
    """A fitted value over the declared one, with half of its 95 % interval (0 where nobody knows it)."""

    value: float
    half: float
    identified: bool

    @property
    def ends(self) -> tuple[float, float]:
        """Of the interval."""
        return self.value - self.half, self.value + self.half


@dataclass(frozen=True)
class ParametersData:
    """Of each parameter by its label the relative fit of each side; None of one that did not move it."""

    sides: Sequence[Side]
    rows: Mapping[str, Sequence[RelativeFit | None]]


def parameters_data(diagnosis: Diagnosis) -> ParametersData | None:
    """The numbers of the figure; None where nothing that was declared was fitted."""
    sides = [Side("after", "declared plant, fitted")]
    if diagnosis.effects:
        last = "with what was rejected" if diagnosis.is_rejected else "with what was found"
        sides = [Side("before", "baseline: declared plant, fitted"), Side("after", last)]
    rows = {}
    for name, row in parameter_rows(diagnosis).items():
        if row.declared:
            fits = [row.baseline, row.final][-len(sides) :]
            label = name + (" (not identified)" if row.final.doubt else "")
            rows[label] = [None if fitted is None else _over_declared(row.declared, fitted) for fitted in fits]
    return ParametersData(sides, rows) if rows else None


def _over_declared(declared: float, fitted: FittedParameter) -> RelativeFit:
    half = abs(INTERVAL * fitted.std / declared)
    return RelativeFit(fitted.value / declared, half if math.isfinite(half) else 0.0, fitted.identified)


def draw_parameters(data: ParametersData) -> Picture:
    """The figure: fitted over declared values with 95 % intervals."""
    shifts = (0.0,) if len(data.sides) == 1 else (-SHIFT, SHIFT)
    with figure_style():
        figure = Figure(figsize=(WIDE, 0.38 * len(data.rows) + 1.5))
        FigureCanvasAgg(figure)
        figure.suptitle("Parameters: fitted over declared")
        axes = figure.subplots()
        axes.axvline(1.0, color="black", linestyle="--", linewidth=1.0, label="declared")
        limits = _scaled(axes, [fitted for row in data.rows.values() for fitted in row if fitted is not None])
        for side in data.sides:
            axes.plot([], [], MARKERS[side.key], color=side.colour, label=side.label)
        for place, row in enumerate(data.rows.values()):
            for fitted, side, shift in zip(row, data.sides, shifts, strict=True):
                if fitted is None:
                    continue
                face = side.colour if fitted.identified else "white"
                style: dict[str, Any] = {"color": side.colour, "markerfacecolor": face}
                axes.plot(fitted.value, place + shift, MARKERS[side.key], **style)
                _interval(axes, place + shift, fitted.ends, limits, side.colour)
        axes.plot([], [], "k>", linestyle="-", label="its interval goes on beyond the axis")
        axes.set_yticks(range(len(data.rows)), [plain_name(label) for label in data.rows])
        axes.set_ylim(len(data.rows) - 0.5, -0.5)
        axes.set_xlabel("fitted value over declared value")
        markers = [Line2D([], [], color=side.colour, marker=MARKERS[side.key], **OPEN) for side in data.sides]
        legend(figure, axes, more={"open: not identified": markers})
    caption = (
        "Each parameter that the fit may move, over its declared value, with its 95 % interval; what is declared as 0, "
        "as an effect's number is, stands in the table alone. Autocorrelation of the residual is taken into account. "
        "An open marker is not identified: its standard deviation exceeds half its value, the fit ran to the end of "
        "its range, or what was found moves it by more than it allows. The axis is chosen for the values; an arrow is "
        "an interval that goes on beyond it, or on a logarithmic axis to 0 and below."
    )
    return Picture(figure, caption)


def _scaled(axes: Axes, drawn: Sequence[RelativeFit]) -> tuple[float, float]:
    """Choose the axis for the values, with their intervals as far as these are not much wider; return its ends."""
    values = [1.0, *(fitted.value for fitted in drawn)]
    low, high = min(values), max(values)
    if low > 0.0 and high > WIDEST * low:
        ends = [end for fitted in drawn for end in fitted.ends if end > 0.0]
        left, right = max(min([low, *ends]), low / BEYOND) / 1.2, min(max([high, *ends]), high * BEYOND) * 1.2
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if right < FINE * left else (1.0,)))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter(NullFormatter())
    else:
        span = max(high - low, 0.1)
        ends = [end for fitted in drawn for end in fitted.ends]
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
