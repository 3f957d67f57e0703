"""Every friction law against what its paper says of it, and what must hold for all of them on every plant."""

import functools
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit, types

from plants.compiled import POINTER, address, caller
from plants.equation import fields, leaves, to_array
from plants.laws.interface import FrictionLaw, at_rest
from plants.laws.maxwell_slip import LEVEL_SHARE, STIFFNESS_SHARES
from plants.laws.registry import LAWS
from plants.motor import LIMITS
from plants.registry import DRIVE_FORCE, plants
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.recording.machine_code import MachineCode, machine_code
from workbench.simulation.references import ReferenceSignal, Sine, Steps
from workbench.simulation.run import Run
from workbench.simulation.setup import Feed, Integrator, Setup
from workbench.simulation.simulate import simulate

ALL = list(LAWS.working().values())
WITH_MEMORY = [law for law in ALL if law.Contact._fields]

BODY = {"mass": 2.0, "load_force": 0.0, "end_stop_stiffness": 0.0, "end_stop_damping": 0.0}
CONTACT = {
    "coulomb": 10.0,
    "stribeck": 5.0,
    "viscous": 4.0,
    "stribeck_velocity": 5e-3,
    "bristle_stiffness": 1e6,
    "bristle_damping": 500.0,
}
call_friction = caller(types.float64(types.float64, POINTER, types.float64, POINTER, POINTER))

STATIC = CONTACT["coulomb"] + CONTACT["stribeck"]


def law_of(name: str) -> FrictionLaw:
    return LAWS.working()[name]


def drive(law: FrictionLaw, **changes: float) -> tuple[Any, Any]:
    """The drive with a law and its parameters."""
    plant = DRIVE_FORCE.with_friction(law)
    return plant, build(plant.Parameters, {**BODY, **CONTACT, **changes})


def pushed(law: FrictionLaw, force: ReferenceSignal, duration: float, velocity: float = 0.0, **changes: float) -> Run:
    """The drive under a force, from an initial velocity (m/s)."""
    plant, p = drive(law, **changes)
    state, inputs = plant.equilibrium(p, 0.0)
    feeds, integrator = (Feed("drive_force", force),), Integrator(tolerance=1e-9)
    moving = state._replace(velocity=velocity)
    run = simulate(Setup(plant, p, moving, inputs, duration, feeds=feeds, integrator=integrator))
    assert run.outcome == "completed"
    return run


@functools.cache
def compiled_friction(law: FrictionLaw, parameters_class: Any) -> MachineCode:
    """The law in compiled code: of velocity, memory, the force that it holds against, parameters, and rates (out)."""
    return machine_code(law.friction, (None, law.Contact, None, parameters_class), into=4, gives=True)


@njit
def _along(friction: int, velocity: Any, step: float, parameters: Any, memory: Any, rates: Any, out: Any) -> None:
    middle = np.empty_like(memory)
    for k in range(velocity.size):
        v = velocity[k]
        held = 1e9 * np.sign(v)
        out[k] = call_friction(friction, v, address(memory), held, address(parameters), address(rates))
        middle[:] = memory + 0.5 * step * rates
        call_friction(friction, v, address(middle), held, address(parameters), address(rates))
        memory += step * rates


def along(law: FrictionLaw, velocity: np.ndarray, step: float, **changes: float) -> np.ndarray:
    """Friction (N) along a motion at given velocities (m/s), each held for `step` (s); memory by the midpoint rule."""
    plant, p = drive(law, **changes)
    memory = to_array(at_rest(law))
    out = np.empty(velocity.size)
    friction = compiled_friction(law, plant.Parameters).address
    _along(friction, velocity, step, to_array(p), memory, np.empty_like(memory), out)
    return out


# --- each law's own paper --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["coulomb", "stribeck"])
def test_a_block_that_was_pushed_stops_after_its_kinetic_energy(name: str) -> None:
    """v0^2 M / (2 F_c) for Coulomb friction; with a Stribeck level much above v0 the static level in its place."""
    changes = {"viscous": 0.0, "stribeck_velocity": 1e3}
    run = pushed(law_of(name), Steps((0.0,), 1.0), 0.5, velocity=0.5, **changes)
    level = CONTACT["coulomb"] + (CONTACT["stribeck"] if name == "stribeck" else 0.0)
    assert run.states[-1, 0] == pytest.approx(0.5**2 * BODY["mass"] / (2.0 * level), rel=1e-3)
    assert abs(run.states[-1, 1]) < 1e-12


@pytest.mark.parametrize("share", [0.5, 0.99, -0.99])
@pytest.mark.parametrize("name", ["coulomb", "stribeck"])
def test_what_sticks_does_not_creep(name: str, share: float) -> None:
    level = CONTACT["coulomb"] + (CONTACT["stribeck"] if name == "stribeck" else 0.0)
    run = pushed(law_of(name), Steps((share * level,), 10.0), 5.0)
    assert np.max(np.abs(run.states[:, 0])) == 0.0
    assert run.signals["axial_friction"][-1] == pytest.approx(share * level)


def test_a_mass_on_a_spring_loses_the_same_amplitude_in_each_half_cycle() -> None:
    """2 F_c / k a half cycle under Coulomb friction: Den Hartog 1931."""
    plant, p = drive(law_of("coulomb"), viscous=0.0, spring_stiffness=2e4)
    state, inputs = plant.equilibrium(p, 0.0)
    run = simulate(Setup(plant, p, state._replace(position=0.02), inputs, 0.3, sample_time=1e-4))
    x = run.states[:, 0]
    peaks = [abs(x[k]) for k in range(1, x.size - 1) if (x[k] - x[k - 1]) * (x[k + 1] - x[k]) < 0.0]
    loss = -np.diff([0.02, *peaks[:6]])
    assert loss == pytest.approx(2.0 * CONTACT["coulomb"] / 2e4, rel=5e-3)


def test_dahl_friction_is_exponential_in_the_way() -> None:
    """F = F_c - (F_c - F_0) exp(-sigma0 x / F_c) towards +x: Dahl 1968."""
    law = law_of("dahl")
    step, speed = 1e-5, 1e-3
    ways = np.concatenate([np.full(4000, speed), np.full(2000, -speed)])
    force = along(law, ways, step, viscous=0.0)
    x, level, stiffness = np.arange(4000) * step * speed, CONTACT["coulomb"], CONTACT["bristle_stiffness"]
    expected = level * (1.0 - np.exp(-stiffness * x / level))
    assert force[:4000] == pytest.approx(expected, abs=2e-3 * level)
    back = np.arange(2000) * step * speed
    assert force[4000:] == pytest.approx(
        -level + (level + force[4000]) * np.exp(-stiffness * back / level), abs=2e-3 * level
    )


def test_lugre_creeps_under_a_force_that_comes_and_goes_and_the_elasto_plastic_law_does_not() -> None:
    """A bias below break-away with a vibration on it: Dupont et al. 2002."""
    force = Sine(0.15 * STATIC, 5.0)
    ways = {}
    for name in ("lugre", "elasto_plastic"):
        plant, p = drive(law_of(name))
        state, inputs = plant.equilibrium(p, 0.0)
        biased = inputs._replace(disturbance_force=-0.4 * STATIC)
        run = simulate(Setup(plant, p, state, biased, 8.0, feeds=(Feed("drive_force", force),)))
        ways[name] = run.states[8000, 0] - run.states[4000, 0]  # whole periods of the vibration apart
    elastic = 0.4 * STATIC / CONTACT["bristle_stiffness"]
    assert ways["lugre"] > 0.2 * elastic
    assert abs(ways["elasto_plastic"]) < 1e-6 * elastic


def test_an_elasto_plastic_contact_is_a_spring_up_to_its_elastic_share() -> None:
    _, p = drive(law_of("elasto_plastic"))
    force = 0.3 * STATIC  # a step of it overshoots to twice as much
    run = pushed(law_of("elasto_plastic"), Steps((force,), 10.0), 2.0)
    assert run.states[-1, 0] == pytest.approx(force / CONTACT["bristle_stiffness"], rel=1e-6)
    assert p.law.elastic_share == 0.7


def virgin(way: np.ndarray, level: float) -> np.ndarray:
    """Force (N) of elements that are pulled for the first time, each a spring up to its share of `level` (N)."""
    stiffness = CONTACT["bristle_stiffness"]
    return np.sum([np.minimum(share * stiffness * way, LEVEL_SHARE * level) for share in STIFFNESS_SHARES], axis=0)


def test_maxwell_slip_follows_masing_and_remembers_where_it_turned() -> None:
    """The virgin curve; a branch after a reversal is that curve doubled; a small loop closes: Al-Bender et al. 2005.

    So slowly that the level is that at rest.
    """
    law, speed, step = law_of("gms"), 1e-6, 2e-3
    changes = {"viscous": 0.0, "bristle_damping": 0.0}
    there, back, small = 20_000, 14_000, 3_000
    ways = speed * np.concatenate([np.ones(there), -np.ones(back), np.ones(small), -np.ones(small + 2_000)])
    force, x = along(law, ways, step, **changes), np.cumsum(ways) * step
    assert force[:there] == pytest.approx(virgin(x[:there], STATIC), abs=5e-3 * STATIC)
    gone = x[there - 1] - x[there : there + back]
    branch = force[there - 1] - 2.0 * virgin(0.5 * gone, STATIC)
    assert force[there : there + back] == pytest.approx(branch, abs=5e-3 * STATIC)
    closed = there + back + 2 * small
    assert force[closed] == pytest.approx(force[there + back - 1], abs=5e-3 * STATIC)
    assert force[-1] == pytest.approx(
        force[there - 1] - 2.0 * virgin(0.5 * (x[there - 1] - x[-1]), STATIC), abs=5e-3 * STATIC
    )


def test_maxwell_slip_follows_the_level_late() -> None:
    """At a speed that swings, sliding on, friction is a lag of first order behind g(v): dF/dt = C (1 - F / g)."""
    law, step = law_of("gms"), 2e-6
    time = np.arange(0.0, 0.3, step)
    velocity = 6e-3 + 4e-3 * np.sin(2.0 * np.pi * 20.0 * time)
    force = along(law, velocity, step, viscous=0.0, bristle_damping=0.0)
    level = CONTACT["coulomb"] + CONTACT["stribeck"] * np.exp(-((velocity / CONTACT["stribeck_velocity"]) ** 2))
    expected, lag = force[50_000], []
    for g in level[50_000:]:
        lag.append(expected)
        expected += step * STATIC / 5e-3 * (1.0 - expected / g)
    assert force[50_000:] == pytest.approx(lag, rel=5e-3)
    assert np.ptp(force[100_000:]) < 0.9 * np.ptp(level)


@pytest.mark.parametrize("law", ALL, ids=lambda law: law.name)
def test_after_long_at_a_speed_friction_is_the_steady_one(law: FrictionLaw) -> None:
    _, p = drive(law)
    for v in (-0.02, -1e-3, 1e-3, 0.02):
        steps = np.full(200_000, v)
        assert along(law, steps, min(2e-6, 2e-8 / abs(v)))[-1] == pytest.approx(float(law.steady(v, p)), rel=2e-3)


# --- what holds for all ----------------------------------------------------------------------------------------------

STANDING = [(name, law) for name in ("non_rotating", "drive_force") for law in ALL]
STANDING += [(name, law_of("gms")) for name in ("pump_cylinder", "drive_voltage")]
TURNING = ("rotating_isotropic", "rotating_isotropic_ideal")
VALUES = {
    **read_parameters(named_sets()["owen2001_simulation"]),
    "pump_displacement": 1e-6,
    "force_gain": 100.0,
    "stroke": 1.0,
    **dict.fromkeys(LIMITS, np.inf),
}


@pytest.mark.parametrize(("name", "law"), STANDING, ids=lambda item: getattr(item, "name", item))
def test_every_plant_takes_every_law(name: str, law: FrictionLaw) -> None:
    plant = plants()[name].with_friction(law)
    assert plant.with_friction(law) is plant
    p = build(plant.Parameters, VALUES)
    state, inputs = plant.equilibrium(p, 0.0)
    amplitude = {"valve_voltage": 1.0, "pump_speed": 40.0, "drive_force": 900.0, "drive_voltage": 9.0}[plant.command]
    feeds = (Feed(plant.command, Sine(amplitude, 2.0)),)
    run, fine = (
        simulate(Setup(plant, p, state, inputs, 1.0, feeds=feeds, integrator=Integrator(tolerance=tolerance)))
        for tolerance in (1e-6, 1e-8)
    )
    assert run.outcome == fine.outcome == "completed"
    way = np.ptp(fine.states[:, 0])
    assert way > 1e-4
    assert run.states[:, 0] == pytest.approx(fine.states[:, 0], abs=1e-3 * way)


@pytest.mark.parametrize("name", TURNING)
@pytest.mark.parametrize("law", [law for law in ALL if law.plane], ids=lambda law: law.name)
def test_a_turning_rod_takes_every_law_that_has_a_form_in_the_plane(name: str, law: FrictionLaw) -> None:
    """Without rotation it is the plant that does not turn; with it friction along is a share of that at the helix."""
    standing = plants()["non_rotating"].with_friction(law)
    turning = plants()[name].with_friction(law)
    motion = []
    for plant, speed in ((standing, 0.0), (turning, 0.0), (turning, 0.5)):
        p = build(plant.Parameters, VALUES)
        state, inputs = plant.equilibrium(p, speed)
        feeds = (Feed("valve_voltage", Sine(0.5, 1.0)),)
        run = simulate(Setup(plant, p, state, inputs, 1.5, feeds=feeds))
        assert run.outcome == "completed"
        motion.append(run)
    still, same, turned = motion
    assert same.states[:, 0] == pytest.approx(still.states[:, 0], abs=2e-6)
    p = build(turning.Parameters, VALUES)
    axial, _ = law.plane["isotropic"].steady(turned.signals["velocity"], turned.signals["surface_speed"], p)
    assert turned.signals["axial_friction"][200:] == pytest.approx(axial[200:], abs=12.0)


def test_what_has_no_form_in_the_plane_is_told() -> None:
    with pytest.raises(ValueError, match=r'friction "gms" has no form .* rod that does not rotate'):
        plants()["rotating_isotropic"].with_friction(law_of("gms"))
    with pytest.raises(ValueError, match=r'friction "dahl" has no form .* expected bristle = "isotropic"'):
        plants()["rotating_helical"].with_friction(law_of("dahl"))


@given(seed=st.integers(0, 10_000), scale=st.floats(1e-4, 0.05))
@settings(max_examples=10, deadline=None)
@pytest.mark.parametrize("law", WITH_MEMORY, ids=lambda law: law.name)
def test_no_contact_gives_back_more_than_it_stores(law: FrictionLaw, seed: int, scale: float) -> None:
    """Work done on it along a random motion from rest, against the largest energy of its springs.

    LuGre's and the elasto-plastic bristle are damped beyond what is passive in these numbers: without damping here.
    """
    generator = np.random.default_rng(seed)
    time = np.arange(0.0, 0.4, 1e-5)
    frequencies, phases = generator.uniform(1.0, 30.0, 6), generator.uniform(0.0, 2.0 * np.pi, 6)
    velocity = scale * np.mean(np.sin(2.0 * np.pi * np.outer(time, frequencies) + phases), axis=1)
    velocity = velocity * np.minimum(time / 0.01, 1.0)
    force = along(law, velocity, 1e-5, viscous=0.0, bristle_damping=0.0)
    work = np.cumsum(force * velocity) * 1e-5
    softest = CONTACT["bristle_stiffness"] * min(STIFFNESS_SHARES) / LEVEL_SHARE
    assert np.min(work) > -0.01 * STATIC**2 / softest


@pytest.mark.parametrize("law", ALL, ids=lambda law: law.name)
def test_a_contact_without_friction_is_none(law: FrictionLaw) -> None:
    plant, p = drive(law, coulomb=0.0, stribeck=0.0, viscous=0.0, bristle_stiffness=0.0, bristle_damping=0.0)
    state, inputs = plant.equilibrium(p, 0.0)
    run = simulate(Setup(plant, p, state, inputs._replace(drive_force=1.0), 1.0))
    assert run.states[-1, 0] == pytest.approx(0.5 / BODY["mass"], rel=1e-6)


@pytest.mark.parametrize("law", ALL, ids=lambda law: law.name)
def test_what_a_law_remembers_and_needs_has_units(law: FrictionLaw) -> None:
    for cls in (law.Contact, law.Extra):
        assert all(item.unit for item in fields(cls))
    assert {*law.uses} <= {*CONTACT}
    assert len(list(leaves(at_rest(law)))) == len(fields(law.Contact))
