"""The equilibrium of a plant at rest, and whether a point is one: nothing but the motion itself changes there."""

import numpy as np

from plants.equation import fields, to_array
from plants.interface import Plant
from workbench.linear.linearise import EVALUATION_TIME, jacobians
from workbench.simulation.setup import Numbers, Setup

STATIONARY = 1e-3
"""Share of the states' typical magnitudes by which a point may be off: a force or an opening that is known to three
digits passes, a rod that a tenth of its friction accelerates does not."""

MOTION = ("position",)
"""States whose rate is motion: they grow while all else is in equilibrium."""


def at_rest(setup: Setup) -> tuple[Numbers, Numbers]:
    """State and inputs of the true plant at rest where the setup starts, turning at the speed that it asks for."""
    plant, parameters = setup.plant, setup.parameters
    surface_speed = setup.rotation_speed * parameters.motor.piston_radius if plant.rotary_command else 0.0
    state, inputs = plant.equilibrium(parameters, surface_speed)
    return state._replace(position=setup.state.position), inputs


def changing(plant: Plant, parameters: Numbers, state: Numbers, inputs: Numbers) -> dict[str, float]:
    """The states that do not stay, each with its rate (in its unit per second); none at an equilibrium or steady slide.

    A rate counts as none where displacing the states by `STATIONARY` of their typical magnitudes s changes it as much,
    or where the state takes as long as 1 s / `STATIONARY` to change by its magnitude:

        |f_i(x, u)| <= STATIONARY (sum_j |df_i/dx_j| s_j + s_i / 1 s)

    Args:
        plant: with true or believed
        parameters: of its `Parameters` (SI).
        state: of its `State` (SI).
        inputs: of its `Inputs` (SI).
    """
    states = fields(plant.State)
    rates = to_array(plant.derivatives(EVALUATION_TIME, state, inputs, parameters))
    a, _ = jacobians(plant, parameters, state, inputs)
    scales = np.array([item.scale for item in states])
    slack = STATIONARY * (np.abs(a) @ scales + scales)
    return {
        item.name: float(rate)
        for item, rate, least in zip(states, rates, slack, strict=True)
        if item.name not in MOTION and not abs(rate) <= least
    }
