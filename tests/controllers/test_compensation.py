"""Friction estimators by themselves, the laws, and both in the loop."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers import compensation as comp
from controllers.compensation_laws import LawState, Wanted, acceleration_feedback, force_source, valve_inversion
from controllers.friction_observer import Belief, Memory, Seen
from controllers.friedland_park import REVERSAL_SPEED, friedland_park
from controllers.interface import Reference
from controllers.lugre_observer import THETA_RANGE, friction_feedforward, lugre_adaptive, lugre_observer
from controllers.static_map import static_map
from controllers.tafazoli import fit_map, tafazoli
from plants.friction import LuGre, steady_friction
from plants.hydraulics import oil_volume, piston_area
from plants.interface import Measurement
from plants.registry import plants
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.references import Sine
from workbench.simulation.simulate import Loop, Run, Setup, simulate

VALUES = {**read_parameters(named_sets()["owen2001_simulation"]), "end_stop_stiffness": 0.0}
DRIVE = plants()["drive_force"]
CYLINDER = plants()["non_rotating"]
H = 1e-3

ESTIMATES = [name for name in comp.ESTIMATORS if name not in ("uncompensated", "friction_gauge")]
"""What a rig can have in the place of friction."""


def parameters(plant: Any = DRIVE, **factors: float) -> Any:
    """The simulation set's parameters, some of them scaled."""
    return build(plant.Parameters, {k: v * factors.get(k, 1.0) for k, v in VALUES.items()})


def belief(**changed: float) -> Belief:
    """What the estimators believe with default settings, some of them changed."""
    return comp.design(comp.Settings(**changed), parameters(), H).belief


def at_rest(**changed: float) -> Memory:
    return Memory(0.0, 0.0, 1.0, 0.0, 0.0)._replace(**changed)


def in_the_loop(name: str, law: str, reference: Any, duration: float, true: Any = None, **changed: Any) -> Run:
    """A run with a compensator whose belief is the simulation set, whatever the truth."""
    plant = CYLINDER if law != "force_source" else DRIVE
    believed = parameters(plant)
    gains = comp.design(comp.Settings(law=law, **changed), believed, H)
    truth = believed if true is None else true
    state, inputs = plant.equilibrium(truth, 0.0)
    loop = Loop(comp.compensator(name, law, plant is CYLINDER), gains)
    return simulate(Setup(plant, truth, state, inputs, duration, loop, reference))


# --- estimators -----------------------------------------------------------------------------------------------


def test_the_tustin_map_of_the_simulation_plant() -> None:
    tustin, residual = fit_map(parameters().friction)
    assert tustin == pytest.approx((693.0, -1754.0, 4613.0), abs=1.0)
    assert residual == pytest.approx(14.0, abs=0.5)


def test_tafazolis_estimate_is_the_map_in_motion_and_the_applied_force_at_rest() -> None:
    b = belief()
    moving, _ = tafazoli(Seen(0.1, 0.1, 0.0, 0.0), at_rest(), b, H)
    assert moving == pytest.approx(b.map.constant + b.map.root * math.sqrt(0.1) + b.map.linear * 0.1)
    for applied, held in ((123.0, 123.0), (5000.0, 587.0), (-5000.0, -587.0)):
        assert tafazoli(Seen(0.0, 0.0, applied, 0.0), at_rest(), b, H)[0] == pytest.approx(held)


def test_the_static_map_is_the_believed_curve_and_odd() -> None:
    b = belief()
    curve = steady_friction(0.05, b.friction.positive)
    assert static_map(Seen(0.05, 0.05, 0.0, 0.0), at_rest(), b, H)[0] == pytest.approx(float(curve))
    assert static_map(Seen(-0.05, -0.05, 0.0, 0.0), at_rest(), b, H)[0] == pytest.approx(-float(curve))


@pytest.mark.parametrize(("exponent", "speed"), [(1.0, 0.05), (1.0, -0.2), (0.7, 0.05), (1.5, 0.1)])
def test_friedland_parks_error_decays_at_the_rate_of_theory(exponent: float, speed: float) -> None:
    b = belief(exponent=exponent)
    true_level = 500.0
    memory = at_rest(previous_velocity=speed)
    errors = []
    for _ in range(40):
        _, memory = friedland_park(Seen(speed, speed, math.copysign(true_level, speed), 0.0), memory, b, H)
        errors.append(true_level - memory.level)
    rate = -np.polyfit(H * np.arange(40), np.log(errors), 1)[0]
    theory = 1700.0 * exponent / 34.0 * abs(speed) ** (exponent - 1.0)
    assert rate == pytest.approx(theory, rel=0.05)


@given(force=st.floats(-1e5, 1e5), velocity=st.floats(-2.0, 2.0), before=st.floats(-2.0, 2.0))
def test_friedland_parks_level_stays_in_its_range_and_is_held_at_rest(
    force: float, velocity: float, before: float
) -> None:
    _, memory = friedland_park(Seen(velocity, before, force, 0.0), at_rest(level=300.0), belief(), H)
    assert 0.0 <= memory.level <= 2000.0
    if abs(velocity + before) / 2.0 <= REVERSAL_SPEED:
        assert memory.level == 300.0


def steady_estimate(theta: float, velocity: float) -> float:
    memory, b = at_rest(theta=theta), belief()
    for _ in range(3000):
        force, memory = lugre_observer(Seen(velocity, velocity, 0.0, 0.0), memory, b, H)
    return float(force)


@pytest.mark.parametrize("velocity", [0.003, 0.05, -0.2, 1.0])
def test_a_larger_theta_is_less_friction(velocity: float) -> None:
    p: LuGre = belief().friction.positive
    for theta in (0.5, 1.0, 2.0):
        level = steady_friction(velocity, p) - p.viscous * velocity
        assert steady_estimate(theta, velocity) == pytest.approx(float(level) / theta + p.viscous * velocity, rel=1e-6)


@settings(deadline=None)
@given(
    velocities=st.lists(st.floats(-1.0, 1.0), min_size=20, max_size=200),
    theta=st.floats(*THETA_RANGE),
    sliding=st.floats(-0.2, 0.2),
)
def test_the_sampled_observer_is_bounded_up_to_one_metre_a_second(
    velocities: list[float], theta: float, sliding: float
) -> None:
    b = belief()
    p = b.friction.positive
    memory = at_rest(theta=theta)
    # Within one sample the bristle moves by what drives it, or relaxes towards its steady deflection.
    largest = (p.coulomb + p.stribeck) / (p.bristle_stiffness * theta)
    for velocity in velocities:
        _, memory = lugre_observer(Seen(velocity, velocity, 0.0, sliding), memory, b, H)
        drive = abs(velocity) + 0.1 * abs(sliding)
        allowed = max(abs(memory.bristle), 0.0)
        assert math.isfinite(memory.bristle)
        if abs(velocity) > 2e-3:
            largest = max(largest, (p.coulomb + p.stribeck) / (p.bristle_stiffness * theta) * drive / abs(velocity))
        else:
            largest += drive * H
        assert allowed <= largest * (1.0 + 1e-9)


# --- adaptation -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("velocity", ["filter", "thesis_filter"])
def test_theta_converges_to_the_inverse_of_the_true_friction(velocity: str) -> None:
    truth = parameters(coulomb=1.3, stribeck=1.3)
    run = in_the_loop("lugre_adaptive", "force_source", Sine(0.02, 0.5), 12.0, truth, velocity=velocity)
    found = run.signals["controller_theta"]
    assert np.mean(found[run.time > 8.0]) == pytest.approx(1.0 / 1.3, rel=0.05)
    assert np.all((found >= THETA_RANGE[0]) & (found <= THETA_RANGE[1]))


def test_the_controllers_state_is_recorded_as_its_equations_give_it() -> None:
    run = in_the_loop("lugre_adaptive", "valve_inversion", Sine(0.02, 0.5), 0.3)
    controller, gains = run.loop.controller, run.loop.gains
    assert run.reference is not None
    state = controller.start(Measurement(*run.measurements[0]), gains)
    for k in range(run.time.size):
        reference = Reference(*(part[k] for part in run.reference))
        _, state = controller.step(reference, Measurement(*run.measurements[k]), state, gains, H)
        state = controller.commit(run.command[k], state, gains, H)
        assert run.signals["controller_friction"][k] == pytest.approx(float(state.friction), rel=1e-9, abs=1e-9)
        assert run.signals["controller_theta"][k] == pytest.approx(float(state.memory.theta), rel=1e-9)
    assert np.max(np.abs(run.signals["controller_friction"])) > 300.0


def test_theta_holds_at_rest() -> None:
    b, memory = belief(), at_rest(theta=0.8, bristle=5e-5)
    for _ in range(1000):
        _, memory = lugre_adaptive(Seen(0.0, 0.0, 400.0, 0.0), memory, b, H)
    assert memory.theta == 0.8


@settings(deadline=None, max_examples=30)
@given(
    forces=st.lists(st.floats(-5e3, 5e3), min_size=50, max_size=50),
    velocities=st.lists(st.floats(-1.0, 1.0), min_size=50, max_size=50),
)
def test_theta_never_leaves_its_range(forces: list[float], velocities: list[float]) -> None:
    memory = at_rest()
    for force, velocity in zip(forces, velocities, strict=True):
        _, memory = lugre_adaptive(Seen(velocity, velocity, force, 0.0), memory, belief(adaptation=10.0), H)
        assert THETA_RANGE[0] <= memory.theta <= THETA_RANGE[1]


def test_friction_feedforward_is_the_observer_s_law_along_the_reference_alone() -> None:
    b, along, measured = belief(injection=0.0), at_rest(), at_rest()
    for i in range(200):
        wanted = 0.05 * math.sin(0.1 * i)
        force, along = friction_feedforward(Seen(-1.0, 0.5, 300.0, 0.2, 0.0, math.nan, wanted), along, b, H)
        expected, measured = lugre_observer(Seen(wanted, wanted, 0.0, 0.0), measured, b, H)
        assert force == expected


# --- laws -----------------------------------------------------------------------------------------------------


def test_acceleration_feedback_by_hand() -> None:
    gains = comp.design(comp.Settings(kp=400.0, kd=3.0, ka=0.002, feedforward=0.0), parameters(CYLINDER), H).law
    command, _ = acceleration_feedback(Wanted(1e-3, 0.1, 2.0, 0.09, 700.0), 500.0, LawState(0.0), gains, H)
    assert command == pytest.approx(400.0 * 1e-3 + 3.0 * 0.01 + 0.002 * (2.0 - 200.0 / 34.0))


@pytest.mark.parametrize("velocity", [0.05, -0.2])
def test_valve_inversion_moves_the_piston_as_wanted_against_friction(velocity: float) -> None:
    """In steady motion the flow of the inverted valve is A v, with the pressure that carries the friction."""
    p = parameters(CYLINDER)
    gains = comp.design(comp.Settings(law="valve_inversion"), p, H).law
    friction = float(steady_friction(velocity, p.friction.positive))
    command, _ = valve_inversion(Wanted(0.0, velocity, 0.0, velocity, friction), friction, LawState(0.0), gains, H)
    spool = p.hydraulics.valve_position_gain * command
    drop = p.hydraulics.supply_pressure - math.copysign(1.0, velocity) * friction / 6.33e-4
    assert p.hydraulics.valve_flow_gain * spool * math.sqrt(0.5 * drop) == pytest.approx(6.33e-4 * velocity)


def hydraulic_law(**changed: float) -> Any:
    return comp.design(comp.Settings(law="valve_inversion", **changed), parameters(CYLINDER), H).law


def spool_flow(gains: Any, spool: float, friction: float) -> float:
    """Flow (m^3/s) of an inverted valve whose load takes this force (N)."""
    h = parameters(CYLINDER).hydraulics
    root = math.sqrt(0.5 * (h.supply_pressure - math.copysign(1.0, spool) * friction / h.piston_area_1))
    return float(h.valve_flow_gain * spool * root)


def compliance() -> float:
    """V_t / (4 beta A) (m^3/N)."""
    h = parameters(CYLINDER).hydraulics
    return float(oil_volume(h)) / (4.0 * h.bulk_modulus * float(piston_area(h)))


def test_the_flow_of_compression_is_that_of_the_force_that_rises() -> None:
    """A rod that is held while its force rises by 200 N in a sample takes V_t/(4 beta A) dF/dt."""
    gains = hydraulic_law(compression=0.5)
    _, state = valve_inversion(Wanted(0.0, 0.0, 0.0, 0.0, 0.0), 300.0, LawState(0.0, previous_target=100.0), gains, H)
    assert spool_flow(gains, state.previous_spool, 300.0) == pytest.approx(0.5 * compliance() * 200.0 / H)
    assert state.previous_target == 300.0
    _, state = valve_inversion(Wanted(0.0, 0.0, 0.0, 0.0, 0.0), 300.0, LawState(0.0), gains, H)
    assert state.previous_spool == 0.0, "at the first sample nothing is known of how the force changes"


@pytest.mark.parametrize("washout", [0.0, 2.0])
def test_a_force_loop_forgets_what_lasts_with_its_washout(washout: float) -> None:
    gains, state, count = hydraulic_law(force_rate=5.0, washout=washout), LawState(0.0), 700
    for _ in range(count):
        _, state = valve_inversion(Wanted(0.0, 0.0, 0.0, 0.0, 100.0), 300.0, state, gains, H)
    left = 200.0 * math.exp(-washout * count * H)
    flow = spool_flow(gains, state.previous_spool, 300.0)
    assert flow == pytest.approx(compliance() * 5.0 * left, rel=1e-9)


def test_the_force_source_by_hand() -> None:
    gains = comp.design(comp.Settings(law="force_source"), parameters(), H).law
    command, _ = force_source(Wanted(1e-3, 0.1, 2.0, 0.09, 0.0), 500.0, LawState(0.0), gains, H)
    assert command == pytest.approx(34.0 * (2.0 + 84.0 * 0.01 + 3.6) + 500.0)


@pytest.mark.parametrize(("law", "plant"), [("valve_inversion", DRIVE), ("force_source", CYLINDER)])
def test_a_law_that_the_plant_has_no_use_for_is_refused(law: str, plant: Any) -> None:
    with pytest.raises(ValueError, match="needs a"):
        comp.choose("lugre", comp.Settings(law=law), parameters(plant))


PAIRS = [
    (name, law)
    for name in ESTIMATES
    for law in ("valve_inversion", "acceleration_feedback")
    if (name, law) != ("load_pressure", "acceleration_feedback")
]


@pytest.mark.parametrize(("name", "law"), PAIRS)
def test_every_pair_tracks_no_worse_than_feed_forward(name: str, law: str) -> None:
    run = in_the_loop(name, law, Sine(0.02, 0.5), 6.0)
    assert run.outcome == "completed"
    rms = float(np.sqrt(np.mean(run.signals["error"][run.time >= 2.0] ** 2)))
    assert rms <= 0.238e-3 * 1.02


# --- what a controller may see --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["uncompensated", *ESTIMATES])
def test_no_compensator_reads_the_truth(name: str) -> None:
    """With every true parameter away from its belief the commands follow from measurements and belief alone."""
    factors = {k: 1.1 for k in VALUES if k not in ("load_force", "tank_pressure", "voltage_limit")}
    truth = parameters(CYLINDER, **factors)
    run = in_the_loop(name, "valve_inversion", Sine(0.01, 0.5), 2.0, truth)
    gains = comp.design(comp.Settings(law="valve_inversion"), parameters(CYLINDER), H)
    controller = comp.compensator(name, "valve_inversion", True)
    read: set[str] = set()

    class Watched:
        """A measurement that notes which of its signals are read."""

        def __init__(self, values: np.ndarray) -> None:
            self._values = dict(zip(Measurement._fields, values, strict=True))

        def __getattr__(self, signal: str) -> Any:
            read.add(signal)
            return self._values[signal]

    state = controller.start(Measurement(*run.measurements[0]), gains)
    assert run.reference is not None
    limit = parameters(CYLINDER).hydraulics.voltage_limit
    for k in range(run.time.size):
        reference = Reference(*(part[k] for part in run.reference))
        command, state = controller.step(reference, Watched(run.measurements[k]), state, gains, H)
        assert np.clip(command, -limit, limit) == pytest.approx(run.command[k], rel=1e-9, abs=1e-9)
        state = controller.commit(run.command[k], state, gains, H)
    assert read <= {"position", "pressure_1", "pressure_2", "rotation_speed"}
