"""A plant with an observer's corrections: gains times the innovation, and the plant where that is 0."""

from typing import Any

import casadi
import numpy as np
import pytest

from plants.equation import fields, from_array, leaves, to_array
from plants.interface import Plant
from plants.observed import INNOVATION, corrected, gain_of, observed
from plants.registry import plants
from workbench.parameters.sets import build, named_sets, read_parameters

VALUES = read_parameters(named_sets()["owen2001_simulation"])


def of_a_drive() -> tuple[Plant, Any, Any]:
    """A mass that a force drives, its parameters, and a state in which it slides."""
    plant = plants()["drive_force"]
    return plant, build(plant.Parameters, VALUES), from_array(plant.State, [1e-3, 0.02, 5e-5])


def test_motion_and_contact_are_corrected_and_nothing_else() -> None:
    plant, parameters, state = of_a_drive()
    assert corrected(plant) == ("position", "velocity", "bristle_deflection")
    filtered = observed(plant)
    assert observed(plant) is filtered
    assert filtered.State is plant.State
    bare = plant.Inputs(100.0, 0.0, 3.0)
    gains = [2.0, -30.0, 0.5]
    rates = to_array(filtered.derivatives(0.0, state, filtered.Inputs(*bare, 1e-3, *gains), parameters))
    plain = to_array(plant.derivatives(0.0, state, bare, parameters))
    assert rates - plain == pytest.approx(1e-3 * np.array(gains), rel=1e-9)


def test_at_rest_nothing_is_corrected() -> None:
    plant, parameters, _ = of_a_drive()
    filtered = observed(plant)
    state, inputs = filtered.equilibrium(parameters, 0.0)
    assert state == plant.equilibrium(parameters, 0.0)[0]
    assert inputs == filtered.Inputs(*plant.equilibrium(parameters, 0.0)[1])
    assert not any(filtered.derivatives(0.0, state, inputs, parameters)[:2])
    assert filtered.signals(0.0, state, inputs, parameters) == plant.signals(
        0.0, state, plant.equilibrium(parameters, 0.0)[1], parameters
    )


@pytest.mark.parametrize("name", ["drive_force", "rotary_torque", "drive_voltage"])
def test_gains_have_the_units_of_their_states(name: str) -> None:
    plant = plants()[name]
    units = {item.name: item.unit for item in fields(observed(plant).Inputs)}
    axis = units[INNOVATION]
    assert axis == plant.axis
    for item in fields(plant.State):
        assert units[gain_of(item.name)] == f"{item.unit}/({axis} s)"


def test_a_symbol_goes_through_it() -> None:
    plant, parameters, state = of_a_drive()
    filtered, innovation = observed(plant), casadi.SX.sym("e")
    inputs = filtered.Inputs(100.0, 0.0, 0.0, innovation, 2.0, -30.0, 0.5)
    rates = casadi.vertcat(*leaves(filtered.derivatives(0.0, state, inputs, parameters)))
    assert np.array(casadi.DM(casadi.jacobian(rates, innovation))).ravel() == pytest.approx([2.0, -30.0, 0.5])
