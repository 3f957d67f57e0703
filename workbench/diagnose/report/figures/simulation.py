"""What the simulated plant shows beside what was measured, without and with what was found."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.diagnose.report.figures.frame import WIDE, Side, legend
from workbench.diagnose.residuals.balance import SIMULATION
from workbench.diagnose.residuals.motion import Motion, fluctuation
from workbench.diagnose.result import Diagnosis, ErrorsByUse
from workbench.diagnose.simulation.stage import SimulationStage
from workbench.publish.along import SHOWN
from workbench.publish.pictures import Picture
from workbench.publish.style import COLOURS, REFERENCE, figure_style
from workbench.publish.thinning import thinned
from workbench.publish.words import plain_name
from workbench.toml.units import factor

MEASURED: dict[str, Any] = {**REFERENCE, "color": COLOURS[2], "alpha": 0.45}
NOISE: dict[str, Any] = {"color": "#999999", "alpha": 0.35, "linewidth": 0.0}
"""Green is measured, grey is noise."""

THICKNESS = {"before": 0.9, "after": 0.7}
"""Points of the curves."""

LAYER = {"before": 1.9, "after": 2.1}
"""Of the curves: what was measured, at 2, is drawn over what was before, and what came later over both."""

BUCKETS = 800
"""Of a curve, of which extremes are drawn: more than a page has columns of dots for it."""

MARGIN = 1.15
"""Of a panel beyond what it shows, on either side."""


@dataclass(frozen=True, eq=False)
class Compared:
    """One quantity along a record, in its unit: measured, simulated by each side, the noise of its sensor."""

    words: str
    unit: str
    measured: np.ndarray
    simulated: Mapping[str, np.ndarray]
    noise: float


@dataclass(frozen=True, eq=False)
class ComparedRecord:
    """A record over time (s), with the quantities that are compared along it."""

    use: str
    label: str
    time: np.ndarray
    quantities: Sequence[Compared]


@dataclass(frozen=True)
class SimulationData:
    """The records that are drawn, and the models beside them; what keeps these there, for a title, and how."""

    records: Sequence[ComparedRecord]
    sides: Sequence[Side]
    kept: str
    how: str


def simulation_data(diagnosis: Diagnosis, simulation: SimulationStage) -> SimulationData:
    """The numbers of the figure: measured and simulated along the first record of each use."""
    sides = [Side("after", "declared plant, fitted (nothing was added)")]
    if simulation.curved is not None:
        over = plain_name(simulation.curved.fitted.signal)
        sides = [Side("before", "declared plant, fitted"), Side("after", f"with a curve over {over}, not understood")]
    elif diagnosis.effects:
        after = "with what was rejected" if diagnosis.is_rejected else "after, with what was found"
        sides = [Side("before", "before: declared plant, fitted"), Side("after", after)]
    motions = [("fit", diagnosis.results[0].balance.motions[0], 0)]
    motions += [("held-out", motion, 1) for motion in diagnosis.held_out[:1]]
    records = [
        ComparedRecord(
            use,
            motion.record.label,
            motion.record.time,
            _compared(diagnosis, motion, {side.key: _shown(diagnosis.errors, side.key, place) for side in sides}),
        )
        for use, motion, place in motions
    ]
    return SimulationData(records, sides, *_kept(simulation))


def _shown(errors: ErrorsByUse, side: str, place: int) -> Mapping[str, np.ndarray]:
    """What the sensors would have shown of one side's model, along the first record of the fit, or of those held
    out.
    """
    if errors.with_curve is not None and side == "after":
        return errors.with_curve[place].shown
    run = (errors.fit, errors.held_out)[place]
    return (run.before if side == "before" else run.after).shown


def _kept(simulation: SimulationStage) -> tuple[str, str]:
    """What keeps a plant beside its records, for a title, and how, for a caption."""
    if simulation.is_beside:
        return (
            "and kept beside the record by a filter",
            "a filter corrects it by what it did not foresee of each position",
        )
    if simulation.loop is not None:
        loop = f"a loop of {simulation.loop:.2g} rad/s"
        return f"and led along the record by {loop}", f"a force on its mass by which {loop} leads it along the record"
    return "from the measured input alone", "nothing else, from the record's beginning to its end"


def _compared(
    diagnosis: Diagnosis, motion: Motion, simulated: Mapping[str, Mapping[str, np.ndarray]]
) -> list[Compared]:
    """Position, and the load pressure where both pressures are measured, and what is `simulated` by each side."""
    scale, unit = SHOWN[diagnosis.axis].factor, SHOWN[diagnosis.axis].unit
    shown = {side: scale * channels["position"] for side, channels in simulated.items()}
    measured = scale * motion.measured["position"]
    noise = _noise(scale * motion.sensed["position"], measured - shown["after"])
    quantities = [Compared("position", unit, measured, shown, noise)]
    if all({"pressure_1", "pressure_2"} <= set(channels) for channels in simulated.values()):
        scale = factor("Pa", "kPa")
        shown = {side: scale * _load_pressure(channels) for side, channels in simulated.items()}
        measured = scale * _load_pressure(motion.measured)
        sensed = scale * float(np.hypot(motion.sensed["pressure_1"], motion.sensed["pressure_2"]))
        quantities.append(Compared("load pressure", "kPa", measured, shown, _noise(sensed, measured - shown["after"])))
    return quantities


def _noise(sensed: float, error: np.ndarray) -> float:
    """Standard deviation of a sensor's noise: as its samples scatter, or, where the machine itself is as quick, as the
    error does that the plant leaves of them.
    """
    left = fluctuation(error[np.isfinite(error)])
    return min(sensed, left) if left > 0.0 else sensed


def _load_pressure(channels: Mapping[str, np.ndarray]) -> np.ndarray:
    return channels["pressure_1"] - channels["pressure_2"]


def draw_simulation(data: SimulationData) -> Picture:
    """The figure: of each record what was measured and simulated, and below the error of each side."""
    records, sides = data.records, data.sides
    columns, height = max(len(record.quantities) for record in records), 1 + len(sides)
    with figure_style():
        figure = Figure(figsize=(WIDE, 1.8 * height * len(records) + 0.8))
        FigureCanvasAgg(figure)
        figure.suptitle(f"Simulated {data.kept}, against measured")
        panels = figure.subplots(height * len(records), columns, squeeze=False)
        for row, record in enumerate(records):
            own = panels[height * row : height * (row + 1)]
            for column, compared in enumerate(record.quantities):
                _draw(own[:, column], record.time, compared, sides)
                title = f'{compared.words}, {record.use} record "{record.label}"'
                own[0, column].set_title(title, fontsize="small")
            for axes in own[:, len(record.quantities) :].flat:
                axes.set_visible(False)
        legend(figure, *panels[:height, 0])
    caption = (
        f"The plant gets the measured input, and {data.how}. "
        "Upper panels: what its sensors would have shown, over what they showed. Lower panels: the difference"
        + (", before and after on scales of their own" if len(sides) > 1 else "")
        + "; grey is the sensors' noise (two standard deviations). A curve that leaves its panel has run away."
    )
    return Picture(figure, caption, SIMULATION)


def _draw(panels: np.ndarray, time: np.ndarray, compared: Compared, sides: Sequence[Side]) -> None:
    """One quantity above, its error of each side below."""
    upper = panels[0]
    kept = thinned(compared.measured, buckets=BUCKETS)
    upper.plot(time[kept], compared.measured[kept], label="measured", **MEASURED)
    for axes, side in zip(panels[1:], sides, strict=True):
        values, width = compared.simulated[side.key], THICKNESS[side.key]
        error = compared.measured - values
        kept = thinned(values, error, buckets=BUCKETS)
        upper.plot(time[kept], values[kept], color=side.colour, linewidth=width, zorder=LAYER[side.key])
        axes.axhspan(-2.0 * compared.noise, 2.0 * compared.noise, label="noise (2 std)", **NOISE)
        axes.plot(time[kept], error[kept], color=side.colour, linewidth=width, label=side.label)
        most = float(np.nanquantile(np.abs(error), 0.995)) if np.isfinite(error).any() else 0.0
        limit = MARGIN * max(most, 3.0 * compared.noise)
        axes.set_ylim(-limit, limit)
        axes.set_ylabel(f"error{f', {side.key}' if len(sides) > 1 else ''} ({compared.unit})")
    low, high = np.min(compared.measured), np.max(compared.measured)
    middle, half = 0.5 * (low + high), 0.5 * MARGIN * max(high - low, 1e-12)
    upper.set_ylim(middle - half, middle + half)
    upper.set_ylabel(f"{compared.words} ({compared.unit})")
    for axes in panels:
        axes.set_xlabel("time (s)")
