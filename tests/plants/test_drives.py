"""Drives: straight and turning ones alike, and a compliance between motor and load, against equations written anew."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plants.effects.registry import effects
from plants.equation import fields, from_array, to_array
from plants.interface import Plant
from plants.registry import plants
from workbench.linear.linearise import linearise
from workbench.parameters.sets import build
from workbench.simulation.references import Triangle
from workbench.simulation.setup import Feed, Integrator, Setup
from workbench.simulation.simulate import simulate

MASS, MOTOR_MASS, LOAD = 0.2, 0.05, 1.5
"""kg and N, or kg m^2 and N m."""

CONTACT = {
    "coulomb": 6.0,
    "stribeck": 4.0,
    "viscous": 3.0,
    "stribeck_velocity": 5e-3,
    "bristle_stiffness": 5e4,
    "bristle_damping": 150.0,
}
COUPLING = {"motor_viscous": 1.0, "coupling_stiffness": 2e4, "coupling_damping": 5.0}
ALIKE = {**CONTACT, **COUPLING, "end_stop_stiffness": 0.0, "end_stop_damping": 0.0}
"""What has one name on either axis."""

STRAIGHT = {"mass": MASS, "load_force": LOAD, "motor_mass": MOTOR_MASS, **ALIKE}
TURNING = {"inertia": MASS, "load_torque": LOAD, "motor_inertia": MOTOR_MASS, **ALIKE}

PUSH, FREQUENCY = 14.0, 2.0
"""N (N m) and Hz of the drive: beyond break-away, so that the load sticks and slips at each reversal."""

DURATION, SAMPLES = 1.0, 1001
CORNERS = np.concatenate([[0.0], np.arange(0.125, DURATION, 0.25), [DURATION]])
"""s. There the drive's triangle turns: no step of a solver goes across."""

Rates = Callable[[float, np.ndarray], Any]


def driven(plant: Plant, values: dict[str, float], tolerance: float = 1e-11) -> Any:
    """A second of stick-slip from rest, the load held, under a triangle."""
    parameters = build(plant.Parameters, values)
    state, inputs = plant.equilibrium(parameters, 0.0)
    feeds = (Feed(plant.command, Triangle(PUSH, FREQUENCY)),)
    run = simulate(
        Setup(plant, parameters, state, inputs, DURATION, feeds=feeds, integrator=Integrator(tolerance=tolerance))
    )
    assert run.outcome == "completed"
    return run


def push(time: float) -> float:
    """Force (N) of the drive."""
    return LOAD + float(Triangle(PUSH, FREQUENCY)(np.array([time]))[0][0])


def solved(rates: Rates, start: Any, corners: np.ndarray = CORNERS, exact: float = 1e-12) -> np.ndarray:
    """States (n, samples) by scipy's LSODA, from corner to corner of the drive."""
    time, parts, state = np.linspace(0.0, DURATION, SAMPLES), [], np.asarray(start, dtype=float)
    for begin, end in pairwise(corners.tolist()):
        own = time[(time >= begin - 1e-12) & (time <= end + 1e-12)]
        own[[0, -1]] = begin, end
        found = solve_ivp(rates, (begin, end), state, "LSODA", own, rtol=exact, atol=1e-2 * exact)
        assert found.success
        parts.append(found.y[:, :-1])
        state = found.y[:, -1]
    return np.column_stack([*parts, state])


def lugre(velocity: float, bristle: float) -> tuple[float, float, float]:
    """Friction (N), the bristle's rate (m/s), and the power (W) that is lost: not that which bends the bristle."""
    c = CONTACT
    level = c["coulomb"] + c["stribeck"] * np.exp(-((velocity / c["stribeck_velocity"]) ** 2))
    slip = c["bristle_stiffness"] * abs(velocity) * bristle / level
    rate = velocity - slip
    force = c["bristle_stiffness"] * bristle + c["bristle_damping"] * rate + c["viscous"] * velocity
    return force, rate, force * velocity - c["bristle_stiffness"] * bristle * rate


def one_mass(time: float, y: np.ndarray) -> list[float]:
    """x, v, z of a mass that sticks and slips under the drive and a load, written down again."""
    friction, rate, _ = lugre(y[1], y[2])
    return [y[1], (push(time) - friction - LOAD) / MASS, rate]


def two_masses(time: float, y: np.ndarray) -> list[float]:
    """x, v, z of the load, s = x_m - x, v_m: motor and load with a spring and a damper between them."""
    friction, rate, _ = lugre(y[1], y[2])
    between = COUPLING["coupling_stiffness"] * y[3] + COUPLING["coupling_damping"] * (y[4] - y[1])
    motor = (push(time) - COUPLING["motor_viscous"] * y[4] - between) / MOTOR_MASS
    return [y[1], (between - friction - LOAD) / MASS, rate, y[4] - y[1], motor]


@pytest.mark.parametrize(
    ("name", "rates", "start"),
    [
        ("drive_force", one_mass, [0.0, 0.0, 0.0]),
        ("two_mass_force", two_masses, [0.0, 0.0, 0.0, LOAD / COUPLING["coupling_stiffness"], 0.0]),
    ],
)
def test_stick_slip_is_that_of_the_equations_by_another_solver(name: str, rates: Rates, start: list[float]) -> None:
    run, expected = driven(plants()[name], STRAIGHT), solved(rates, start)
    velocity = run.state("velocity")
    assert 0.1 < np.mean(np.abs(velocity) < CONTACT["stribeck_velocity"]) < 0.9  # it sticks, and slips
    assert np.ptp(run.state("position")) > 0.02
    assert np.max(np.abs(run.state("position") - expected[0])) < 1e-9
    if name.startswith("two"):
        twist = run.state("twist")
        assert np.max(np.abs(twist - expected[3])) < 1e-8
        assert np.ptp(twist) > 1e-4


def stored(name: str, y: np.ndarray) -> float:
    """Energy (J) of motion, of the bent bristle and of the coupling."""
    energy = 0.5 * MASS * y[1] ** 2 + 0.5 * CONTACT["bristle_stiffness"] * y[2] ** 2
    if name.startswith("two"):
        energy += 0.5 * COUPLING["coupling_stiffness"] * y[3] ** 2 + 0.5 * MOTOR_MASS * y[4] ** 2
    return float(energy)


@pytest.mark.parametrize("name", ["drive_force", "two_inertia_torque"])
def test_energy_closes(name: str) -> None:
    """What the motor puts in less what friction, dampers and load take is what is stored, to 1e-6 of what is moved."""
    plant = plants()[name]
    parameters = build(plant.Parameters, TURNING if plant.axis == "rad" else STRAIGHT)
    state, inputs = plant.equilibrium(parameters, 0.0)
    names = [item.name for item in fields(plant.State)]
    count, own_order = len(names), ("position", "velocity", "bristle_deflection", "twist", "motor_velocity")
    order = [names.index(each) for each in own_order if each in names]

    def rates(time: float, whole: np.ndarray) -> np.ndarray:
        state, y = from_array(plant.State, whole[:count]), whole[order]
        given = inputs._replace(**{inputs._fields[0]: push(time)})
        own = to_array(plant.derivatives(time, state, given, parameters))
        moved = y[4] if name.startswith("two") else y[1]
        taken = lugre(y[1], y[2])[2] + LOAD * y[1]
        if name.startswith("two"):
            taken += COUPLING["motor_viscous"] * y[4] ** 2 + COUPLING["coupling_damping"] * (y[4] - y[1]) ** 2
        return np.array([*own, push(time) * moved, taken, abs(push(time) * moved)])

    start = np.concatenate([to_array(state), np.zeros(3)])
    end = solved(rates, start, CORNERS[:3], 1e-10)[:, -1]
    given, taken, moved = end[count:]
    assert moved > 0.1
    assert abs(given - taken - (stored(name, end[order]) - stored(name, start[order]))) < 1e-6 * moved


@pytest.mark.parametrize(
    ("straight", "turning"), [("drive_force", "rotary_torque"), ("two_mass_force", "two_inertia_torque")]
)
def test_an_axis_that_turns_is_one_that_goes_straight_to_the_last_bit(straight: str, turning: str) -> None:
    one, other = driven(plants()[straight], STRAIGHT, 1e-6), driven(plants()[turning], TURNING, 1e-6)
    assert np.ptp(one.state("position")) > 0.02
    assert np.array_equal(one.states, other.states)
    assert np.array_equal(one.measurements, other.measurements, equal_nan=True)
    assert {name: np.array_equal(one.signals[name], other.signals[name]) for name in ("axial_friction", "acceleration")}
    assert np.array_equal(one.signals["drive_force"], other.signals["drive_torque"])


def test_effects_are_alike_on_both_axes() -> None:
    """Compiled: such as change parameters, inputs and readings, and such as remember."""
    names = ("direction_asymmetry", "position_dependent_friction", "rising_static_friction", "spring_load", "backlash")
    values = {"friction_gradient": 0.3, "static_rise": 0.5, "spring_stiffness": 20.0, "backlash_width": 1e-4}
    runs = []
    for name, own in (("drive_force", STRAIGHT), ("rotary_torque", TURNING)):
        plant = plants()[name].with_effects(*(effects()[effect] for effect in names))
        runs.append(driven(plant, {**own, **values, "stroke": 1.0, "coulomb_negative": 7.0}, 1e-6))
    assert np.array_equal(runs[0].states, runs[1].states)
    assert np.array_equal(runs[0].signals["measured_position"], runs[1].signals["measured_position"])
    assert np.max(np.abs(runs[0].signals["measured_position"] - runs[0].signals["position"])) > 4e-5


def test_a_coupling_that_does_not_give_makes_one_mass_of_both() -> None:
    """What is left of its give falls with its stiffness."""
    whole = {**STRAIGHT, "mass": MASS + MOTOR_MASS, "viscous": CONTACT["viscous"] + COUPLING["motor_viscous"]}
    rigid = driven(plants()["drive_force"], whole, 1e-9).state("position")
    apart = []
    for stiffness in (1e6, 1e8):
        stiff = {**STRAIGHT, "coupling_stiffness": stiffness, "coupling_damping": 2e-4 * stiffness}
        run = driven(plants()["two_mass_force"], stiff, 1e-9)
        apart.append(float(np.max(np.abs(run.state("position") - rigid))))
    assert apart[0] < 2e-5
    assert apart[1] < 0.02 * apart[0]


def test_natural_frequencies_are_those_of_the_textbook() -> None:
    """Poles at sqrt(k (1/M_m + 1/M)), and zeros from the drive to the motor at sqrt(k/M)."""
    plant = plants()["two_inertia_torque"]
    loose = dict.fromkeys(("coulomb", "stribeck", "viscous", "bristle_stiffness", "bristle_damping"), 0.0)
    free = {**TURNING, **loose, "motor_viscous": 0.0, "coupling_damping": 0.0, "load_torque": 0.0}
    parameters = build(plant.Parameters, free)
    state, inputs = plant.equilibrium(parameters, 0.0)
    model = linearise(plant, parameters, state, inputs, ("motor_position",))[0, "drive_torque"]
    stiffness = COUPLING["coupling_stiffness"]
    resonance, antiresonance = np.sqrt(stiffness * (1.0 / MOTOR_MASS + 1.0 / MASS)), np.sqrt(stiffness / MASS)
    assert np.max(np.imag(model.poles())) == pytest.approx(resonance, rel=1e-9)
    assert np.max(np.imag(model.zeros())) == pytest.approx(antiresonance, rel=1e-6)


@pytest.mark.parametrize(("place", "shown"), [(0.0, "motor_position"), (1.0, "position")])
def test_the_sensor_is_at_the_motor_or_at_the_load(place: float, shown: str) -> None:
    run = driven(plants()["two_mass_force"], {**STRAIGHT, "measured_at": place}, 1e-6)
    assert np.array_equal(run.signals["measured_position"], run.signals[shown])
    assert np.ptp(run.signals["motor_position"] - run.signals["position"]) > 1e-4


@pytest.mark.parametrize(
    ("name", "gain", "limit"),
    [
        ("drive_current", {"force_constant": 4.0}, {"current_limit": 2.0}),
        ("rotary_current", {"torque_constant": 4.0}, {"current_limit": 2.0}),
        ("rotary_voltage", {"torque_gain": 4.0}, {"voltage_limit": 2.0}),
        ("two_inertia_current", {"torque_constant": 4.0}, {"current_limit": 2.0}),
    ],
)
def test_a_current_or_a_voltage_drives_through_its_gain(
    name: str, gain: dict[str, float], limit: dict[str, float]
) -> None:
    plant = plants()[name]
    values = TURNING if plant.axis == "rad" else STRAIGHT
    parameters = build(plant.Parameters, {**values, **gain, **limit})
    state, inputs = plant.equilibrium(parameters, 0.0)
    assert inputs[0] == LOAD / 4.0
    assert plant.command_limit(parameters) == 2.0
    force = plant.signals(0.0, state, inputs._replace(**{inputs._fields[0]: 1.5}), parameters).drive_force
    assert force == 6.0


def test_names_and_units_are_those_of_the_axis() -> None:
    drive, rotary = plants()["two_mass_force"], plants()["two_inertia_torque"]
    units = {item.name: item.unit for item in fields(rotary.Parameters)}
    assert len(units) == len(fields(drive.Parameters))
    assert not {"mass", "load_force", "motor_mass", "force_limit"} & units.keys()
    expected = {
        "inertia": "kg m^2",
        "load_torque": "N m",
        "coulomb": "N m",
        "viscous_negative": "N m s/rad",
        "stribeck_velocity": "rad/s",
        "bristle_stiffness": "N m/rad",
        "coupling_stiffness": "N m/rad",
        "torque_limit": "N m",
        "stroke": "rad",
        "end_stop_damping": "s/rad",
    }
    assert {name: units[name] for name in expected} == expected
    assert [(item.name, item.unit) for item in fields(rotary.Inputs)] == [
        ("drive_torque", "N m"),
        ("spring_end", "rad"),
        ("disturbance_torque", "N m"),
    ]
    assert (drive.axis, rotary.axis, rotary.command, rotary.disturbance) == (
        "m",
        "rad",
        "drive_torque",
        "disturbance_torque",
    )
    assert rotary.unit_for("command s/m") == "N m s/rad"
