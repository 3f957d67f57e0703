"""Linearisation against the thesis's Appendix C, finite differences and python-control's own solver."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import control
import numpy as np
import pytest

from plants.bristles import HelicalBristle
from plants.equation import fields, from_array, to_array
from plants.interface import Plant
from plants.laws.lugre import Bristle
from plants.registry import THESIS, plants
from workbench.errors import UserError
from workbench.linear.linearise import (
    jacobians,
    linearise,
    measurement_jacobian,
    nonlinear_system,
    output_jacobians,
    symbolic,
)
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.references import Sine
from workbench.simulation.simulate import Feed, Integrator, Setup, simulate

SET = read_parameters(named_sets()["owen2001_simulation"])

# Numbers of the thesis's chapter 3, by its symbols.
AREA_1 = AREA_2 = SET["piston_area_1"]
BETA, K, P_S = SET["bulk_modulus"], SET["valve_flow_gain"], SET["supply_pressure"]
VOLUME = 2.0 * SET["hose_volume"] + AREA_1 * SET["stroke"]
M, RADIUS = SET["mass"], SET["piston_radius"]
M_ROTARY = SET["rotary_inertia"] / RADIUS**2
A0, A1, A2, V_S = SET["coulomb"], SET["stribeck"], SET["viscous"], SET["stribeck_velocity"]
S0, S1 = SET["bristle_stiffness"], SET["bristle_damping"]

# Velocity (m/s), load pressure (Pa), bristle deflection (m), spool (m): accelerating, steady, braking, reversing.
MOVING = [
    (0.002, 0.9e6, 9e-5, 5e-6),
    (0.03, 1.1e6, 8.1e-5, 1e-4),
    (0.17, -0.4e6, 6.4e-5, 5e-4),
    (-0.02, -1.3e6, -7e-5, -2e-4),
    (-0.15, 0.7e6, -6e-5, -4e-4),
    (-0.01, 0.2e6, 3e-5, 1e-4),
]


def appendix_c(v: float, load_pressure: float, z: float, spool: float) -> tuple[np.ndarray, np.ndarray]:
    """Partial derivatives of (3.35) to (3.38) by hand, over (x, v, P_L, z) and over x_sv.

    They are those of appendix C.2, (C.12) to (C.34). In (C.24) the two halves of the valve come with opposite signs,
    -S(x_sv)/sqrt(P_s - P_L) + S(-x_sv)/sqrt(P_s + P_L), before a common sqrt(2) beta K x_sv/(2 V_h + A L), so that
    more load pressure slows the flow whichever way the spool is; the scan of the thesis keeps neither that sign nor
    the one of (C.22), d(dP_L/dt)/dv, which is negative.
    """
    e = np.exp(-((v / V_S) ** 2))
    g = A0 + A1 * e
    slope = 2.0 * A1 * v * e / V_S**2  # -dg/dv
    forward, backward = float(spool > 0.0), float(spool < 0.0)
    root_p, root_t = np.sqrt(P_S - load_pressure), np.sqrt(P_S + load_pressure)
    jacobian = np.zeros((4, 4))
    jacobian[0, 1] = 1.0
    jacobian[1, 1] = (S0 * S1 * abs(v) * z * slope / g**2 + S0 * S1 * z * np.sign(v) / g - S1 - A2) / M  # C.18
    jacobian[1, 2] = (AREA_1 + AREA_2) / (2.0 * M)  # C.19
    jacobian[1, 3] = (-S0 + S0 * S1 * abs(v) / g) / M  # C.20
    jacobian[2, 1] = -2.0 * BETA * (AREA_1 + AREA_2) / VOLUME  # C.22
    halves = -forward / root_p + backward / root_t
    jacobian[2, 2] = np.sqrt(2.0) * BETA * K * spool / VOLUME * halves  # C.24
    jacobian[3, 1] = 1.0 - S0 * np.sign(v) * z / g - S0 * abs(v) * z * slope / g**2  # C.28
    jacobian[3, 3] = -S0 * abs(v) / g  # C.30
    flow = 4.0 * BETA * K / VOLUME * (forward * root_p + backward * root_t) / np.sqrt(2.0)
    return jacobian, np.array([0.0, 0.0, flow, 0.0])  # C.31 to C.34


APPENDIX_C = ("position", "velocity", "load_pressure", "bristle_deflection", "spool_position")
"""States in the order of its matrices."""

HELICAL = plants()["rotating_helical"]


@pytest.mark.parametrize("point", MOVING)
def test_non_rotating_jacobian_is_appendix_c(point: tuple[float, ...]) -> None:
    parameters = build(THESIS.Parameters, SET)
    v, load_pressure, z, spool = point
    _, inputs = THESIS.equilibrium(parameters, 0.0)
    a, b = jacobians(THESIS, parameters, THESIS.State(0.01, v, load_pressure, spool, Bristle(z)), inputs)
    names = [item.name for item in fields(THESIS.State)]
    order = [names.index(name) for name in APPENDIX_C]
    a, b = a[np.ix_(order, order)], b[order]
    expected, by_spool = appendix_c(*point)
    np.testing.assert_allclose(a[:4, :4], expected, rtol=1e-10)
    np.testing.assert_allclose(a[:4, 4], by_spool, rtol=1e-10)
    tau, gain = SET["valve_time_constant"], SET["valve_position_gain"]
    np.testing.assert_allclose(a[4], [0.0, 0.0, 0.0, 0.0, -1.0 / tau], rtol=1e-12)
    np.testing.assert_allclose(b[:, 0], [0.0, 0.0, 0.0, 0.0, gain / tau], rtol=1e-12)
    np.testing.assert_allclose(b[:, 1], [0.0, -1.0 / M, 0.0, 0.0, 0.0], rtol=1e-12)


@pytest.mark.parametrize("surface_speed", [0.1, 0.9])
@pytest.mark.parametrize(("v", "z"), [(0.02, 6e-5), (-0.15, 6.4e-5)])
def test_rotating_jacobian_is_appendix_c(v: float, z: float, surface_speed: float) -> None:
    """The friction of (3.51), (3.53), (3.54) differentiated by hand over (v, w, z): (C.44), (C.46), (C.58) to (C.67).

    F_axial  = v (sigma0 z/v_h + sigma1 + a2 - sigma0 sigma1 z/g(v_h)),  F_rotary the same with w,
    dz/dt    = v_h (1 - sigma0 z/g(v_h))
    """
    w = surface_speed
    h = np.hypot(v, w)
    e = np.exp(-((h / V_S) ** 2))
    g = A0 + A1 * e
    slope = 2.0 * A1 * e / V_S**2  # -dg/dv / v = -dg/dw / w
    share = S0 * z / h + S1 + A2 - S0 * S1 * z / g
    cross = -S0 * z / h**3 - S0 * S1 * z * slope / g**2  # d(share)/dv / v = d(share)/dw / w
    bend = (1.0 - S0 * z / g) / h - S0 * z * h * slope / g**2
    over_z = S0 / h - S0 * S1 / g
    expected = [
        [-(share + v * v * cross) / M, -v * w * cross / M, -v * over_z / M],
        [-v * w * cross / M_ROTARY, -(share + w * w * cross) / M_ROTARY, -w * over_z / M_ROTARY],
        [v * bend, w * bend, -S0 * h / g],
    ]
    parameters = build(HELICAL.Parameters, SET)
    state = HELICAL.State(0.01, v, 1e6, 1e-4, HelicalBristle(z), w, 5.0)
    a, b = jacobians(HELICAL, parameters, state, HELICAL.Inputs(1.0, 20.0, 0.0))
    names = [item.name for item in fields(HELICAL.State)]
    chosen = [names.index(name) for name in ("velocity", "surface_speed", "bristle_deflection")]
    np.testing.assert_allclose(a[np.ix_(chosen, chosen)], expected, rtol=1e-9)
    current, speed = names.index("motor_current"), names.index("surface_speed")
    inductance = SET["motor_inductance"]
    assert a[speed, current] == pytest.approx(SET["torque_constant"] / (RADIUS * M_ROTARY), rel=1e-12)
    assert a[current, current] == pytest.approx(-SET["motor_resistance"] / inductance, rel=1e-12)
    assert a[current, speed] == pytest.approx(-SET["back_emf_constant"] / (RADIUS * inductance), rel=1e-12)
    assert b[current, 1] == pytest.approx(1.0 / inductance, rel=1e-12)


def central_differences(
    function: Callable[[np.ndarray], np.ndarray], point: np.ndarray, scales: np.ndarray
) -> np.ndarray:
    """Jacobian of `function`, each column times its scale; steps of 1e-5 of the scale leave 1e-10 of truncation."""
    columns = []
    for i, scale in enumerate(scales):
        step = np.zeros_like(point)
        step[i] = 1e-5 * scale
        columns.append((function(point + step) - function(point - step)) / 2e-5)
    return np.column_stack(columns)


@pytest.mark.parametrize("seed", range(4))
def test_jacobians_are_finite_differences(plant: Plant, parameters: Any, seed: int) -> None:
    random = np.random.default_rng(seed)
    rest, holding = plant.equilibrium(parameters, 0.9)
    scales = np.array([item.scale for item in fields(plant.State)])
    sides = random.choice([-1.0, 1.0], scales.size)
    x = to_array(rest) + sides * random.uniform(0.2, 1.5, scales.size) * scales
    u = to_array(holding) + random.uniform(0.2, 2.0, len(fields(plant.Inputs)))
    ones = np.ones_like(u)

    def rates(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        state, inputs = from_array(plant.State, x), from_array(plant.Inputs, u)
        return to_array(plant.derivatives(0.0, state, inputs, parameters))

    def signals(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        state, inputs = from_array(plant.State, x), from_array(plant.Inputs, u)
        return to_array(plant.signals(0.0, state, inputs, parameters))

    state, inputs = from_array(plant.State, x), from_array(plant.Inputs, u)
    names = [item.name for item in fields(plant.Signals)]
    a, b = jacobians(plant, parameters, state, inputs)
    c, d = output_jacobians(plant, parameters, state, inputs, names)
    for over_state, over_inputs, function in ((a, b, rates), (c, d, signals)):
        exact = np.hstack([over_state * scales, over_inputs])
        numeric = np.hstack(
            [
                central_differences(lambda x, f=function: f(x, u), x, scales),
                central_differences(lambda u, f=function: f(x, u), u, ones),
            ]
        )
        rows = np.max(np.abs(exact), axis=1, keepdims=True)
        assert np.max(np.abs(exact - numeric) / np.where(rows > 0.0, rows, 1.0)) < 1e-6


def test_measurement_jacobian_is_finite_differences(plant: Plant, parameters: Any) -> None:
    state, _ = plant.equilibrium(parameters, 0.9)
    scales = np.array([item.scale for item in fields(plant.State)])
    x = to_array(state) + np.random.default_rng(5).uniform(0.2, 1.5, scales.size) * scales

    def readings(x: np.ndarray) -> np.ndarray:
        return np.nan_to_num(to_array(plant.measure(from_array(plant.State, x), parameters)))

    exact = measurement_jacobian(plant, parameters, from_array(plant.State, x)) * scales
    np.testing.assert_allclose(exact, central_differences(readings, x, scales), rtol=1e-6, atol=1e-6)


def test_state_space_carries_names_and_chosen_outputs() -> None:
    parameters = build(THESIS.Parameters, SET)
    state = THESIS.State(0.0, 0.03, 1.1e6, 1e-4, Bristle(8.1e-5))
    _, inputs = THESIS.equilibrium(parameters, 0.0)
    model = linearise(THESIS, parameters, state, inputs, outputs=("velocity", "pressure_1", "axial_friction"))
    assert model.state_labels == ["position", "velocity", "load_pressure", "spool_position", "bristle_deflection"]
    assert model.input_labels == ["valve_voltage", "disturbance_force"]
    assert model.output_labels == ["velocity", "pressure_1", "axial_friction"]
    a, b = jacobians(THESIS, parameters, state, inputs)
    np.testing.assert_array_equal(model.A, a)
    np.testing.assert_array_equal(model.B, b)
    np.testing.assert_allclose(model.C[:2], [[0, 1, 0, 0, 0], [0, 0, 0.5, 0, 0]], atol=0.0)
    np.testing.assert_allclose(model.C[2, [1, 4]], -M * a[1, [1, 4]], rtol=1e-12)  # friction alone depends on v, z


def test_at_rest_the_piston_is_a_mass_on_oil_and_bristles() -> None:
    """Without the valve's integrator: M s^2 + (sigma1 + a2) s + sigma0 + 4 beta A^2/V_t (1207 rad/s for oil alone)."""
    parameters = build(THESIS.Parameters, SET)
    poles = linearise(THESIS, parameters).poles()
    oil = 4.0 * BETA * AREA_1**2 / VOLUME
    assert np.sqrt(oil / M) == pytest.approx(1207.0, abs=0.5)
    pair = np.roots([M, S1 + A2, S0 + oil])
    expected = np.sort_complex([0.0, 0.0, -1.0 / SET["valve_time_constant"], *pair])
    np.testing.assert_allclose(np.sort_complex(poles), expected, rtol=1e-8, atol=1e-3)


@pytest.mark.parametrize(("plant_", "rpm"), [(THESIS, 0.0), (HELICAL, 120.0)], ids=["non_rotating", "helical"])
def test_open_loop_response_is_that_of_python_control(plant_: Plant, rpm: float) -> None:
    """A voltage sine through python-control (scipy's LSODA) and through the compiled simulation."""
    parameters = build(plant_.Parameters, SET)
    state, inputs = plant_.equilibrium(parameters, rpm * 2.0 * np.pi / 60.0 * RADIUS)
    outputs = ("position", "velocity", "load_pressure", "axial_friction")
    setup = Setup(plant_, parameters, state, inputs, 0.125, feeds=(Feed("valve_voltage", Sine(3.0, 8.0)),))
    run = simulate(replace(setup, integrator=Integrator(tolerance=1e-11)))
    theirs = control.input_output_response(
        nonlinear_system(plant_, parameters, outputs),
        run.time,
        run.inputs.T,
        to_array(state),
        solve_ivp_kwargs={"method": "LSODA", "rtol": 1e-10, "atol": 1e-13},
    )
    for name, response in zip(outputs, theirs.outputs, strict=True):
        ours = run.signals[name]
        assert np.max(np.abs(ours)) > 0.0
        assert np.max(np.abs(ours - response)) < 1e-7 * np.max(np.abs(ours)), name


def test_unknown_output_names_the_nearest() -> None:
    parameters = build(THESIS.Parameters, SET)
    message = 'plant non_rotating has no signal "axial_fricton"; did you mean "axial_friction"?'
    with pytest.raises(UserError) as error:
        linearise(THESIS, parameters, outputs=("axial_fricton",))
    assert str(error.value) == message
    with pytest.raises(UserError) as error:
        nonlinear_system(THESIS, parameters, ("position", "axial_fricton"))
    assert str(error.value) == message


def test_threads_may_linearise_at_once() -> None:
    """CasADi's switch for NumPy's functions is one for the whole process; without it a warning is raised."""
    with ThreadPoolExecutor(4) as executor:
        made = list(executor.map(lambda _: symbolic.__wrapped__(THESIS), range(40)))
    assert {function.name() for function in made} == {THESIS.name}
