"""The extended Kalman filter against filterpy's with matrices of CasADi and SciPy, and on simulated rigs."""

import ctypes
import functools
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import casadi
import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from support import registered

from controllers.extended_kalman import (
    ESTIMATE_RANGE,
    Covariance,
    EkfGains,
    EkfSettings,
    EkfState,
    believed_friction,
    believed_rates,
    design_ekf,
    ekf_at_rest,
    ekf_update,
    floored,
    hold,
)
from controllers.pid import PID
from controllers.velocity import at_rest, estimate_velocity, filtered_differentiator
from plants.equation import from_array, size_of, to_array
from plants.interface import Measurement
from plants.registry import THESIS
from workbench.recording.machine_code import machine_code
from workbench.simulation.references import Sine, Triangle
from workbench.simulation.sensors import Channel, Sensors
from workbench.simulation.simulate import Loop, Run, simulate

H = 1e-3
BELIEF: Any = registered("non_rotating", duration=1.0).parameters
RIG = Sensors({"position": Channel(13e-6), "pressure_1": Channel(2e3), "pressure_2": Channel(2e3)})
MOTIONS = {"sine": (Sine(0.02, 0.5), 4.0), "triangle": (Triangle(2e-3, 0.25), 8.0)}
SETTLED = 200
"""Samples that the estimates get to forget the start."""


def scaled(level: float) -> Any:
    """The believed plant with Coulomb and Stribeck level scaled."""
    sides = (side._replace(coulomb=level * side.coulomb, stribeck=level * side.stribeck) for side in BELIEF.friction)
    return BELIEF._replace(friction=type(BELIEF.friction)(*sides))


def rig(motion: str, truth: Any = BELIEF) -> Run:
    """A P-controlled run of the true plant with the sensors' noise."""
    reference, duration = MOTIONS[motion]
    gains = PID.design(PID.Settings(kp=500.0), BELIEF, H)
    setup = registered("non_rotating", duration=duration, reference=reference, loop=Loop(PID, gains), seed=3)
    return simulate(replace(setup, parameters=truth, sensors=RIG))


class Core(NamedTuple):
    """What of the estimates moves by the model's rates."""

    velocity: float
    load_pressure: float
    bristle: float


class Estimated(NamedTuple):
    """What an update gives."""

    velocity: float
    load_pressure: float
    friction: float
    state: EkfState


@functools.cache
def compiled_update() -> Callable[..., None]:
    """The update of a sample as the program compiles it."""

    def update(measurement: Measurement, realised: Any, state: EkfState, gains: EkfGains) -> Estimated:
        return Estimated(*ekf_update(measurement, realised, state, gains, H))

    return machine_code(update, (Measurement, None, EkfState, EkfGains), into=4).ctypes


def compiled_estimates(
    readings: np.ndarray, volts: np.ndarray, state: EkfState, gains: EkfGains
) -> tuple[np.ndarray, np.ndarray]:
    """Velocity, load pressure, friction, bristle; and the ten numbers of the covariance, at each sample."""
    reading, now, given = np.zeros(size_of(Measurement)), to_array(state), to_array(gains)
    then = np.empty(3 + now.size)
    places = [array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for array in (reading, now, given, then)]
    found, spread = np.empty((volts.size, 4)), np.empty((volts.size, 10))
    for k in range(volts.size):
        reading[:4] = readings[k, :4]
        compiled_update()(places[0], volts[k - 1] if k > 0 else 0.0, *places[1:])
        now[:] = then[3:]
        after = from_array(EkfState, now)
        found[k], spread[k] = (*then[:3], after.bristle), after.covariance
    return found, spread


def estimates(run: Run, choice: EkfSettings = EkfSettings()) -> np.ndarray:  # noqa: B008 (an immutable tuple)
    gains = design_ekf(BELIEF, choice, H)
    start = ekf_at_rest(Measurement(*run.measurements[0]), gains)
    return compiled_estimates(run.measurements, run.command, start, gains)[0]


def full(upper: Any) -> np.ndarray:
    """The 4 x 4 matrix of a covariance's ten numbers."""
    matrix = np.zeros((4, 4))
    matrix[np.triu_indices(4)] = upper
    return matrix + np.triu(matrix, 1).T


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values[SETTLED:] ** 2)))


# --- the model -----------------------------------------------------------------------------------------------


def symbolic_model(gains: EkfGains) -> casadi.Function:
    """(velocity, load pressure, bristle), spool -> rates and their Jacobian by CasADi's differentiation."""
    core, spool = casadi.SX.sym("core", 3), casadi.SX.sym("spool")
    before = casadi.GlobalOptions.getNumpyMode()
    casadi.GlobalOptions.setNumpyMode(1)
    try:
        rates, _ = believed_rates(*casadi.vertsplit(core), spool, gains)
    finally:
        casadi.GlobalOptions.setNumpyMode(before)
    column = casadi.vertcat(*rates)
    return casadi.Function("model", [core, spool], [column, casadi.jacobian(column, core)])


CORES = [
    (0.03, 4e5, 5e-5, 1e-4),
    (-0.03, 4e5, 5e-5, -2e-4),
    (0.002, -2e6, 9e-5, 5e-4),
    (-1.0, 2.5e6, 6e-5, 6e-4),
    (1e-7, 1e5, 2e-5, 0.0),
    (5.0, 1e6, 6e-5, 3e-4),
]
"""Velocity, load pressure, bristle, spool; the last so fast that the bristle is slowed."""


@pytest.mark.parametrize("core", CORES)
def test_jacobian_is_that_of_the_rates(core: tuple[float, ...]) -> None:
    hydraulics = BELIEF.hydraulics._replace(
        valve_overlap=2e-5, valve_overlap_negative=2e-5, leakage_coefficient=1e-13, external_leakage_1=2e-13
    )
    gains = design_ekf(BELIEF._replace(hydraulics=hydraulics), EkfSettings(), H)
    expected_rates, expected = symbolic_model(gains)(core[:3], core[3])
    rates, jacobian = believed_rates(*core, gains)
    assert to_array(rates) == pytest.approx(expected_rates.full().ravel(), rel=1e-12)
    assert to_array(jacobian) == pytest.approx(expected.full().ravel(), rel=1e-11, abs=1e-12)


@pytest.mark.parametrize("core", CORES[:5])
def test_rates_are_those_of_the_plant(core: tuple[float, ...]) -> None:
    """Without the bristle's damping, which the filter lets fade with speed; a closed valve's limits apart."""
    sides = (side._replace(bristle_damping=0.0) for side in BELIEF.friction)
    belief = BELIEF._replace(friction=type(BELIEF.friction)(*sides))
    velocity, pressure, bristle, spool = core
    state = from_array(THESIS.State, [0.0, velocity, pressure, spool, bristle])
    truth = THESIS.derivatives(0.0, state, THESIS.Inputs(0.0, 0.0), belief)
    rates, _ = believed_rates(*core, design_ekf(belief, EkfSettings(), H))
    expected = [truth.velocity, truth.load_pressure, truth.contact.bristle_deflection]
    assert to_array(rates) == pytest.approx(np.array(expected, dtype=float), rel=1e-13)


def exact_hold(rates: np.ndarray, jacobian: np.ndarray, h: float) -> np.ndarray:
    """exp of position, core and a constant 1: 5 x 5, by SciPy."""
    whole = np.zeros((5, 5))
    whole[0, 1] = 1.0
    whole[1:4, 1:4], whole[1:4, 4] = jacobian, rates
    size = np.array([1e-3, 1.0, 1e6, 1e-4, 1.0])
    return size[:, None] * expm(h * whole * size / size[:, None]) / size


@pytest.mark.parametrize("core", CORES)
def test_hold_is_the_matrix_exponential(core: tuple[float, ...]) -> None:
    gains = design_ekf(BELIEF, EkfSettings(), H)
    rates, jacobian = believed_rates(*core, gains)
    power, step, travel, rest = hold(rates, jacobian, H)
    expected = exact_hold(to_array(rates), to_array(jacobian).reshape(3, 3), H)
    size = np.array([1e-3, 1.0, 1e6, 1e-4])
    found = np.column_stack([np.vstack([travel, to_array(power).reshape(3, 3)]), [rest, *step]])
    columns = [*size[1:], 1.0]
    assert found * columns / size[:, None] == pytest.approx(expected[:4, 1:] * columns / size[:, None], abs=1e-9)


def test_step_is_of_second_order() -> None:
    """Steps of the local linearisation over 8 ms of braking from 50 mm/s, against an implicit solver."""
    gains, spool, start = design_ekf(BELIEF, EkfSettings(), H), 2e-5, np.array([0.05, 8e5, 7e-5])

    compiled = machine_code(lambda core, gains: believed_rates(*core, spool, gains)[0], (Core, EkfGains), into=2).ctypes
    place, given, rates = np.zeros(3), to_array(gains), np.zeros(3)
    places = [array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for array in (place, given, rates)]

    def slope(_: float, core: np.ndarray) -> np.ndarray:
        place[:] = core
        compiled(*places)
        return rates.copy()

    exact = solve_ivp(slope, (0.0, 8e-3), start, "Radau", rtol=1e-12, atol=1e-16).y[:, -1]

    def error(steps: int) -> float:
        core = start
        for _ in range(steps):
            core = core + to_array(hold(*believed_rates(*core, spool, gains), 8e-3 / steps)[1])
        return float(np.max(np.abs(core / exact - 1.0)))

    assert np.log2(error(64) / error(128)) == pytest.approx(2.0, abs=0.1)
    assert error(8) < 0.02


# --- the filter ----------------------------------------------------------------------------------------------


SIZE = np.array([1e-5, 1e-2, 1e3, 1e-5])
"""m, m/s, Pa, m. filterpy inverts matrices, which in SI are ill-conditioned: its states are counted in these."""


class ByMatrices(ExtendedKalmanFilter):
    """filterpy's filter with the plant's model from CasADi's Jacobian and SciPy's exponential."""

    def __init__(self, gains: EkfGains, start: EkfState) -> None:
        super().__init__(dim_x=4, dim_z=2)
        self.model, self.h, self.spool = symbolic_model(gains), gains.hydraulics, 0.0
        self.x, self.P = np.array(start[:4]) / SIZE, full(start.covariance) / np.outer(SIZE, SIZE)
        self.Q, self.R = np.diag(gains.noise[2:] / SIZE**2), np.diag(gains.noise[:2] / SIZE[[0, 2]] ** 2)

    def predict_x(self, u: float = 0.0) -> None:
        target = np.clip(self.h.valve_position_gain * u, -self.h.spool_limit, self.h.spool_limit)
        lag = self.h.valve_time_constant
        mean = target + (self.spool - target) * lag / H * -np.expm1(-H / lag)
        self.spool = target + (self.spool - target) * np.exp(-H / lag)
        state = self.x * SIZE
        rates, jacobian = (part.full() for part in self.model(state[1:], mean))
        whole = exact_hold(rates.ravel(), jacobian, H)
        self.F = whole[:4, :4] * SIZE / SIZE[:, None]
        self.x = (state + whole[:4, 4] + np.array([H * state[1], 0.0, 0.0, 0.0])) / SIZE


@pytest.mark.parametrize("motion", MOTIONS)
def test_estimates_are_those_of_filterpy(motion: str) -> None:
    run = rig(motion)
    samples = 600
    gains = design_ekf(BELIEF, EkfSettings(), H)
    start = ekf_at_rest(Measurement(*run.measurements[0]), gains)
    found, spread = compiled_estimates(run.measurements[:samples], run.command[:samples], start, gains)
    reference, select = ByMatrices(gains, start), np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
    means, spreads = [], []
    for k, reading in enumerate(run.measurements[:samples]):
        reference.predict(run.command[k - 1] if k else 0.0)
        reference.update(
            np.array([reading[0], reading[1] - reading[2]]) / SIZE[[0, 2]],
            lambda _: select,
            lambda state: select @ state,
        )
        means.append(reference.x[1:])
        spreads.append((reference.P * np.outer(SIZE, SIZE))[np.triu_indices(4)])
    assert found[:, [0, 1, 3]] / SIZE[1:] == pytest.approx(np.array(means), abs=1e-9)
    assert spread == pytest.approx(np.array(spreads), rel=1e-9)


def test_compiled_equals_plain_python() -> None:
    run = rig("sine")
    gains = design_ekf(BELIEF, EkfSettings(), H)
    state = ekf_at_rest(Measurement(*run.measurements[0]), gains)
    found, spread = compiled_estimates(run.measurements[:80], run.command[:80], state, gains)
    for k, reading in enumerate(run.measurements[:80]):
        realised = float(run.command[k - 1]) if k else 0.0
        velocity, pressure, friction, state = ekf_update(Measurement(*map(float, reading)), realised, state, gains, H)
        assert [velocity, pressure, friction] == pytest.approx(found[k, :3], rel=1e-9, abs=1e-12)
    assert to_array(state.covariance) == pytest.approx(spread[-1], rel=1e-9)


@pytest.mark.parametrize("motion", MOTIONS)
def test_velocity_is_better_than_a_differentiator_s(motion: str) -> None:
    """5.7 mm/s rms by the differentiator of 2 ms, of which the noise alone makes 13 um / 2 ms * 0.88; 0.1 mm/s here."""
    run = rig(motion)
    found, velocity = estimates(run), run.state("velocity")
    state, design = at_rest(run.measurements[0, 0]), filtered_differentiator(2e-3, H)
    differentiated = np.empty(velocity.size)
    for k, position in enumerate(run.measurements[:, 0]):
        differentiated[k], state = estimate_velocity(position, state, design)
    by_difference = rms(differentiated - velocity)
    assert by_difference == pytest.approx(5.7e-3, rel=0.02)
    assert rms(found[:, 0] - velocity) < by_difference / 40.0
    assert rms(found[:, 1] - run.state("load_pressure")) < 2e3 * np.sqrt(2.0) * 1.02
    assert rms(found[:, 2] - run.signals["axial_friction"]) < 5.0


@pytest.mark.parametrize(("motion", "share"), [("sine", 0.5), ("triangle", 0.1)])
def test_friction_above_the_believed_level_is_followed(motion: str, share: float) -> None:
    """Coulomb and Stribeck level 1.3 times the belief: at least 111 N that a model without measurements would miss.

    At 2 mm/s the filter finds nearly all of it; at 63 mm/s the bristle forgets each correction within a sample.
    """
    run = rig(motion, scaled(1.3))
    found = estimates(run)
    assert rms(found[:, 2] - run.signals["axial_friction"]) < share * 0.3 * 370.0
    assert rms(found[:, 0] - run.state("velocity")) < 1e-3
    stubborn = estimates(run, EkfSettings(friction_noise=5.0))
    assert rms(stubborn[:, 2] - run.signals["axial_friction"]) > 2.0 * rms(found[:, 2] - run.signals["axial_friction"])


def test_nothing_moves_at_rest() -> None:
    """A load of 400 N, held by the pressures, closed valve: no velocity, no friction."""
    belief = BELIEF._replace(body=BELIEF.body._replace(load_force=400.0))
    state, _ = THESIS.equilibrium(belief, 0.0)
    reading = THESIS.measure(state, belief)
    gains = design_ekf(belief, EkfSettings(), H)
    readings = np.tile(np.array(reading), (300, 1))
    found, _ = compiled_estimates(readings, np.zeros(300), ekf_at_rest(reading, gains), gains)
    assert found[-1] == pytest.approx([0.0, 400.0 / 6.33e-4, 0.0, 0.0], abs=1e-6)


LEVELS = [1.0, 0.0]
"""Share of the Coulomb level: as believed, and none, for which g falls to its floor away from v = 0."""


@settings(max_examples=40, deadline=None)
@given(
    speed=st.floats(1e-4, 1.0),
    frequency=st.floats(0.3, 40.0),
    level=st.sampled_from(LEVELS),
    kind=st.sampled_from(
        [EkfSettings(), EkfSettings(1e-7, 10.0, 1e-2, 1e-9, 0.1), EkfSettings(1e-4, 1e5, 1e3, 1e-4, 1e3)]
    ),
    seed=st.integers(0, 999),
)
def test_covariance_stays_positive_definite(
    speed: float, frequency: float, level: float, kind: EkfSettings, seed: int
) -> None:
    """Motions up to 1 m/s with pressures and voltages that have nothing to do with them, whatever the noise.

    The bounds: of the velocity 3 times 10 V of 0.0678 m/s per V, of the bristle 3 times (a0 + a1) / sigma0.
    """
    draw = np.random.default_rng(seed)
    sides = (side._replace(coulomb=level * side.coulomb) for side in BELIEF.friction)
    gains = design_ekf(BELIEF._replace(friction=type(BELIEF.friction)(*sides)), kind, H)
    time, w = H * np.arange(400), 2.0 * np.pi * frequency
    load = 2.9e6 * np.sin(2.0 * np.pi * draw.uniform(0.0, 60.0) * time)
    readings = np.column_stack([speed / w * np.sin(w * time), 0.5 * load, -0.5 * load, 0.0 * time])
    readings[:, :3] += draw.standard_normal((400, 3)) * [1e-5, 2e3, 2e3]
    volts = 10.0 * np.sign(draw.standard_normal(400))
    start = ekf_at_rest(Measurement(*readings[0]), gains)
    found, spread = compiled_estimates(readings, volts, start, gains)
    assert np.all(np.isfinite(found))
    assert np.max(np.abs(found[:, 0])) <= ESTIMATE_RANGE * 0.678 * 1.001
    assert np.max(np.abs(found[:, 1])) < 3.0 * 2.94e6
    assert np.max(np.abs(found[:, 3])) <= ESTIMATE_RANGE * (level * 370.0 + 217.0) / 5.77e6 * (1.0 + 1e-12)
    covariances = np.array([full(row) for row in spread])
    deviations = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))
    correlations = covariances / deviations[:, :, None] / deviations[:, None, :]
    assert np.min(np.linalg.eigvalsh(correlations)) > 0.0


def test_floor_keeps_the_diagonal_off_zero() -> None:
    """A thousandth of a sample's process noise; force 5 N on 34 kg for 1 ms, bristle 150 N on 5.77e6 N/m."""
    nothing = floored(Covariance(*[0.0] * 10), design_ekf(BELIEF, EkfSettings(), H).noise)
    assert nothing.vv == pytest.approx(1e-3 * (5.0 * 1e-3 / 34.0) ** 2, rel=1e-12)
    assert nothing.zz == pytest.approx(1e-3 * (150.0 / 5.77e6) ** 2, rel=1e-12)
    assert np.linalg.eigvalsh(full(nothing)).min() > 0.0


def test_slope_of_a_bristle_bent_too_far_is_limited() -> None:
    """1 - z d(sigma0 |v|/g)/dv with z counted as 2 g/sigma0 where g is constant, far above v_s: 1 - 2 = -1."""
    gains = design_ekf(BELIEF, EkfSettings(), H)
    bent = 3.0 * 370.0 / 5.77e6
    assert believed_friction(0.3, bent, gains)[3].v == pytest.approx(-1.0, abs=1e-9)
    assert believed_friction(0.3, -bent, gains)[3].v == pytest.approx(3.0, abs=1e-9)


@pytest.mark.parametrize("name", EkfSettings._fields)
def test_design_names_the_setting_that_does_not_serve(name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} is 0, expected a value above 0"):
        design_ekf(BELIEF, EkfSettings()._replace(**{name: 0.0}), H)


def test_design_refuses_a_drive() -> None:
    drive = registered("drive_force", "canudas1995", duration=1.0).parameters
    with pytest.raises(ValueError, match="needs a hydraulic plant"):
        design_ekf(drive, EkfSettings(), H)
