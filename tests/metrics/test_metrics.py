"""The figures of a run: which apply, over which window, and those of motion and power."""

import math

import numpy as np
import pytest
from made_up_runs import STEP, figures_of, made_up

from workbench.metrics.evaluate import evaluate
from workbench.metrics.power import control_effort, jerk_rms, mean_powers, stuck_fraction
from workbench.metrics.registry import columns
from workbench.metrics.window import find_dwells, find_window
from workbench.simulation.references import Sine, Steps

# --- what applies ---------------------------------------------------------------------------------------------


def test_the_columns_are_those_of_the_contract() -> None:
    assert ", ".join(columns()) == (
        "outcome, phase_lag_deg, gain_ratio, steady_state_error_m, steady_state_max_error_m, rms_error_m, max_error_m, "
        "settling_time_s, limit_cycle, limit_cycle_amplitude_m, limit_cycle_period_s, stuck_fraction, "
        "hydraulic_power_W, supply_power_W, rotation_power_W, motor_electric_power_W, total_power_W, "
        "motor_loss_W, paid_power_W, "
        "rotation_speed_mean_rpm, rotation_speed_min_rpm, rotation_speed_max_rpm, below_stribeck_fraction, "
        "torque_limited_fraction, motor_torque_rms_N_m, control_effort_V, "
        "jerk_rms_m_per_s3, friction_slope_N_s_per_m, friction_r_squared, friction_hysteresis_J, solver_error_m, "
        "solver_rms_error_m"
    )
    assert tuple(figures_of(np.sin, Sine(1.0, 1.0), 3.0, 1.0)) == tuple(columns())[:-2]


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
    dwell_figures = set(list(columns())[3:5] + list(columns())[7:11])
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
        "paid_power_W": 30.0,
    }
    assert mean_powers({"supply_power": ramp}, slice(0, None)) == {"supply_power_W": 2.0, "paid_power_W": 2.0}
    assert mean_powers({"hydraulic_power": ramp}, slice(0, None)) == {"hydraulic_power_W": 2.0, "total_power_W": 2.0}
    assert mean_powers({}, slice(0, None)) == {}
    assert control_effort(np.array([3.0, -3.0, 3.0]), "V") == pytest.approx(3.0)
    assert control_effort(np.array([3.0]), "N") is None
