"""States at which simulations along a record start: what is measured there, and of the rest what goes with it."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from plants.equation import replaced
from plants.interface import Plant
from workbench.diagnose.residuals.flow import spool_of
from workbench.diagnose.residuals.force import driving_force
from workbench.diagnose.residuals.motion import Motion, with_backlash
from workbench.diagnose.residuals.unknowns import Values


def states_at(plant: Plant, parameters: Any, motion: Motion, values: Values, places: Sequence[int]) -> list[Any]:
    """The plant's states at instants of a motion: what is measured, and of the rest what goes with it."""
    rest, _ = plant.equilibrium(parameters, 0.0)
    moving = np.abs(motion.velocity) > motion.creep
    behind = with_backlash(motion, values.get("backlash_width", 0.0))
    known = {
        "position": behind.position,
        "velocity": np.where(moving, motion.velocity, 0.0),
        "lagged_velocity": np.where(moving, motion.velocity, 0.0),
        "rested": np.where(moving, 0.0, 1.0),
        "sensor_gap": motion.position - behind.position,
    }
    for name, offset in (("pressure_1", values.get("pressure_1_offset", 0.0)), ("pressure_2", 0.0)):
        if name in motion.channels:
            known[name] = motion.channels[name] - offset
    if motion.has("pressure_1", "pressure_2"):
        known["load_pressure"] = known["pressure_1"] - known["pressure_2"]
    if motion.voltage is not None:
        known["spool_position"] = spool_of(motion, values)[:: motion.thinning]
    driving = driving_force(motion, values)
    if driving is not None:
        held = driving - values["mass"] * motion.acceleration - values.get("load_force", 0.0)
        held = held - values.get("viscous", 0.0) * known["velocity"]
        most = values["coulomb"] + values.get("stribeck", 0.0)
        known["bristle_deflection"] = np.clip(held, -most, most) / values["bristle_stiffness"]
    return [replaced(rest, {name: float(series[k]) for name, series in known.items()}) for k in places]
