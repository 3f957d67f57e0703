"""The figures of a run: analytic signals, made-up runs, and the loop of chapter 3."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import support
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.pid import PID, Gains
from controllers.velocity import filtered_differentiator
from plants.hydraulics import Mass
from plants.interface import Measurement
from workbench.metrics import COLUMNS, evaluate
from workbench.metrics.friction import hysteresis, line
from workbench.metrics.power import control_effort, jerk_rms, mean_powers, stuck_fraction
from workbench.metrics.tracking import phase_lag_and_gain
from workbench.metrics.window import find_dwells, find_window
from workbench.simulation.references import Multisine, Ramp, ReferenceSignal, Sine, Steps
from workbench.simulation.simulate import NO_LOOP, Loop, Run, simulate

STEP = 1e-3


def made_up(position: np.ndarray, reference: ReferenceSignal | None, outcome: str = "completed") -> Run:
    """A run whose position (m, each ms) is given; the plant of `support` has neither friction nor power."""
    time = STEP * np.arange(position.size)
    parameters = support.Parameters(Mass(1.0, 0.0, 0.0, 0.0), 0.0, 0.0)
    velocity = np.gradient(position, time) if time.size > 1 else np.zeros(1)
    states = np.column_stack([position, velocity])
    inputs = np.zeros((time.size, 2))
    profile = None if reference is None else reference(time)
    measured, memory = np.zeros((time.size, len(Measurement._fields))), np.zeros((time.size, 1))
    return Run(
        support.OSCILLATOR,
        NO_LOOP,
        parameters,
        time,
        states,
        inputs,
        measured,
        memory,
        profile,
        outcome,
        time.size,
    )


def figures_of(
    position: Callable[[np.ndarray], np.ndarray], reference: ReferenceSignal, duration: float, transient: float
) -> dict[str, float | str | None]:
    time = STEP * np.arange(round(duration / STEP) + 1)
    return evaluate(made_up(position(time), reference), reference, transient)


# --- what applies ---------------------------------------------------------------------------------------------


def test_the_columns_are_those_of_the_contract() -> None:
    assert ", ".join(COLUMNS) == (
        "outcome, phase_lag_deg, gain_ratio, steady_state_error_m, rms_error_m, max_error_m, settling_time_s, "
        "limit_cycle, limit_cycle_amplitude_m, limit_cycle_period_s, stuck_fraction, hydraulic_power_W, "
        "supply_power_W, rotation_power_W, motor_electric_power_W, total_power_W, control_effort_V, "
        "jerk_rms_m_per_s3, friction_slope_N_s_per_m, friction_r_squared, friction_hysteresis_J, solver_error_m"
    )
    assert tuple(figures_of(np.sin, Sine(1.0, 1.0), 3.0, 1.0)) == COLUMNS[:-1]


@pytest.mark.parametrize("outcome", ["diverged", "step too small"])
def test_a_run_that_diverged_has_an_outcome_alone(outcome: str) -> None:
    reference = Sine(1.0, 1.0)
    figures = evaluate(made_up(np.sin(STEP * np.arange(3000)), reference, outcome), reference, 1.0)
    assert figures.pop("outcome") == outcome
    assert set(figures.values()) == {None}


@pytest.mark.parametrize("samples", [1, 2, 1000, 1001])
def test_a_run_within_its_transient_has_an_outcome_alone(samples: int) -> None:
    reference = Steps((1.0,), 1.0)
    figures = evaluate(made_up(np.zeros(samples), reference), reference, 1.0)
    assert figures.pop("outcome") == "completed"
    assert set(figures.values()) == {None}


def test_without_a_reference_there_is_no_tracking() -> None:
    run = made_up(np.sin(STEP * np.arange(5000)), None)
    for reference in (None, Sine(1.0, 1.0), Steps((1.0,), 1.0)):
        figures = evaluate(run, reference, 1.0)
        assert {name for name, figure in figures.items() if figure is not None} == {"outcome", "stuck_fraction"}


def test_a_sine_has_no_dwells_and_steps_have_no_lag() -> None:
    dwell_figures = set(COLUMNS[3:4] + COLUMNS[6:10])
    sine = figures_of(np.sin, Sine(1.0, 0.5), 5.0, 1.0)
    assert all(sine[name] is None for name in dwell_figures)
    steps = figures_of(lambda time: np.ones_like(time), Steps((1.0,), 5.0), 5.0, 1.0)
    assert steps["phase_lag_deg"] is None
    assert steps["gain_ratio"] is None
    assert steps["limit_cycle"] == "none"
    assert steps["limit_cycle_amplitude_m"] is None


# --- window ---------------------------------------------------------------------------------------------------


def test_the_window_is_the_last_whole_number_of_periods() -> None:
    time = STEP * np.arange(5001)
    window = find_window(time, Sine(1.0, 0.9), 1.1)
    assert window is not None
    assert window.periods == 3
    assert time[window.start] == pytest.approx(5.0 - 3.0 / 0.9, abs=1.5 * STEP)
    whole = find_window(time, Sine(1.0, 1.0), 1.0)
    assert whole is not None
    assert (whole.periods, time[whole.start :].size) == (4, 4000)


def test_without_a_whole_period_the_window_begins_after_the_transient() -> None:
    time = STEP * np.arange(2001)
    for reference in (None, Steps((1.0,), 1.0), Sine(1.0, 0.5)):
        window = find_window(time, reference, 0.5)
        assert window is not None
        assert (window.start, window.periods) == (500, 0)
    slow = figures_of(np.sin, Sine(1.0, 0.5), 2.0, 0.5)
    assert slow["phase_lag_deg"] is None
    assert slow["rms_error_m"] is not None


def test_dwells_end_after_the_transient_and_share_no_sample() -> None:
    time = STEP * np.arange(4001)
    dwells = find_dwells(time, Steps((1.0, 2.0, 3.0), 1.0, 0.5), 1.6)
    assert [(d.start, d.stop) for d in dwells] == [(1500, 2500), (2500, 4001)]


# --- tracking -------------------------------------------------------------------------------------------------


@settings(max_examples=100, deadline=None)
@given(
    lag=st.floats(-179.9, 179.9),
    gain=st.floats(0.01, 10.0),
    frequency=st.floats(0.5, 20.0),
    phase=st.floats(-7.0, 7.0),
    offset=st.floats(-1.0, 1.0),
)
def test_lag_and_gain_of_a_sine(lag: float, gain: float, frequency: float, phase: float, offset: float) -> None:
    reference = Sine(0.03, frequency, 0.01, phase)
    angle = 2.0 * np.pi * frequency

    def position(time: np.ndarray) -> np.ndarray:
        return offset + gain * 0.03 * np.sin(angle * time + phase - math.radians(lag))

    figures = figures_of(position, reference, 5.0, 1.0)
    assert figures["phase_lag_deg"] == pytest.approx(lag, abs=1e-6)
    assert figures["gain_ratio"] == pytest.approx(gain, rel=1e-9)


def test_harmonics_do_not_move_the_lag() -> None:
    reference = Sine(0.03, 1.0)
    plain = figures_of(lambda t: 0.02 * np.sin(2.0 * np.pi * t - 0.5), reference, 5.0, 1.0)
    rich = figures_of(
        lambda t: 0.02 * np.sin(2.0 * np.pi * t - 0.5) + 0.01 * np.cos(6.0 * np.pi * t + 1.0), reference, 5.0, 1.0
    )
    assert rich["phase_lag_deg"] == pytest.approx(plain["phase_lag_deg"], abs=1e-9)
    assert rich["gain_ratio"] == pytest.approx(2.0 / 3.0, rel=1e-12)


def test_lag_of_opposite_phase_and_of_a_position_at_rest() -> None:
    time = STEP * np.arange(1000)
    sine = np.sin(2.0 * np.pi * time)
    lag, gain = phase_lag_and_gain(time, sine, -2.0 * sine, 1.0)
    assert abs(lag or 0.0) == pytest.approx(180.0)
    assert gain == pytest.approx(2.0)
    assert phase_lag_and_gain(time, sine, 0.0 * sine, 1.0) == (None, pytest.approx(0.0, abs=1e-15))
    assert phase_lag_and_gain(time, 0.0 * sine, sine, 1.0) == (None, None)


def test_errors_over_the_window() -> None:
    # Error 0.1 sin: rms 0.1 / sqrt 2, largest 0.1; the multisine has a period but no fundamental.
    reference = Multisine(0.02, 0.5, (1, 3, 5))
    figures = figures_of(lambda t: reference(t)[0] - 0.1 * np.sin(np.pi * t), reference, 9.0, 0.7)
    assert figures["rms_error_m"] == pytest.approx(0.1 / math.sqrt(2.0), rel=1e-9)
    assert figures["max_error_m"] == pytest.approx(0.1, rel=1e-5)
    assert figures["phase_lag_deg"] is None


@settings(max_examples=50, deadline=None)
@given(time_constant=st.floats(0.02, 0.2), height=st.floats(-0.05, 0.05).filter(lambda h: abs(h) > 1e-4))
def test_settling_of_a_first_order_lag(time_constant: float, height: float) -> None:
    reference = Steps((height,), 2.0)
    figures = figures_of(lambda t: height * (1.0 - np.exp(-t / time_constant)), reference, 2.0, 0.5)
    assert figures["settling_time_s"] == pytest.approx(time_constant * math.log(50.0), abs=1.01 * STEP)
    # Mean of exp(-t / T) over the last 20 % of 2 s.
    expected = abs(height) * time_constant / 0.4 * (math.exp(-1.6 / time_constant) - math.exp(-2.0 / time_constant))
    assert figures["steady_state_error_m"] == pytest.approx(expected, rel=0.05, abs=1e-12)


def test_the_worst_dwell_counts_for_settling_and_steady_state() -> None:
    reference = Steps((1.0, -1.0, 0.0), 1.0)

    def position(time: np.ndarray) -> np.ndarray:
        target, since = reference(time)[0], np.mod(time, 1.0)
        offset = np.select([time < 1.0, time < 2.0], [0.5, -0.003], 0.002)
        slow = np.where((time >= 1.0) & (time < 2.0), 0.1, 0.05)
        return target - offset - 2.0 * np.exp(-since / slow) * (time < 3.0)

    figures = figures_of(position, reference, 3.0, 1.5)
    # The first dwell, with 0.5 m, ends in the transient. Jumps of 2 m and 1 m: 2 exp(-t/0.1) = 0.04 + 0.003.
    assert figures["steady_state_error_m"] == pytest.approx(0.003, rel=0.2)
    assert figures["settling_time_s"] == pytest.approx(0.1 * math.log(2.0 / 0.043), abs=1.01 * STEP)


def test_what_does_not_settle_or_does_not_jump_has_no_settling_time() -> None:
    reference = Steps((1.0, 2.0), 1.0)
    never = figures_of(lambda t: np.where(t < 1.0, 1.0, 1.9), reference, 2.0, 0.1)
    assert never["settling_time_s"] is None
    assert never["steady_state_error_m"] == pytest.approx(0.1)
    ramp = Ramp(0.02, 0.0, 1.0)
    turned = figures_of(lambda t: ramp(t)[0] + 1e-3 * np.exp(-t), ramp, 3.0, 0.5)
    assert turned["settling_time_s"] is None
    assert turned["limit_cycle"] == "none"


# --- motion and power -----------------------------------------------------------------------------------------


def test_stuck_fraction_of_a_sine() -> None:
    # |V sin| < u for a share (2 / pi) asin(u / V) of the time.
    velocity = 2e-4 * np.sin(2.0 * np.pi * STEP * np.arange(100_000))
    assert stuck_fraction(velocity) == pytest.approx(2.0 / math.pi * math.asin(0.5), abs=2e-3)


def test_jerk_of_a_sine() -> None:
    time = STEP * np.arange(1001)
    w = 2.0 * np.pi * 2.0
    assert jerk_rms(time, 3.0 * np.sin(w * time)) == pytest.approx(3.0 * w / math.sqrt(2.0), rel=2e-3)
    assert jerk_rms(time[:2], time[:2]) is None


def test_powers_and_effort() -> None:
    ramp = np.arange(5.0)
    all_four = {
        name: factor * ramp
        for name, factor in (
            ("hydraulic_power", 1.0),
            ("supply_power", 2.0),
            ("rotation_power", 4.0),
            ("motor_electric_power", 8.0),
        )
    }
    assert mean_powers(all_four, slice(2, None)) == {
        "hydraulic_power_W": 3.0,
        "supply_power_W": 6.0,
        "rotation_power_W": 12.0,
        "motor_electric_power_W": 24.0,
        "total_power_W": 15.0,
    }
    assert mean_powers({"hydraulic_power": ramp}, slice(0, None)) == {"hydraulic_power_W": 2.0, "total_power_W": 2.0}
    assert mean_powers({}, slice(0, None)) == {}
    assert control_effort(np.array([3.0, -3.0, 3.0]), "V") == pytest.approx(3.0)
    assert control_effort(np.array([3.0]), "N") is None


# --- friction -------------------------------------------------------------------------------------------------

FREQUENCY, PERIODS = 0.9, 4
W = 2.0 * np.pi * FREQUENCY
TIME = STEP * np.arange(round(PERIODS / FREQUENCY / STEP))
SPEED = 0.03 * W
DELAY = 0.01


def sine_speed(time: np.ndarray) -> np.ndarray:
    return SPEED * np.cos(W * time)


def uneven_speed(time: np.ndarray) -> np.ndarray:
    return SPEED * (np.cos(W * time) + 0.15 * np.sin(3.0 * W * time + 0.4))


def stribeck(velocity: np.ndarray, stribeck_velocity: float = 0.032) -> np.ndarray:
    """The thesis's steady curve: 370 N, 217 N, 2318 N s/m."""
    return np.sign(velocity) * (370.0 + 217.0 * np.exp(-((velocity / stribeck_velocity) ** 2))) + 2318.0 * velocity


def test_line_through_viscous_and_coulomb_friction() -> None:
    slope, r_squared = line(sine_speed(TIME), 5.0 + 2318.0 * sine_speed(TIME))
    assert slope == pytest.approx(2318.0)
    assert r_squared == pytest.approx(1.0)
    # F_c sgn v on v = V sin: slope 4 F_c / (pi V), R^2 8 / pi^2.
    slope, r_squared = line(sine_speed(TIME), 370.0 * np.sign(sine_speed(TIME)))
    assert slope == pytest.approx(4.0 * 370.0 / (math.pi * SPEED), rel=2e-3)
    assert r_squared == pytest.approx(8.0 / math.pi**2, rel=2e-3)


def test_line_and_hysteresis_need_motion() -> None:
    still = np.full(TIME.size, 1e-7)
    assert line(still + 1e-6 * np.sin(W * TIME), TIME) == (None, None)
    assert line(sine_speed(TIME), np.full(TIME.size, 3.0)) == (pytest.approx(0.0, abs=1e-9), None)
    assert hysteresis(TIME, still, TIME) is None


@settings(max_examples=50, deadline=None)
@given(slope=st.floats(-1e4, 1e4), intercept=st.floats(-1e3, 1e3), noise=st.floats(0.0, 10.0))
def test_line_is_numpy_s(slope: float, intercept: float, noise: float) -> None:
    velocity = uneven_speed(TIME)
    force = intercept + slope * velocity + noise * np.sin(1e4 * TIME**2)
    assert line(velocity, force)[0] == pytest.approx(np.polyfit(velocity, force, 1)[0], rel=1e-7, abs=1e-7)


def test_hysteresis_of_a_delayed_viscous_force() -> None:
    # F = c V cos(w (t - T)): half the difference is c V sin(w T) |cos w t|, the energy per period
    # 2 c V^2 sin(w T) / w.
    lagging = 2318.0 * sine_speed(TIME - DELAY)
    expected = 2.0 * 2318.0 * SPEED**2 * math.sin(W * DELAY) / W
    assert hysteresis(TIME, sine_speed(TIME), lagging) == pytest.approx(PERIODS * expected, rel=3e-3)


def test_hysteresis_of_a_force_that_turns_with_the_acceleration() -> None:
    # F = k sgn(dv/dt): k times the way, 4 V / w per period.
    acceleration = -np.sin(W * TIME)
    energy = hysteresis(TIME, sine_speed(TIME), 50.0 * np.sign(acceleration) + stribeck(sine_speed(TIME)))
    assert energy == pytest.approx(PERIODS * 50.0 * 4.0 * SPEED / W, rel=5e-3)


@pytest.mark.parametrize("speed", [sine_speed, uneven_speed])
@pytest.mark.parametrize("stribeck_velocity", [0.032, 0.0024])
def test_a_single_valued_curve_has_next_to_no_hysteresis(
    speed: Callable[[np.ndarray], np.ndarray], stribeck_velocity: float
) -> None:
    single = hysteresis(TIME, speed(TIME), stribeck(speed(TIME), stribeck_velocity))
    lagging = hysteresis(TIME, speed(TIME), stribeck(speed(TIME - DELAY), stribeck_velocity))
    assert single is not None
    assert lagging is not None
    assert single < 1e-3 * lagging


@settings(max_examples=40, deadline=None)
@given(scale=st.floats(0.1, 100.0), amplitude=st.floats(0.1, 10.0))
def test_hysteresis_scales_with_force_and_way(scale: float, amplitude: float) -> None:
    lagging = stribeck(sine_speed(TIME - DELAY))
    one = hysteresis(TIME, sine_speed(TIME), lagging)
    assert one is not None
    assert hysteresis(TIME, amplitude * sine_speed(TIME), scale * lagging) == pytest.approx(
        scale * amplitude * one, rel=1e-6
    )


# --- chapter 3 ------------------------------------------------------------------------------------------------

GAINS = Gains(500.0, 0.0, 0.0, 0.0, 0.0, filtered_differentiator(0.002, 0.001))
REFERENCE = Sine(0.03, 0.9)


def chapter3(rpm: float) -> Run:
    return simulate(
        support.registered(
            "rotating_helical" if rpm else "non_rotating",
            rpm=rpm,
            flow="chapter3",
            duration=5.0,
            loop=Loop(PID, GAINS),
            reference=REFERENCE,
        )
    )


@pytest.fixture(scope="module")
def still() -> Run:
    return chapter3(0.0)


@pytest.fixture(scope="module")
def turning() -> Run:
    return chapter3(460.0)


def test_chapter_3_at_rest(still: Run) -> None:
    figures = evaluate(still, REFERENCE, 1.1)
    assert figures["phase_lag_deg"] == pytest.approx(8.55, abs=0.15)
    assert figures["friction_r_squared"] == pytest.approx(0.910, abs=0.004)
    assert figures["rotation_power_W"] is None
    assert figures["motor_electric_power_W"] is None
    assert figures["total_power_W"] == figures["hydraulic_power_W"]


def test_chapter_3_at_460_rpm(still: Run, turning: Run) -> None:
    figures, at_rest = evaluate(turning, REFERENCE, 1.1), evaluate(still, REFERENCE, 1.1)
    assert figures["phase_lag_deg"] == pytest.approx(7.65, abs=0.15)
    assert figures["friction_slope_N_s_per_m"] == pytest.approx(2700.0, rel=0.015)
    assert figures["friction_r_squared"] == pytest.approx(1.0, abs=1e-5)
    assert float(figures["friction_hysteresis_J"] or 0.0) < 0.02 * float(at_rest["friction_hysteresis_J"] or 0.0)
    parts = float(figures["hydraulic_power_W"] or 0.0) + float(figures["rotation_power_W"] or 0.0)
    assert figures["total_power_W"] == pytest.approx(parts)
    assert float(figures["motor_electric_power_W"] or 0.0) > float(figures["rotation_power_W"] or 0.0)


def test_hydraulic_power_is_what_friction_dissipates(still: Run) -> None:
    # Over whole periods the mass and the oil give back what they stored: the means of P_L Q_L and F v agree.
    figures, window = evaluate(still, REFERENCE, 1.1), find_window(still.time, REFERENCE, 1.1)
    assert window is not None
    dissipated = np.mean((still.signals["axial_friction"] * still.signals["velocity"])[window.samples])
    assert figures["hydraulic_power_W"] == pytest.approx(dissipated, rel=2e-3)


def test_effort_is_that_of_the_realised_command(still: Run) -> None:
    # P control far from saturation: 500 V/m times the error.
    figures = evaluate(still, REFERENCE, 1.1)
    assert figures["control_effort_V"] == pytest.approx(500.0 * float(figures["rms_error_m"] or 0.0), rel=5e-3)


def test_evaluation_leaves_the_run_alone(still: Run) -> None:
    copy = replace(still, states=still.states.copy())
    before = copy.states.copy()
    first = evaluate(copy, REFERENCE, 1.1)
    assert np.array_equal(copy.states, before)
    assert evaluate(copy, REFERENCE, 1.1) == first
