"""What the simulated plant shows beside what was measured, without and with what was found."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.diagnose.diagnose import Diagnosis
from workbench.diagnose.report.evidence import AFTER, BEFORE, WIDE, Picture, legend
from workbench.diagnose.report.names import REJECTED
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.simulation.shooting import set_up
from workbench.diagnose.simulation.simulated import Simulated
from workbench.publish.style import COLOURS, REFERENCE, figure_style
from workbench.toml.units import factor

MEASURED: dict[str, Any] = {**REFERENCE, "color": COLOURS[2], "alpha": 0.45}
NOISE: dict[str, Any] = {"color": "#999999", "alpha": 0.35, "linewidth": 0.0}
"""Green is measured, grey is noise."""

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
    sides = [("before", "before: declared plant, fitted", BEFORE, 0.9)] if found.found else []
    sides.append(("after", last, AFTER, 0.7))
    height = 1 + len(sides)
    with figure_style():
        figure = Figure(figsize=(WIDE, 1.8 * height * len(rows) + 0.8))
        FigureCanvasAgg(figure)
        figure.suptitle("Simulated from the measured input alone, against measured")
        panels = figure.subplots(height * len(rows), columns, squeeze=False)
        for row, (use, motion, shown) in enumerate(rows):
            own = panels[height * row : height * (row + 1)]
            for column, one in enumerate(shown):
                _draw(own[:, column], motion.record.time, one, sides)
                own[0, column].set_title(f'{one.words}, {use} record "{motion.record.label}"', fontsize="small")
            for axes in own[:, len(shown) :].flat:
                axes.set_visible(False)
        legend(figure, *panels[:height, 0])
    caption = (
        "The plant gets the measured input and nothing else, from the record's beginning to its end. Upper panels: "
        "what its sensors would have shown, over what they showed. Lower panels: the difference"
        + (", before and after on scales of their own" if found.found else "")
        + "; grey is the sensors' noise (two standard deviations). A curve that leaves its panel has run away."
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


def _draw(panels: np.ndarray, time: np.ndarray, one: _Shown, sides: Sequence[tuple[str, str, str, float]]) -> None:
    """What was measured and simulated, and below the error of each side."""
    upper = panels[0]
    upper.plot(time, one.measured, label="measured", **MEASURED)
    for axes, (side, label, colour, width) in zip(panels[1:], sides, strict=True):
        values = getattr(one, side)
        error = one.measured - values
        upper.plot(time, values, color=colour, linewidth=width, rasterized=True)
        axes.axhspan(-2.0 * one.noise, 2.0 * one.noise, label="noise (2 std)", **NOISE)
        axes.plot(time, error, color=colour, linewidth=width, label=label, rasterized=True)
        most = float(np.nanquantile(np.abs(error), 0.995)) if np.isfinite(error).any() else 0.0
        axes.set_ylim(-MARGIN * max(most, 3.0 * one.noise), MARGIN * max(most, 3.0 * one.noise))
        axes.set_ylabel(f"error{f', {side}' if len(sides) > 1 else ''} ({one.unit})")
    low, high = np.min(one.measured), np.max(one.measured)
    middle, half = 0.5 * (low + high), 0.5 * MARGIN * max(high - low, 1e-12)
    upper.set_ylim(middle - half, middle + half)
    upper.set_ylabel(f"{one.words} ({one.unit})")
    for axes in panels:
        axes.set_xlabel("time (s)")
