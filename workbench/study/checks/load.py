"""What may be meant of a load, and seldom is: one that the machine cannot hold."""

from typing import Any

from plants.interface import Plant

HELD = 1e-6
"""Share of the load that may be left at rest: an equilibrium is found by halving."""


def unheld(plant: Plant, parameters: Any) -> str | None:
    """Why a machine does not start at rest under its load, in words; None where it does."""
    body = getattr(parameters, "body", None)
    if body is None or body.load_force == 0.0:
        return None
    state, inputs = plant.equilibrium(parameters, 0.0)
    lacking = abs(body.mass * plant.derivatives(0.0, state, inputs, parameters).velocity)
    if lacking <= HELD * abs(body.load_force):
        return None
    return (
        f"a load of {body.load_force:.4g} is {lacking:.4g} more than the actuator holds: the run begins with all the "
        "pressure that there is; expected a smaller load_force, or more supply_pressure or area"
    )
