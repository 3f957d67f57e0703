"""Figures of measured friction-velocity curves against what the bristle laws predict: numbers, and what draws them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.friction_curves.comparison import Comparison, hydraulic_power, predicted_power
from workbench.friction_curves.measured import DIRECTIONS
from workbench.friction_curves.predicted import Prediction
from workbench.publish.style import REFERENCE, WIDTH, figure_style, line_style, marker

MM = 1e3


@dataclass(frozen=True, eq=False)
class CurvePanel:
    """One measured curve over speed (m/s), its friction (N), and that which each law predicts; `used`: for the fit?"""

    rpm: float
    used: str
    speed: np.ndarray
    measured: np.ndarray
    predicted: Mapping[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class Reductions:
    """Percent by which something falls, at each speed of rotation (rpm): as measured, then as each law predicts."""

    title: str
    rpm: Sequence[float]
    lines: Mapping[str, Sequence[float]]


def curves_data(found: Comparison, direction: str) -> list[CurvePanel]:
    """Of one direction, a panel for each speed of rotation."""
    panels = []
    for rpm in found.rpm:
        (curve,) = (one for one in found.curves([rpm]) if one.direction == direction)
        used = "fit" if rpm in found.spec.fit_rpm else "check" if rpm in found.spec.check_rpm else "not used"
        predicted = {law.name: law.curve(rpm, direction).friction for law in found.distinct}
        panels.append(CurvePanel(rpm, used, curve.speed, curve.friction, predicted))
    return panels


def draw_curves(data: Sequence[CurvePanel], direction: str) -> Figure:
    """Measured and predicted curves, a panel for each speed of rotation."""
    with figure_style():
        rows = (len(data) + 1) // 2
        figure = Figure(figsize=(WIDTH, 2.1 * rows + 0.7))
        FigureCanvasAgg(figure)
        figure.suptitle(f"Axial friction over axial velocity, {direction}")
        panels = figure.subplots(rows, 2, sharex=True, sharey=True, squeeze=False).ravel()
        for axes, each in zip(panels, data, strict=False):
            _draw_panel(axes, each)
        for axes in panels[len(data) :]:
            axes.set_visible(False)
        for axes in panels[max(len(data) - 2, 0) : len(data)]:
            axes.set_xlabel("axial velocity (mm/s)")
            axes.xaxis.set_tick_params(labelbottom=True)
        for axes in panels[::2]:
            axes.set_ylabel("axial friction (N)")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def _draw_panel(axes: Axes, data: CurvePanel) -> None:
    axes.plot(MM * data.speed, data.measured, label="measured", **REFERENCE)
    for number, (law, friction) in enumerate(data.predicted.items()):
        axes.plot(MM * data.speed, friction, label=law, **line_style(number))
    axes.set_title(f"{data.rpm:g} rpm ({data.used})")


def static_data(found: Comparison) -> Reductions:
    """Figure 5.10: average percent by which static friction falls."""
    return _reductions(
        found,
        "Average percent axial static friction reduction",
        sum(curve.static for curve in found.at_rest),
        lambda rpm: sum(curve.static for curve in found.curves([rpm])),
        lambda law, rpm: sum(law.curve(rpm, name).static for name in DIRECTIONS),
    )


def power_data(found: Comparison) -> Reductions:
    """Figure 5.21: percent by which hydraulic power falls at one speed along."""
    speed = found.spec.speed
    return _reductions(
        found,
        f"Percent reduction in hydraulic power (at {MM * speed:g} mm/s axially)",
        hydraulic_power([curve.at(speed) for curve in found.at_rest], speed),
        lambda rpm: hydraulic_power([curve.at(speed) for curve in found.curves([rpm])], speed),
        lambda law, rpm: predicted_power(law, rpm, speed)[0],
    )


def _reductions(
    found: Comparison,
    title: str,
    at_rest: float,
    measured: Callable[[float], float],
    predicted: Callable[[Prediction, float], float],
) -> Reductions:
    """What is `at_rest` without rotation, and measured and predicted at a speed of rotation."""
    turning = {"measured": [measured(rpm) for rpm in found.rpm]}
    turning |= {law.name: [predicted(law, rpm) for rpm in found.rpm] for law in found.distinct}
    lines = {name: [100.0 * (1.0 - value / at_rest) for value in values] for name, values in turning.items()}
    return Reductions(title, found.rpm, lines)


def draw_reductions(data: Reductions) -> Figure:
    """The figure against rpm."""
    with figure_style():
        figure = Figure(figsize=(WIDTH, 3.6))
        FigureCanvasAgg(figure)
        figure.suptitle(data.title)
        axes = figure.subplots()
        for number, (name, shown) in enumerate(data.lines.items()):
            style = dict(REFERENCE) if not number else line_style(number - 1)
            axes.plot(data.rpm, shown, label=name, marker="o" if not number else marker(number), **style)
        axes.set_xlabel("rotation (rpm)")
        axes.set_ylabel("reduction (%)")
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        axes.legend(loc="best")
    return figure
