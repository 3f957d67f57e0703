"""Lag, gain, errors and settling of analytic positions."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_runs import STEP, figures_of

from workbench.metrics.tracking import phase_lag_and_gain, root_mean_square
from workbench.simulation.references import Multisine, Ramp, Sine, Steps


@settings(max_examples=100, deadline=None)
@given(
    lag=st.floats(-179.9, 179.9),
    gain=st.floats(0.06, 10.0),
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


@settings(max_examples=40, deadline=None)
@given(drift=st.floats(-0.05, 0.05), third=st.floats(-0.01, 0.01), periods=st.integers(2, 9))
def test_a_drift_does_not_move_the_lag(drift: float, third: float, periods: int) -> None:
    reference = Sine(0.03, 1.0)

    def position(time: np.ndarray) -> np.ndarray:
        return 0.02 * np.sin(2.0 * np.pi * time - 0.5) + third * np.sin(6.0 * np.pi * time) + drift * time

    figures = figures_of(position, reference, periods + 0.5, 0.5)
    assert figures["phase_lag_deg"] == pytest.approx(math.degrees(0.5), abs=1e-6)
    assert figures["gain_ratio"] == pytest.approx(2.0 / 3.0, rel=1e-8)


def test_a_rod_that_hardly_moves_has_no_lag() -> None:
    reference = Sine(0.03, 1.0)
    for gain, told in ((0.019, False), (0.049, False), (0.051, True)):
        figures = figures_of(lambda t, gain=gain: 0.03 * gain * np.sin(2.0 * np.pi * t - 0.5), reference, 5.0, 1.0)
        assert (figures["phase_lag_deg"] is not None) == told
        assert figures["gain_ratio"] == pytest.approx(gain)


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


@pytest.mark.parametrize(("samples", "step"), [(8, 0.125), (2, 0.05)])
def test_samples_that_show_no_wave_give_no_lag(samples: int, step: float) -> None:
    """Of a wave of 4 Hz: two samples a period, where its sine is always 0; and two samples in all."""
    time = step * np.arange(samples)
    wave = 0.01 * np.cos(2.0 * np.pi * 4.0 * time)
    assert phase_lag_and_gain(time, wave, 0.9 * wave, 4.0) == (None, None)


def test_a_root_mean_square_is_found_where_no_number_holds_the_squares() -> None:
    assert root_mean_square(np.array([3e200, -4e200])) == pytest.approx(math.sqrt(12.5) * 1e200)
    assert root_mean_square(np.array([3.0, math.inf])) == math.inf
