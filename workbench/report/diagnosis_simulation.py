"""What the simulated plant shows beside what was measured, without and with what was found."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.diagnose.diagnose import Diagnosis
from workbench.diagnose.motion import Motion
from workbench.diagnose.shooting import set_up
from workbench.diagnose.simulated import Simulated
from workbench.report.diagnosis_evidence import AFTER, BEFORE, WIDE, Picture, legend
from workbench.report.diagnosis_words import REJECTED
from workbench.report.style import REFERENCE, figure_style
from workbench.units import factor

MARGIN = 1.15
"""Of a panel beyond what it shows, on either side."""


@dataclass(frozen=True, eq=False)
class _Shown:
    """One quantity along a record, in its unit: measured, simulated before and after, the noise of its sensor."""

    words: str
    unit: str
    measured: np.ndarray
    before: np.ndarray
    after: np.ndarray
    noise: float


def simulated_against_measured(found: Diagnosis, simulated: Simulated) -> Picture:
    """Measured and simulated, and the error of both, along the first record of each use."""
    records = [("fit", found.results[0].balance.motions[0]), *(("held-out", one) for one in found.held_out[:1])]
    rows = [(use, motion, _shown(found, simulated, motion)) for use, motion in records]
    columns = max(len(shown) for _, _, shown in rows)
    last = "with what was rejected" if found.report["verdict"] == REJECTED else "after, with what was found"
    if not found.found:
        last = "declared plant, fitted (nothing was added)"
    with figure_style():
        figure = Figure(figsize=(WIDE, 3.6 * len(rows) + 0.8))
        FigureCanvasAgg(figure)
        figure.suptitle("Simulated from the measured input alone, against measured")
        panels = figure.subplots(2 * len(rows), columns, squeeze=False)
        for row, (use, motion, shown) in enumerate(rows):
            for column, one in enumerate(shown):
                upper, lower = panels[2 * row, column], panels[2 * row + 1, column]
                _draw(upper, lower, motion.record.time, one, last, bool(found.found))
                upper.set_title(f'{one.words}, {use} record "{motion.record.label}"', fontsize="small")
            for axes in panels[2 * row : 2 * row + 2, len(shown) :].flat:
                axes.set_visible(False)
        legend(figure, panels[1, 0])
    caption = (
        "The plant gets the measured input and nothing else, from the record's beginning to its end. Upper panels: "
        "what its sensors would have shown, over what they showed. Lower panels: the difference; grey is the sensors' "
        "noise (two standard deviations). A curve that leaves its panel has run away."
    )
    return Picture(figure, caption, "simulation")


def _shown(found: Diagnosis, simulated: Simulated, motion: Motion) -> list[_Shown]:
    """Position, and the load pressure where both pressures are measured."""
    whole = set_up(found.experiment, [motion], held=simulated.how.held)
    assert whole is not None  # the diagnosis has simulated such records
    sides = [whole.simulated(motion, one.values) for one in (simulated.before, simulated.after)]
    channels = [motion.measured, *sides]
    measured, before, after = (factor("m", "mm") * one["position"] for one in channels)
    out = [_Shown("position", "mm", measured, before, after, factor("m", "mm") * motion.noise["position"])]
    if {"pressure_1", "pressure_2"} <= set(sides[0]):
        measured, before, after = (factor("Pa", "kPa") * (one["pressure_1"] - one["pressure_2"]) for one in channels)
        noise = float(np.hypot(motion.noise["pressure_1"], motion.noise["pressure_2"]))
        out.append(_Shown("load pressure", "kPa", measured, before, after, factor("Pa", "kPa") * noise))
    return out


def _draw(upper: Axes, lower: Axes, time: np.ndarray, one: _Shown, last: str, several: bool) -> None:
    sides = [("before: declared plant, fitted", one.before, BEFORE, 0.9), (last, one.after, AFTER, 0.7)]
    upper.plot(time, one.measured, label="measured", **REFERENCE)
    lower.plot([], [], label="measured", **REFERENCE)
    lower.axhspan(-2.0 * one.noise, 2.0 * one.noise, color="#999999", alpha=0.35, linewidth=0.0, label="noise (2 std)")
    for label, values, colour, width in sides if several else sides[1:]:
        upper.plot(time, values, color=colour, linewidth=width, rasterized=True)
        lower.plot(time, one.measured - values, color=colour, linewidth=width, label=label, rasterized=True)
    low, high = np.min(one.measured), np.max(one.measured)
    middle, half = 0.5 * (low + high), 0.5 * MARGIN * max(high - low, 1e-12)
    upper.set_ylim(middle - half, middle + half)
    upper.set_ylabel(f"{one.words} ({one.unit})")
    lower.set_ylabel(f"error ({one.unit})")
    errors = [np.abs(one.measured - values) for _, values, _, _ in sides]
    most = max(float(np.nanquantile(error, 0.995)) for error in errors if np.isfinite(error).any())
    lower.set_ylim(-MARGIN * max(most, 3.0 * one.noise), MARGIN * max(most, 3.0 * one.noise))
    for axes in (upper, lower):
        axes.set_xlabel("time (s)")
