"""Effects on every plant that can have them: neutral at their defaults, felt beyond, and one brought by a user."""

from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
from effect_machines import SIZES, TRUTH
from thesis_actuator import along

from plants.effects.attach import acts_by_itself, lacks, meant, possible
from plants.effects.interface import Effect, Moment, Number
from plants.effects.registry import effects
from plants.equation import Scalar, equation, fields, from_array, leaves, replaced, to_array
from plants.interface import Plant
from plants.laws.interface import Nothing
from plants.laws.registry import LAWS
from plants.registry import plants
from workbench.parameters.sets import build
from workbench.simulation.references import Sine
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate

ALL = list(plants().values())


def whole(plant: Plant) -> Plant:
    return plant.with_effects(*possible(plant))


def states_of(plant: Plant, values: dict[str, float], seed: int = 0) -> tuple[Any, Any, Any]:
    """A state off rest, inputs and parameters."""
    parameters = build(plant.Parameters, along(plant, {**TRUTH, **values}))
    state, inputs = plant.equilibrium(parameters, 0.0)
    draw = np.random.default_rng(seed)
    scales = {item.name: item.scale for item in fields(plant.State)}
    moved = [
        number + 0.1 * scales[item.name] * draw.standard_normal()
        for item, number in zip(fields(plant.State), leaves(state), strict=True)
    ]
    driven = replaced(inputs, {plant.command: 0.1})
    return from_array(plant.State, moved), driven, parameters


@pytest.mark.parametrize("plant", ALL, ids=lambda plant: plant.name)
def test_all_effects_are_neutral_at_their_defaults(plant: Plant) -> None:
    full = whole(plant)
    state, inputs, parameters = states_of(full, {})
    bare = from_array(plant.State, list(leaves(state))[: len(fields(plant.State))])
    known = build(plant.Parameters, along(plant, TRUTH))
    rates = to_array(full.derivatives(0.3, state, inputs, parameters))[: len(fields(plant.State))]
    assert rates == pytest.approx(to_array(plant.derivatives(0.3, bare, inputs, known)), rel=1e-12, abs=1e-12)
    shown = np.array([float(value) for value in full.measure(state, parameters)])
    expected = np.array([float(value) for value in plant.measure(bare, known)])
    gap = dict(zip([item.name for item in fields(full.State)], leaves(state), strict=True)).get("sensor_gap", 0.0)
    assert np.isfinite(gap)
    assert np.allclose(shown, expected, rtol=1e-12, equal_nan=True)


@pytest.mark.parametrize("plant", ALL, ids=lambda plant: plant.name)
def test_every_effect_changes_what_it_is_on(plant: Plant) -> None:
    """Of the states' rates, or of what the sensors show, and by a finite amount; some act on one side alone."""
    for effect in possible(plant):
        if acts_by_itself(plant, effect):
            continue
        one = plant.with_effects(effect)
        assert one.effects == (effect.name,)
        sizes = along(plant, SIZES)
        acting = build(
            one.Parameters, along(plant, TRUTH) | {name: sizes[name] for name in effect.own_names if name in sizes}
        )
        largest = []
        for seed in range(4):
            state, inputs, neutral = states_of(one, {}, seed)
            before = [*leaves(one.derivatives(0.3, state, inputs, neutral)), *leaves(one.measure(state, neutral))]
            after = [*leaves(one.derivatives(0.3, state, inputs, acting)), *leaves(one.measure(state, acting))]
            largest.append(np.nanmax(np.abs(np.array(after, dtype=float) - np.array(before, dtype=float))))
        assert np.all(np.isfinite(largest)), f"{plant.name}: {effect.name}"
        assert max(largest) > 0.0, f"{plant.name}: {effect.name}"


def test_an_effect_that_a_plant_cannot_have_is_refused_in_words() -> None:
    drive = plants()["drive_force"]
    assert lacks(drive, effects()["entrained_air"]) == "hydraulics"
    with pytest.raises(ValueError, match='plant "drive_force" cannot have the effect "entrained_air": it has no'):
        drive.with_effects(effects()["entrained_air"])


def test_effects_are_meant_by_the_names_of_their_parameters() -> None:
    plant = plants()["rotating_isotropic"]
    named = meant(plant, ["friction_gradient", "valve_overlap", "mass"])
    assert [effect.name for effect in named] == ["position_dependent_friction"]
    assert plant.with_effects(*named).with_effects(effects()["backlash"]).effects == (
        "position_dependent_friction",
        "backlash",
    )


@pytest.mark.parametrize("name", ["gms", "dahl", "coulomb"])
def test_effects_stay_when_the_friction_law_changes(name: str) -> None:
    plant = plants()["non_rotating"].with_effects(effects()["quadratic_drag"], effects()["position_dependent_friction"])
    other = plant.with_friction(LAWS.working()[name])
    assert (other.friction, other.effects) == (name, plant.effects)
    values = {"drag_coefficient": 2e4, "friction_gradient": 0.4}
    bare = plants()["non_rotating"].with_friction(LAWS.working()[name])
    with_them, without = (run(item, values) for item in (other, bare))
    assert np.max(np.abs(with_them - without)) > 1e-6


def run(plant: Plant, values: dict[str, float]) -> np.ndarray:
    """Position (m) over 1 s under a sine."""
    parameters = build(plant.Parameters, along(plant, {**TRUTH, **values}))
    state, inputs = plant.equilibrium(parameters, 0.0)
    result = simulate(Setup(plant, parameters, state, inputs, 1.0, feeds=(Feed(plant.command, Sine(0.8, 1.0)),)))
    assert result.outcome == "completed"
    return result.signals["position"]


@pytest.mark.parametrize("name", ["non_rotating", "two_chamber", "rotating_isotropic", "pump_cylinder", "drive_force"])
def test_a_plant_with_effects_rests_in_its_equilibrium(name: str) -> None:
    """A force over the angle, and areas that differ: oil or drive hold them."""
    plant = whole(plants()[name])
    parameters = build(plant.Parameters, {**TRUTH, "cosine_force": 80.0, "area_ratio": 0.8})
    state, inputs = plant.equilibrium(parameters, 0.0)
    rate = float(plant.derivatives(0.0, state, inputs, parameters).velocity)
    assert abs(rate) * TRUTH["mass"] < 1e-6


@pytest.mark.parametrize("name", ["rotating_isotropic", "rotating_helical"])
def test_a_turning_rod_under_a_load_rests_with_friction_that_pressure_raises(name: str) -> None:
    plant = whole(plants()[name])
    parameters = build(plant.Parameters, {**TRUTH, "cosine_force": 200.0, "friction_per_pressure": 1e-4})
    state, inputs = plant.equilibrium(parameters, 10.0 * TRUTH["piston_radius"])
    rates = plant.derivatives(0.0, state, inputs, parameters)
    assert abs(float(rates.surface_speed)) < 1e-9
    assert abs(float(rates.velocity)) * TRUTH["mass"] < 1e-6


class Pull(NamedTuple):
    magnet_force: Annotated[float, "N"] = 0.0


@equation
def pulled(disturbance: Scalar, moment: Moment, memory: Nothing, p: Any, own: Pull) -> Scalar:
    """F / (1 + (x / 1 mm)^2) (N): a magnet in mid-stroke."""
    return disturbance + own.magnet_force / (1.0 + (moment.position / 1e-3) ** 2)


MAGNET = Effect(
    name="magnet",
    balance="force",
    words="a magnet pulls in mid-stroke",
    source="made up",
    numbers={"magnet_force": Number(-10.0, 10.0, 0.1, lambda scales: scales.force)},
    Own=Pull,
    inputs={"disturbance_force": pulled},
)


@pytest.mark.parametrize("name", ["non_rotating", "rotating_anisotropic", "pump_cylinder", "drive_voltage"])
def test_an_effect_of_a_user_acts_on_any_plant_that_can_be_disturbed(name: str) -> None:
    plant = plants()[name].with_effects(MAGNET)
    parameters = build(plant.Parameters, {**TRUTH, "magnet_force": 100.0})
    state, inputs = plant.equilibrium(parameters, 0.0)
    rate = plant.derivatives(0.0, state, inputs, parameters).velocity
    still = plants()[name].derivatives(0.0, state, inputs, build(plants()[name].Parameters, TRUTH)).velocity
    assert rate - still == pytest.approx(-100.0 / TRUTH["mass"], rel=1e-9)
