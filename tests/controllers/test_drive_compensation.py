"""Compensators on drives whose command is no force, or whose motor stands before a compliance."""

from typing import Any

import numpy as np
import pytest

from controllers import compensation as comp
from controllers.belief import drive_gain, moved_mass
from plants.registry import plants
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.references import Sine
from workbench.simulation.simulate import Loop, Run, Setup, simulate

JOINT = read_parameters(named_sets()["walkman_joint"])
ELASTIC = read_parameters(named_sets()["walkman_joint_elastic"])
SLOW = Sine(0.03, 0.5)
"""rad and Hz."""


def tracked(name: str, values: Any) -> Run:
    """The slow sine with LuGre's estimate, whose belief is the plant."""
    plant = plants()[name]
    parameters = build(plant.Parameters, values)
    gains = comp.design(comp.Settings(law="force_source"), parameters, 1e-3)
    state, inputs = plant.equilibrium(parameters, 0.0)
    loop = Loop(comp.compensator("lugre", "force_source", False), gains)
    return simulate(Setup(plant, parameters, state, inputs, 2.0, loop, SLOW))


def test_a_current_is_the_torque_over_its_constant() -> None:
    by_torque, by_current = tracked("rotary_torque", JOINT), tracked("rotary_current", JOINT)
    assert np.max(np.abs(by_torque.signals["error"])) < 1e-3
    assert by_current.state("position") == pytest.approx(by_torque.state("position"), abs=1e-7)
    assert by_current.command * 4.53 == pytest.approx(by_torque.command, abs=1e-2)


def test_a_compliance_is_believed_stiff() -> None:
    """Both inertias are moved, and the load is brought near all the same."""
    parameters = build(plants()["two_inertia_current"].Parameters, ELASTIC)
    assert moved_mass(parameters) == ELASTIC["inertia"] + ELASTIC["motor_inertia"]
    assert drive_gain(parameters) == 4.53
    run = tracked("two_inertia_current", ELASTIC)
    assert run.outcome == "completed"
    assert np.max(np.abs(run.signals["error"])) < 1e-3
