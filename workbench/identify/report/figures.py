"""Figures of an identification: friction over velocity, simulated against measured, correlation."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.errors import UserError
from workbench.identify.report.published import scale_shown, unit_shown
from workbench.identify.result import Identification
from workbench.identify.simulation.method import SimulationFit
from workbench.identify.thesis.method import STATIC as STEADY
from workbench.identify.thesis.method import steady
from workbench.publish.style import COLOURS, PANEL_HEIGHT, REFERENCE, WIDTH, figure_style, line_style, marker
from workbench.records.friction import Slow, friction_of, is_rotary, slower
from workbench.records.reading import Record
from workbench.records.schema import STATIC, SUFFIXES, FigureTable

SHOWN = {
    "position": ("position", "mm", 1e3),
    "pressure_1": ("pressure 1", "kPa", 1e-3),
    "pressure_2": ("pressure 2", "kPa", 1e-3),
    "rotation_speed": ("rotation", "rad/s", 1.0),
    "motor_current": ("motor current", "A", 1.0),
}
"""Label, unit and factor of each output."""


def _figure(title: str, panels: int, height: float = 1.0) -> tuple[Figure, list[Axes]]:
    """A figure of panels above one another, each of `height` times the usual one."""
    figure = Figure(figsize=(WIDTH, height * PANEL_HEIGHT * panels + 0.4))
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    return figure, list(figure.subplots(panels, squeeze=False)[:, 0])


def requested_figures(identification: Identification) -> dict[str, Figure]:
    """The figures that the experiment names; without any, friction over velocity of all records.

    Raises:
        UserError: a figure at a speed of rotation that no record has.
    """
    specs = identification.experiment.figures
    if not specs:
        return {"friction_velocity": friction_figure(identification, "Friction over velocity", None)}
    figures = {}
    for spec in specs:
        if spec.parameter:
            figures[spec.name] = over_rpm_figure(identification, spec)
            continue
        speeds = sorted({record.rpm for record in identification.records})
        if spec.rpm not in speeds:
            shown = ", ".join(f"{rpm:g}" for rpm in speeds)
            raise UserError(
                f"{identification.experiment.path}: figures: {spec.name}: no record at {spec.rpm:g} rpm, "
                f"expected one of {shown}"
            )
        figures[spec.name] = friction_figure(identification, spec.title, spec.rpm)
    return figures


def friction_figure(identification: Identification, title: str, rpm: float | None) -> Figure:
    """Measured friction over velocity (10 Hz) against steady curves: both methods', the published, the true one."""
    records = [record for record in identification.records if rpm is None or record.rpm == rpm]
    rotary = all(is_rotary(record) for record in records)
    scale = 1.0 if rotary else 1e3
    with figure_style():
        figure, (axes,) = _figure(title, 1)
        fastest: dict[int, float] = {1: 0.0, -1: 0.0}
        for i, record in enumerate(records):
            data = _curve(identification, record)
            label = (
                None if i else f"{'measured' if identification.experiment.truth is None else 'simulated record'}, 10 Hz"
            )
            axes.plot(scale * data.velocity, data.force, ".", color="#999999", markersize=2.0, label=label)
            for sign in fastest:
                fastest[sign] = max(fastest[sign], float(np.nanmax(sign * data.velocity)))
        for source, values in _sets(identification, rpm).items():
            label = source
            for sign, speed in fastest.items():
                direction = "rotary" if rotary else "forward" if sign > 0 else "backward"
                drawn = _steady_curve(axes, values, direction, speed, source, label, scale)
                label = "" if drawn else label
        axes.set_xlabel("surface speed (m/s)" if rotary else "velocity (mm/s)")
        axes.set_ylabel("friction (N)")
        axes.legend(loc="best")
    return figure


STYLES = {name: line_style(i) for i, name in enumerate(("thesis's method", "simulation", "truth", "published"))}
"""One colour and dash for each source of a curve, in every figure."""

LEAST = 1e-3
"""m/s. A direction in which nothing moves faster has no curve."""


def _curve(identification: Identification, record: Record) -> Slow:
    known = identification.thesis.curves.get(str(record.path)) if identification.thesis is not None else None
    return known or slower(friction_of(record, identification.experiment))


def _sets(identification: Identification, rpm: float | None) -> dict[str, dict[str, float]]:
    """Friction by canonical name of each curve to be drawn, by its label."""
    experiment = identification.experiment
    sets: dict[str, dict[str, float]] = {}
    if identification.thesis is not None:
        group = identification.thesis.groups.get(rpm, {}) if rpm is not None else identification.thesis.estimates
        sets["thesis's method"] = {name: estimate.value for name, estimate in group.items()}
    if identification.simulation is not None:
        estimates = {name: fitted.value for name, fitted in identification.simulation.estimates.items()}
        sets["simulation"] = {**experiment.values, **estimates}
    if experiment.truth is not None and not rpm:
        sets["truth"] = dict(experiment.truth)
    published = _published(identification, rpm)
    if published:
        sets["published"] = published
    return sets


def _published(identification: Identification, rpm: float | None) -> dict[str, float]:
    """Printed friction at one speed by canonical name, Stribeck friction as static less Coulomb friction."""
    values: dict[str, float] = {}
    for spec in identification.experiment.published:
        if rpm not in spec.rpm:
            continue
        printed = {name: numbers[spec.rpm.index(rpm)] for name, numbers in spec.values.items()}
        if STATIC in printed and "coulomb" in printed:
            printed["stribeck"] = printed[STATIC] - printed["coulomb"]
        values |= {name + SUFFIXES[spec.direction]: value for name, value in printed.items()}
    return values


def _steady_curve(
    axes: Axes, values: dict[str, float], direction: str, speed: float, source: str, label: str, scale: float
) -> bool:
    """Draw the steady curve (4.7) up to `speed` (m/s), shown times `scale`; whether there is one."""
    fallback = {name: None if direction == "rotary" else values.get(name) for name in STEADY}
    chosen = [values.get(name + SUFFIXES[direction], fallback[name]) for name in STEADY]
    if chosen[STEADY.index("stribeck")] == 0.0:
        chosen[STEADY.index("stribeck_velocity")] = 1.0  # of no Stribeck friction any will do
    if speed < LEAST or any(value is None for value in chosen):
        return False
    sign = -1.0 if direction == "backward" else 1.0
    v = np.linspace(0.0, speed, 300)
    force = steady(v, *(float(value) for value in chosen if value is not None))
    axes.plot(scale * sign * v, sign * force, label=label or None, linewidth=1.2, **STYLES[source])
    return True


def over_rpm_figure(identification: Identification, spec: FigureTable) -> Figure:
    """One parameter over the speed of rotation: found with error bars of one standard deviation, published as crosses.

    The thesis's method only: without it there is nothing but the axes.
    """
    name = spec.parameter
    scale, groups = scale_shown(name), identification.thesis.groups if identification.thesis is not None else {}
    with figure_style():
        figure, (axes,) = _figure(spec.title, 1)
        for number, direction in enumerate(("forward", "backward")):
            own = {
                rpm: group[name + SUFFIXES[direction]]
                for rpm, group in groups.items()
                if name + SUFFIXES[direction] in group
            }
            shift = SHIFT * (2 * number - 1)
            axes.errorbar(
                [rpm + shift for rpm in own],
                [scale * estimate.value for estimate in own.values()],
                [scale * (estimate.std_of_repeats or 0.0) for estimate in own.values()],
                fmt=marker(number),
                color=COLOURS[number],
                capsize=2.0,
                clip_on=False,
                label=f"{direction}, found",
            )
            for table in identification.experiment.published:
                if table.direction == direction and name in table.values:
                    printed = [scale * value for value in table.values[name]]
                    axes.plot(
                        [rpm + shift for rpm in table.rpm],
                        printed,
                        "x+"[number],
                        color=COLOURS[number],
                        markersize=8.0,
                        clip_on=False,
                        label=f"{direction}, published",
                    )
        axes.set_xlabel("rotation (rpm)")
        what = name.replace("_", " ") + ("" if name in ("stribeck_velocity",) or "bristle" in name else " friction")
        axes.set_ylabel(f"{what} ({unit_shown(name)})")
        axes.set_ylim(bottom=0.0)
        axes.legend(loc="best")
    return figure


SHIFT = 0.8
"""rpm by which the points of the two directions stand apart."""


def record_figures(identification: Identification) -> dict[str, Figure]:
    """Of the first record of each label: each output simulated against measured, with the residual below."""
    fit = identification.simulation
    if fit is None:
        return {}
    figures: dict[str, Figure] = {}
    for record in identification.records:
        name = f"record_{''.join(c if c.isalnum() else '_' for c in record.label)}"
        if name in figures:
            continue
        path = str(record.path)
        time = fit.times[path]
        with figure_style():
            alike = [other for other in identification.records if other.label == record.label]
            which = f"{record.label}, record 1 of {len(alike)}" if len(alike) > 1 else record.label
            figure, panels = _figure(f"Simulated against measured\n{which}", 2 * len(fit.measured[path]), 0.55)
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
