"""Simulation from the measured input alone: what a plant makes of a record that it may not look at.

The plant starts at rest where the record begins, and the input is a straight line from sample to sample.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plants.interface import Plant
from plants.two_chamber import TWO_CHAMBER
from workbench.diagnose.fitting import Values
from workbench.errors import UserError
from workbench.identify.experiment import Experiment
from workbench.identify.model import observe
from workbench.identify.records import Record

BY_ANGLE = ("cosine_force", "sine_force")
"""Left out: what is simulated does not turn."""

SETTLED = 20
"""Samples at the beginning that are not counted."""


def simulated_by(experiment: Experiment) -> Plant:
    """The plant that holds the effects of the declared one: the one with two chambers for a valve's actuator."""
    return TWO_CHAMBER if experiment.plant.name == "non_rotating" else experiment.plant


def free_run(experiment: Experiment, records: Sequence[Record], values: Values) -> dict[str, float]:
    """Rms (SI) over records of measured less simulated position, and load pressure where both pressures are measured.

    Empty where the records hold no input of the plant, or the plant diverges on one of them.
    """
    plant = simulated_by(experiment)
    known = {name: value for name, value in values.items() if name not in BY_ANGLE}
    believed = replace(experiment, plant=plant, values=known)
    squares: dict[str, list[np.ndarray]] = {}
    for record in records:
        try:
            observed = observe(record, believed)
        except UserError:
            return {}
        predicted = observed.predicted(believed, {})
        if predicted is None:
            return {}
        skip = max(round(SETTLED / observed.count), 1)
        errors = {name: (values_of - predicted[name])[skip:] for name, values_of in observed.measured.items()}
        if "position" in errors:
            squares.setdefault("position_rms_m", []).append(errors["position"] ** 2)
        if "pressure_1" in errors and "pressure_2" in errors:
            squares.setdefault("load_pressure_rms_Pa", []).append((errors["pressure_1"] - errors["pressure_2"]) ** 2)
    return {name: float(np.sqrt(np.nanmean(np.concatenate(parts)))) for name, parts in squares.items()}
