"""Slope and hysteresis of friction over velocity, of forces with known ones."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_runs import STEP

from workbench.metrics.friction import hysteresis, line

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
