"""Records against their simulation: each output simulated and measured, with the residual below."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from workbench.identify.report.figures.frame import panels_of
from workbench.identify.result import Identification
from workbench.identify.simulation.found import SimulationFit
from workbench.publish.along import SHOWN as ALONG
from workbench.publish.style import COLOURS, REFERENCE, figure_style

SHOWN = {
    "pressure_1": ("pressure 1", "kPa", 1e-3),
    "pressure_2": ("pressure 2", "kPa", 1e-3),
    "rotation_speed": ("rotation", "rad/s", 1.0),
    "motor_current": ("motor current", "A", 1.0),
}
"""Label, unit and factor of each output but the position."""


@dataclass(frozen=True, eq=False)
class Output:
    """One output over time, in the unit that is shown."""

    label: str
    unit: str
    measured: np.ndarray
    simulated: np.ndarray
    residual: np.ndarray


@dataclass(frozen=True, eq=False)
class SimulatedRecord:
    """A record, which of its label it is, and its outputs over `time` (s)."""

    name: str
    which: str
    time: np.ndarray
    outputs: Sequence[Output]


def simulated_data(identification: Identification, fit: SimulationFit) -> list[SimulatedRecord]:
    """The numbers of the figures, of the first record of each label."""
    chosen: dict[str, SimulatedRecord] = {}
    axis = identification.experiment.plant.axis
    for record in identification.records:
        name = f"record_{''.join(c if c.isalnum() else '_' for c in record.label)}"
        if name in chosen:
            continue
        alike = [other for other in identification.records if other.label == record.label]
        which = f"{record.name}, record 1 of {len(alike)}" if len(alike) > 1 else record.name
        outputs = [
            _output(output, measured, fit.simulated[record][output], axis)
            for output, measured in fit.measured[record].items()
        ]
        chosen[name] = SimulatedRecord(name, which, fit.times[record], outputs)
    return [*chosen.values()]


def _output(name: str, measured: np.ndarray, simulated: np.ndarray, axis: str) -> Output:
    along = ALONG[axis]
    label, unit, scale = ("position", along.unit, along.factor) if name == "position" else SHOWN[name]
    return Output(label, unit, scale * measured, scale * simulated, scale * (measured - simulated))


def draw_simulated(data: SimulatedRecord) -> Figure:
    """The figure of a record, two panels an output."""
    with figure_style():
        figure, panels = panels_of(2 * len(data.outputs), f"Simulated against measured\n{data.which}", 0.55)
        for i, output in enumerate(data.outputs):
            above, below = panels[2 * i], panels[2 * i + 1]
            above.plot(data.time, output.measured, color=REFERENCE["color"], label="measured")
            above.plot(data.time, output.simulated, color=COLOURS[0], linestyle="--", label="simulated")
            above.set_ylabel(f"{output.label} ({output.unit})")
            above.legend(loc="best")
            below.plot(data.time, output.residual, color=COLOURS[1], linewidth=0.6)
            below.set_ylabel(f"residual ({output.unit})")
            below.set_xlabel("time (s)")
    return figure
