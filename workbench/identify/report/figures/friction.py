"""Friction over velocity: what was measured, and the steady curves of both methods, the published and the true one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from workbench.identify.report.figures.frame import panels_of
from workbench.identify.result import Identification
from workbench.identify.thesis.method import STATIC as STEADY
from workbench.identify.thesis.method import steady
from workbench.publish.along import SHOWN
from workbench.publish.style import figure_style, line_style
from workbench.records.experiment import Experiment
from workbench.records.friction import Slow, friction_of, is_rotary, shows_friction, slower, why_no_friction
from workbench.records.reading import Record
from workbench.records.schema import STATIC, SUFFIXES

STYLES = {name: line_style(i) for i, name in enumerate(("thesis's method", "simulation", "truth", "published"))}
"""One colour and dash for each source of a curve, in every figure."""

LEAST = 1e-3
"""m/s. A direction in which nothing moves faster has no curve."""

CURVE_POINTS = 300


@dataclass(frozen=True, eq=False)
class SteadyCurve:
    """The steady curve of one source in one direction: velocity (m/s) and friction (N), with the direction's sign."""

    source: str
    velocity: np.ndarray
    force: np.ndarray


@dataclass(frozen=True, eq=False)
class FrictionOverVelocity:
    """What was measured, a record each, and the curves beside it; `rotary`: all of it around the rod.

    `simulated`: the records are made, and their truth is known. `lacking`: why nothing was measured; else empty.
    """

    measured: Sequence[Slow]
    curves: Sequence[SteadyCurve]
    rotary: bool
    simulated: bool
    axis: str
    lacking: str


def friction_data(identification: Identification, rpm: float | None) -> FrictionOverVelocity:
    """The numbers of the figure, of the records at one speed of rotation or (None) of all."""
    records = [record for record in identification.records if rpm is None or record.rpm == rpm]
    experiment, rotary = identification.experiment, all(is_rotary(record) for record in records)
    showing = [record for record in records if shows_friction(record)]
    measured = [_measured(identification, record) for record in showing if not why_no_friction(record, experiment)]
    forward, backward = (
        max((float(np.nanmax(sign * data.velocity)) for data in measured), default=0.0) for sign in (1.0, -1.0)
    )
    ways = (("rotary" if rotary else "forward", forward), ("rotary" if rotary else "backward", backward))
    drawn = (
        _steady_curve(source, values, *way) for source, values in _sets(identification, rpm).items() for way in ways
    )
    curves = [curve for curve in drawn if curve is not None]
    lacking = "" if measured else _why_none(showing, experiment)
    return FrictionOverVelocity(measured, curves, rotary, experiment.truth is not None, experiment.plant.axis, lacking)


def draw_friction(data: FrictionOverVelocity, title: str) -> Figure:
    """The figure."""
    along = SHOWN[data.axis]
    scale = 1.0 if data.rotary else along.factor
    with figure_style():
        figure, (axes,) = panels_of(1, title)
        what = f"{'simulated record' if data.simulated else 'measured'}, 10 Hz"
        for i, part in enumerate(data.measured):
            label = None if i else what
            axes.plot(scale * part.velocity, part.force, ".", color="#999999", markersize=2.0, label=label)
        for i, curve in enumerate(data.curves):
            label = None if i and data.curves[i - 1].source == curve.source else curve.source
            axes.plot(scale * curve.velocity, curve.force, label=label, linewidth=1.2, **STYLES[curve.source])
        axes.set_xlabel("surface speed (m/s)" if data.rotary else f"velocity ({along.speed_unit})")
        axes.set_ylabel(f"friction ({along.force_unit})")
        axes.legend(loc="best")
    return figure


def _measured(identification: Identification, record: Record) -> Slow:
    """What a record shows."""
    known = identification.thesis.curves.get(record) if identification.thesis is not None else None
    return known or slower(friction_of(record, identification.experiment))


def _why_none(showing: Sequence[Record], experiment: Experiment) -> str:
    """Why none of the records gives friction, of which these have channels that show it."""
    if not showing:
        return "no record shows friction, which takes both pressures or a force beside the position"
    return why_no_friction(max(showing, key=lambda record: record.time.size), experiment)


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


def _steady_curve(source: str, values: Mapping[str, float], direction: str, fastest: float) -> SteadyCurve | None:
    """The steady curve (4.7) up to `fastest` (m/s); None where nothing moves, or a number of it is not known."""
    fallback = {name: None if direction == "rotary" else values.get(name) for name in STEADY}
    chosen = [values.get(name + SUFFIXES[direction], fallback[name]) for name in STEADY]
    if chosen[STEADY.index("stribeck")] == 0.0:
        chosen[STEADY.index("stribeck_velocity")] = 1.0  # of no Stribeck friction any will do
    if fastest < LEAST or any(value is None for value in chosen):
        return None
    sign = -1.0 if direction == "backward" else 1.0
    speed = np.linspace(0.0, fastest, CURVE_POINTS)
    force = steady(speed, *(float(value) for value in chosen if value is not None))
    return SteadyCurve(source, sign * speed, sign * force)
