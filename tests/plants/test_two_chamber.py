"""The actuator with a pressure in each chamber: without effects the load-pressure one, and what each effect does."""

import numpy as np
import pytest

from plants.effects.attach import meant
from plants.effects.registry import effects
from plants.registry import plants
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.references import Sine
from workbench.simulation.simulate import Feed, Run, Setup, simulate

TRUTH = read_parameters(named_sets()["owen2001_simulation"])
PLANT = plants()["two_chamber"]


def run(name: str, duration: float = 3.0, **changes: float) -> Run:
    plant = plants()[name]
    plant = plant.with_effects(*meant(plant, [*changes]))
    parameters = build(plant.Parameters, {**TRUTH, **changes})
    state, inputs = plant.equilibrium(parameters, 0.0)
    return simulate(Setup(plant, parameters, state, inputs, duration, feeds=(Feed("valve_voltage", Sine(0.8, 0.5)),)))


def test_without_effects_it_is_the_load_pressure_actuator() -> None:
    """The pressures add up to supply and tank; position, pressure and friction agree to the integrators' tolerance."""
    two, one = run("two_chamber"), run("non_rotating")
    assert two.outcome == one.outcome == "completed"
    total = two.signals["pressure_1"] + two.signals["pressure_2"]
    assert np.max(np.abs(total - TRUTH["supply_pressure"])) < 100.0
    for name, tolerance in {"position": 1e-7, "load_pressure": 2e3, "axial_friction": 2.0, "load_flow": 1e-8}.items():
        assert np.max(np.abs(two.signals[name] - one.signals[name])) < tolerance, name


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("load_force", 100.0),
        ("spring_stiffness", 5e3),
        ("drag_coefficient", 2e4),
        ("friction_gradient", 0.3),
        ("friction_curvature", 0.8),
        ("friction_per_pressure", 1e-4),
        ("memory_time", 0.02),
        ("static_rise", 1.0),
        ("viscous_drift", 0.05),
        ("valve_overlap", 1e-5),
        ("leakage_coefficient", 2e-12),
        ("droop_resistance", 3e9),
        ("air_fraction", 0.01),
        ("area_ratio", 0.8),
        ("command_delay", 0.01),
        ("backlash_width", 5e-5),
        ("pressure_1_offset", 5e4),
        ("viscous_negative", 4000.0),
    ],
)
def test_every_effect_shows_in_what_a_rig_measures(name: str, value: float) -> None:
    with_it, without = run("two_chamber", 2.0, **{name: value}), run("two_chamber", 2.0)
    assert not with_it.diverged
    difference = np.abs(with_it.measurements - without.measurements)
    assert np.max(difference[:, 0]) > 1e-6 or np.max(difference[:, 1:3]) > 1e3


def test_a_backlash_holds_the_sensor_at_a_reversal() -> None:
    width = 5e-5
    loose = run("two_chamber", backlash_width=width)
    gap = loose.measurements[:, 0] - loose.signals["position"]
    assert np.max(np.abs(gap)) <= 0.5 * width + 1e-12
    velocity = loose.signals["velocity"]
    assert np.all(gap[velocity > 5e-3][200:] == pytest.approx(-0.5 * width, abs=1e-9))


def test_pressures_of_unequal_areas_hold_the_load() -> None:
    plant = PLANT.with_effects(effects()["unequal_areas"])
    parameters = build(plant.Parameters, {**TRUTH, "area_ratio": 0.7, "load_force": 100.0})
    state, _ = plant.equilibrium(parameters, 0.0)
    force = state.pressure_1 * TRUTH["piston_area_1"] - state.pressure_2 * 0.7 * TRUTH["piston_area_2"]
    assert force == pytest.approx(100.0, rel=1e-12)
