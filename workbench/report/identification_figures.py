"""Figures of an identification: friction over velocity, simulated against measured, correlation."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.identify.friction_records import friction_of
from workbench.identify.identification import Identification
from workbench.identify.simulation_method import SimulationFit
from workbench.identify.thesis_method import STATIC, Slow, slower, steady
from workbench.report.style import COLOURS, DASHES, PANEL_HEIGHT, REFERENCE, WIDTH, figure_style

SHOWN = {
    "position": ("position", "mm", 1e3),
    "pressure_1": ("pressure 1", "kPa", 1e-3),
    "pressure_2": ("pressure 2", "kPa", 1e-3),
    "rotation_speed": ("rotation", "rad/s", 1.0),
}
"""Label, unit and factor of each output."""


def _figure(title: str, panels: int) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(WIDTH, PANEL_HEIGHT * panels + 0.4))
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    return figure, list(figure.subplots(panels, squeeze=False)[:, 0])


def friction_figure(found: Identification) -> Figure:
    """Measured friction over velocity (10 Hz) against the steady curves of both methods, and the truth where known."""
    experiment = found.experiment
    with figure_style():
        figure, (axes,) = _figure("Friction over velocity", 1)
        curves = found.thesis.curves if found.thesis is not None else _curves(found)
        fastest: dict[int, float] = {1: 0.0, -1: 0.0}
        for i, data in enumerate(curves.values()):
            label = None if i else "measured, 10 Hz"
            axes.plot(1e3 * data.velocity, data.force, ".", color=REFERENCE["color"], markersize=2.0, label=label)
            for sign in fastest:
                fastest[sign] = max(fastest[sign], float(np.nanmax(sign * data.velocity)))
        sets = [("thesis's method", {n: e.value for n, e in found.thesis.estimates.items()})] if found.thesis else []
        if found.simulation is not None:
            sets.append(
                ("simulation", {**experiment.values, **{n: e.value for n, e in found.simulation.estimates.items()}})
            )
        if experiment.truth is not None:
            sets.append(("truth", dict(experiment.truth)))
        for number, (label, values) in enumerate(sets):
            for sign, speed in fastest.items():
                _steady_curve(axes, values, sign, speed, number, label if sign > 0 or fastest[1] < LEAST else "")
        axes.set_xlabel("velocity (mm/s)")
        axes.set_ylabel("friction (N)")
        axes.legend(loc="best")
    return figure


LEAST = 1e-3
"""m/s. A direction in which nothing moves faster has no curve."""


def _curves(found: Identification) -> dict[str, Slow]:
    return {str(record.path): slower(friction_of(record, found.experiment)) for record in found.records}


def _steady_curve(axes: Axes, values: dict[str, float], sign: int, speed: float, number: int, label: str) -> None:
    chosen = [values.get(name if sign > 0 else f"{name}_negative", values.get(name)) for name in STATIC]
    if speed < LEAST or any(value is None for value in chosen):
        return
    v = np.linspace(0.0, speed, 300)
    force = steady(v, *(float(value) for value in chosen if value is not None))
    axes.plot(
        1e3 * sign * v,
        sign * force,
        color=COLOURS[number],
        linestyle=DASHES[number],
        label=label or None,
        linewidth=1.2,
    )


def record_figures(found: Identification) -> dict[str, Figure]:
    """Of the first record of each label: each output simulated against measured, with the residual below."""
    fit = found.simulation
    if fit is None:
        return {}
    figures: dict[str, Figure] = {}
    for record in found.records:
        name = f"record_{''.join(c if c.isalnum() else '_' for c in record.label)}"
        if name in figures:
            continue
        path = str(record.path)
        time = fit.times[path]
        with figure_style():
            figure, panels = _figure(f"Simulated against measured: {record.label}", 2 * len(fit.measured[path]))
            for i, (output, measured) in enumerate(fit.measured[path].items()):
                label, unit, scale = SHOWN[output]
                simulated = fit.simulated[path][output]
                above, below = panels[2 * i], panels[2 * i + 1]
                above.plot(time, scale * measured, color=REFERENCE["color"], label="measured")
                above.plot(
                    time,
                    scale * simulated,
                    color=COLOURS[0],
                    linestyle="--",
                    label="simulated",
                )
                above.set_ylabel(f"{label} ({unit})")
                above.legend(loc="best")
                below.plot(time, scale * (measured - simulated), color=COLOURS[1], linewidth=0.6)
                below.set_ylabel(f"residual ({unit})")
                below.set_xlabel("time (s)")
        figures[name] = figure
    return figures


def correlation_figure(fit: SimulationFit) -> Figure:
    """Correlation of the estimates, as numbers on colours."""
    names = list(fit.estimates)
    with figure_style():
        figure = Figure(figsize=(WIDTH, WIDTH))
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        image = axes.imshow(fit.correlation, vmin=-1.0, vmax=1.0, cmap="RdBu_r")
        axes.set_xticks(range(len(names)), names, rotation=90)
        axes.set_yticks(range(len(names)), names)
        axes.grid(visible=False)
        for i, row in enumerate(fit.correlation):
            for j, value in enumerate(row):
                axes.text(
                    j, i, f"{value:.2f}", ha="center", va="center", fontsize=6, color="w" if abs(value) > 0.6 else "k"
                )
        figure.colorbar(image, shrink=0.7, label="correlation")
        axes.set_title("Correlation of the estimates")
    return figure
