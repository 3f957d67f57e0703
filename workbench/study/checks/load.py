"""What may be meant of a machine at rest, and seldom is: a load, or a leak, that nothing holds."""

from typing import Any

import numpy as np

from plants.axis import name_along, unit_along
from plants.equation import fields, to_array
from plants.interface import Plant

HELD = 1e-6
"""Share of the load that may be left at rest, as a force: an equilibrium is found to so many digits."""

STANDS = 1e-9
"""m/s^2, or rad/s^2, of what counts as standing."""

LEAST_RATE = 1e-3
"""1/s: of its typical magnitude, by which a pressure at rest may change."""


def unheld(plant: Plant, parameters: Any) -> str | None:
    """Why a machine does not stay at rest where it starts, in words; None where it does."""
    body = getattr(parameters, "body", None)
    if body is None:
        return None
    with np.errstate(all="ignore"):
        state, inputs = plant.equilibrium(parameters, 0.0)
        rates = plant.derivatives(0.0, state, inputs, parameters)
    if not np.all(np.isfinite(to_array(rates))):
        return "its rates at rest are no numbers: expected nothing to be 0 that something is divided by, such as a mass"
    name, unit = name_along("load_force", plant.axis), unit_along("N", plant.axis)
    lacking = abs(body.mass * rates.velocity)
    if body.load_force and abs(rates.velocity) > STANDS and lacking > HELD * abs(body.load_force):
        return (
            f"{name} = {body.load_force:.4g} {unit} is {lacking:.4g} {unit} more than the actuator holds: the run "
            "begins with all the pressure that there is; expected less load, or more supply_pressure or area"
        )
    asked, limit = abs(to_array(inputs)[plant.input_index(plant.command)]), plant.command_limit(parameters)
    if asked > limit * (1.0 + HELD):
        return (
            f"to hold {name} = {body.load_force:.4g} {unit} takes {asked:.4g} {plant.command_unit} of {plant.command}, "
            f"beyond its limit of {limit:.4g}: the machine does not stay at rest; expected less load, or less leakage"
        )
    for item in fields(plant.State):
        if item.unit == "Pa" and abs(rate := getattr(rates, item.name)) > LEAST_RATE * item.scale:
            return (
                f"{item.name} changes by {rate:.3g} Pa/s at rest: the valve, wide open, does not make good what leaks, "
                "or its edges hold no equilibrium; expected less leakage, or edges that differ less"
            )
    return None
