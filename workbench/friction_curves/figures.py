"""Figures of measured friction-velocity curves against what the bristle laws predict."""

from collections.abc import Callable

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.friction_curves.comparison import Comparison, hydraulic_power, predicted_power
from workbench.friction_curves.measured import DIRECTIONS, Curve
from workbench.friction_curves.predicted import Prediction
from workbench.publish.style import REFERENCE, WIDTH, figure_style, line_style, marker

MM = 1e3


def curves_figure(found: Comparison, direction: str) -> Figure:
    """Measured and predicted curves, a panel for each speed of rotation."""
    with figure_style():
        rows = (len(found.rpm) + 1) // 2
        figure = Figure(figsize=(WIDTH, 2.1 * rows + 0.7))
        FigureCanvasAgg(figure)
        figure.suptitle(f"Axial friction over axial velocity, {direction}")
        panels = figure.subplots(rows, 2, sharex=True, sharey=True, squeeze=False).ravel()
        for axes, rpm in zip(panels, found.rpm, strict=False):
            (curve,) = (one for one in found.curves([rpm]) if one.direction == direction)
            _curve_panel(axes, found, curve)
        for axes in panels[len(found.rpm) :]:
            axes.set_visible(False)
        for axes in panels[max(len(found.rpm) - 2, 0) : len(found.rpm)]:
            axes.set_xlabel("axial velocity (mm/s)")
            axes.xaxis.set_tick_params(labelbottom=True)
        for axes in panels[::2]:
            axes.set_ylabel("axial friction (N)")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def _curve_panel(axes: Axes, found: Comparison, curve: Curve) -> None:
    axes.plot(MM * curve.speed, curve.friction, label="measured", **REFERENCE)
    for number, law in enumerate(found.distinct):
        predicted = law.curve(curve.rpm, curve.direction).friction
        axes.plot(MM * curve.speed, predicted, label=law.name, **line_style(number))
    used = "fit" if curve.rpm in found.spec.fit_rpm else "check" if curve.rpm in found.spec.check_rpm else "not used"
    axes.set_title(f"{curve.rpm:g} rpm ({used})")


def _over_rpm(found: Comparison, title: str, label: str, figures: dict[str, Callable[[float], float]]) -> Figure:
    """Figures against rpm; the first is the measured one."""
    with figure_style():
        figure = Figure(figsize=(WIDTH, 3.6))
        FigureCanvasAgg(figure)
        figure.suptitle(title)
        axes = figure.subplots()
        for number, (name, value) in enumerate(figures.items()):
            style = dict(REFERENCE) if not number else line_style(number - 1)
            shown = [value(rpm) for rpm in found.rpm]
            axes.plot(found.rpm, shown, label=name, marker="o" if not number else marker(number), **style)
        axes.set_xlabel("rotation (rpm)")
        axes.set_ylabel(label)
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        axes.legend(loc="best")
    return figure


def static_figure(found: Comparison) -> Figure:
    """Figure 5.10: average percent by which static friction falls."""
    before = sum(curve.static for curve in found.at_rest)

    def measured(rpm: float) -> float:
        return 100.0 * (1.0 - sum(curve.static for curve in found.curves([rpm])) / before)

    def predicted(law: Prediction) -> Callable[[float], float]:
        return lambda rpm: 100.0 * (1.0 - sum(law.curve(rpm, name).static for name in DIRECTIONS) / before)

    figures = {"measured": measured, **{law.name: predicted(law) for law in found.distinct}}
    return _over_rpm(found, "Average percent axial static friction reduction", "reduction (%)", figures)


def power_figure(found: Comparison) -> Figure:
    """Figure 5.21: percent by which hydraulic power falls at one speed along."""
    speed = found.spec.speed
    before = hydraulic_power([curve.at(speed) for curve in found.at_rest], speed)

    def measured(rpm: float) -> float:
        return 100.0 * (1.0 - hydraulic_power([curve.at(speed) for curve in found.curves([rpm])], speed) / before)

    def predicted(law: Prediction) -> Callable[[float], float]:
        return lambda rpm: 100.0 * (1.0 - predicted_power(law, rpm, speed)[0] / before)

    figures = {"measured": measured, **{law.name: predicted(law) for law in found.distinct}}
    title = f"Percent reduction in hydraulic power (at {MM * speed:g} mm/s axially)"
    return _over_rpm(found, title, "reduction (%)", figures)
