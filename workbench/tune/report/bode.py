"""Bode plots of a controller's linearised loop before and after tuning, with its margins."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from workbench.errors import UserError
from workbench.linear.margins import Response
from workbench.linear.open_loop import Margins, margins, open_loop
from workbench.publish.along import SHOWN
from workbench.publish.style import LineStyle, figure_style
from workbench.simulation.simulate import Setup
from workbench.study.resolve import Resolved
from workbench.tune.objective import SLOW, fastest
from workbench.tune.report.panels import SIDES, Picture, grid, legend
from workbench.tune.result import ControllerTuning
from workbench.tune.schema import ConstraintsTable, tune_table

POINTS = 4000
BELOW = 0.02
"""Of the lowest crossing: where the frequency axis begins."""

UNCROSSED = 0.1
"""Of the Nyquist frequency: what stands for the crossing of a loop that has none."""

LABEL = 90
"""Letters in a line of the legend."""

SMALLEST = 1e-9
"""Amplitude below which none is drawn."""

HALF_TURN = 180.0


@dataclass(frozen=True, eq=False)
class Curve:
    """L over frequency (rad/s): dB and degrees, the phase without jumps from about -90; empty without a loop."""

    frequency: np.ndarray
    amplitude: np.ndarray
    phase: np.ndarray
    margins: Margins


def curve_of(setup: Setup, smallest: Margins, lowest: float) -> Curve:
    """The loop of `setup` with these `smallest` margins, at the speed of these, from `lowest` (rad/s) to Nyquist."""
    try:
        loop = open_loop(setup, smallest.speed)
    except UserError:
        return Curve(np.empty(0), np.empty(0), np.empty(0), smallest)
    frequency = np.geomspace(lowest, np.pi / setup.sample_time, POINTS)
    values = Response(loop.A, loop.B, loop.C, setup.sample_time)(frequency)
    phase = np.unwrap(np.angle(values, deg=True), period=2.0 * HALF_TURN)
    phase -= 2.0 * HALF_TURN * np.round((phase[0] + 0.5 * HALF_TURN) / (2.0 * HALF_TURN))
    return Curve(frequency, 20.0 * np.log10(np.maximum(np.abs(values), SMALLEST)), phase, smallest)


def lowest_frequency(every: Iterable[Margins], sample_time: float) -> float:
    """Where the axis of loops begins (rad/s): well below their lowest crossing."""
    crossings = [at for each in every for at in (each.gain_frequency, each.phase_frequency) if np.isfinite(at)]
    return BELOW * min([*crossings, UNCROSSED * np.pi / sample_time])


def sets_margins(cases: Sequence[Resolved], constraints: ConstraintsTable) -> tuple[int, float]:
    """The case with the smallest phase margin, and the speed (m/s) at which its loop is linearised."""
    speeds = [constraints.margin_speed or fastest(case) or SLOW for case in cases]
    smallest = [margins(case.setup, speed) for case, speed in zip(cases, speeds, strict=True)]
    number = min(range(len(cases)), key=lambda i: (smallest[i].stable, smallest[i].phase_deg))
    return number, speeds[number]


@dataclass(frozen=True, eq=False)
class BodeData:
    """The numbers of the figure of a controller: its loop before and after tuning, slid at a speed (m/s)."""

    label: str
    axis: str
    speed: float
    curves: Mapping[str, Curve]


def bode_data(tuned: ControllerTuning) -> BodeData:
    """The loops of a controller in the case with the smallest phase margin."""
    constraints = tune_table(tuned.task.study).constraints
    points = {"before": tuned.task.start, **({} if tuned.best is None else {"after": tuned.best})}
    number, speed = sets_margins(tuned.task.declared(points[list(points)[-1]]), constraints)
    setups = {when: tuned.task.declared(point)[number].setup for when, point in points.items()}
    smallest = {when: margins(setup, speed) for when, setup in setups.items()}
    lowest = lowest_frequency(smallest.values(), setups["before"].sample_time)
    curves = {when: curve_of(setup, smallest[when], lowest) for when, setup in setups.items()}
    return BodeData(tuned.task.label, tuned.task.axis, speed, curves)


def bode_picture(tuned: ControllerTuning) -> Picture | str:
    """Amplitude and phase of a controller's loop, before and after; or why there is nothing to draw."""
    data = bode_data(tuned)
    if not any(curve.frequency.size for curve in data.curves.values()):
        note = data.curves[list(data.curves)[-1]].margins.note
        return f"No loop of {data.label}: at {SHOWN[data.axis].speed(data.speed, 3)} {note}."
    with figure_style():
        figure, panels = grid(2, 1, f"{data.label}: loop before and after", 2.3, sharex="all")
        amplitude, phase = panels[:, 0]
        for when, curve in data.curves.items():
            _draw(amplitude, phase, curve, SIDES[when].copy())
        amplitude.axhline(0.0, color="#666666", linewidth=0.8)
        _half_turns(phase)
        amplitude.set_ylabel("amplitude (dB)")
        phase.set_ylabel("phase (deg)")
        phase.set_xlabel("frequency (rad/s), up to the Nyquist frequency")
        amplitude.set_xscale("log")
        legend(figure, [amplitude], 1)
    return Picture(figure, _caption(data))


def _draw(amplitude: Axes, phase: Axes, curve: Curve, style: LineStyle) -> None:
    """A loop and its margins: from the curve to 0 dB and to -180 degrees."""
    label = "\n".join(wrap(f"{style.pop('label')}: {_words(curve)}", LABEL))
    amplitude.plot(curve.frequency, curve.amplitude, label=label, **style)
    phase.plot(curve.frequency, curve.phase, **style)
    marked: dict[str, Any] = {"color": style["color"], "linewidth": 2.5, "alpha": 0.6, "solid_capstyle": "butt"}
    dotted: dict[str, Any] = {"color": style["color"], "linewidth": 0.7, "linestyle": ":"}
    at = curve.margins.gain_frequency
    if curve.frequency.size and np.isfinite(at):
        level = float(np.interp(at, curve.frequency, curve.amplitude))
        amplitude.plot([at, at], [level, 0.0], **marked)
        for axes in (amplitude, phase):
            axes.axvline(at, **dotted)
    at = curve.margins.phase_frequency
    if curve.frequency.size and np.isfinite(at):
        angle = float(np.interp(at, curve.frequency, curve.phase))
        phase.plot([at, at], [angle, _nearest_half_turn(angle)], **marked)
        for axes in (amplitude, phase):
            axes.axvline(at, **dotted)


def _nearest_half_turn(angle: float) -> float:
    """The angle of -1 (-180, or a whole turn from it) that is nearest."""
    return float(2.0 * HALF_TURN * np.round((angle + HALF_TURN) / (2.0 * HALF_TURN)) - HALF_TURN)


def _half_turns(axes: Axes) -> None:
    """Lines where L has the angle of -1, and ticks at quarter turns."""
    low, high = axes.get_ylim()
    low, high = min(low, -HALF_TURN - 15.0), max(high, -45.0)
    for turn in range(int(low // 360.0) - 1, int(high // 360.0) + 2):
        if low <= 360.0 * turn - HALF_TURN <= high:
            axes.axhline(360.0 * turn - HALF_TURN, color="#666666", linewidth=0.8)
    step = 45.0 if high - low < 400.0 else 90.0 if high - low < 1000.0 else 360.0
    axes.set_yticks(np.arange(np.ceil(low / step), np.floor(high / step) + 1.0) * step)
    axes.set_ylim(low, high)


def _words(curve: Curve) -> str:
    smallest = curve.margins
    if not curve.frequency.size:
        return f"no loop to linearise, {smallest.note}"
    gain = f"gain margin {smallest.gain_dB:.1f} dB" if np.isfinite(smallest.gain_dB) else "no gain crossing"
    phase = f"phase margin {smallest.phase_deg:.1f} deg" if np.isfinite(smallest.phase_deg) else "no phase crossing"
    return f"{gain}, {phase}" + ("" if smallest.stable else ", unstable")


def _caption(data: BodeData) -> str:
    speed = SHOWN[data.axis].speed(data.speed, 3)
    words = "; ".join(f"{when}: {_words(curve)}" for when, curve in data.curves.items())
    return (
        f"Loop L of {data.label}, linearised while the rod slides at {speed}, in the case with the "
        f"smallest phase margin. Thick bars are the margins: gain from the curve to 0 dB, phase from the curve to -180 "
        f"deg ({words}). The table has the smallest margins over all cases."
    )
