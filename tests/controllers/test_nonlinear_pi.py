"""Nonlinear PI: by hand, and on the simulated plant."""

from typing import Any

import pytest
from position_loops import BELIEF, KEEP, H, hunting, play, tracking_error

from controllers import nonlinear_pi, pid
from controllers.nonlinear_pi import NONLINEAR_PI
from controllers.pid import PID


def npi(**settings: Any) -> nonlinear_pi.Settings:
    return nonlinear_pi.Settings(kp=500.0, ki=2000.0)._replace(**settings)


def test_stuck_piston_is_pushed_by_a_linear_integral() -> None:
    """2000 V/(m s) times 1 mm is 2 mV a sample."""
    commands, _ = play(NONLINEAR_PI, npi(), [(1.0, 0.0)] * 4)
    assert commands == pytest.approx([0.5, 0.502, 0.504, 0.506], rel=1e-12)


def test_integral_slows_down_with_the_square_of_the_speed() -> None:
    """10 um in a sample are (1 - E) 10 mm/s at the filter; with v_0 = 5 mm/s the rate falls by 1 + (2 (1 - E))^2."""
    commands, state = play(NONLINEAR_PI, npi(), [(1.0, 0.0), (1.0, 0.01)])
    slower = 1.0 + (2.0 * (1.0 - KEEP)) ** 2
    assert commands == pytest.approx([0.5, 0.495 + 0.002], rel=1e-12)
    assert state.integral == pytest.approx(0.002 + 2000.0 * H * 0.99e-3 / slower, rel=1e-12)


@pytest.mark.parametrize(("retained", "left"), [(0.0, 0.0), (0.25, 0.001), (1.0, 0.004)])
def test_integral_is_released_when_the_error_has_changed_sign(retained: float, left: float) -> None:
    """4 mV are stored when the reference falls from 1 mm to -1 mm."""
    commands, _ = play(NONLINEAR_PI, npi(retained=retained), [(1.0, 0.0), (1.0, 0.0), (-1.0, 0.0)])
    assert commands[-1] == pytest.approx(-0.5 + left, rel=1e-12)


def test_error_within_the_band_releases_nothing() -> None:
    """-10 um is less than the band of 13 um; -20 um is more."""
    inside, _ = play(NONLINEAR_PI, npi(), [(1.0, 0.0), (1.0, 0.0), (-0.010, 0.0)])
    beyond, _ = play(NONLINEAR_PI, npi(), [(1.0, 0.0), (1.0, 0.0), (-0.020, 0.0)])
    assert inside[-1] == pytest.approx(-0.005 + 0.004, rel=1e-12)
    assert beyond[-1] == pytest.approx(-0.010, rel=1e-12)


def test_integral_is_released_when_the_piston_turns() -> None:
    """10 um forward, then 30 um back: v^ = (1 - E) 10 mm/s, then (1 - E)(10 E - 30) mm/s, both clear."""
    samples = [(1.0, 0.0), (1.0, 0.01), (1.0, -0.02)]
    commands, _ = play(NONLINEAR_PI, npi(), samples)
    assert commands[-1] == pytest.approx(500.0 * 1.02e-3, rel=1e-12)
    slow, _ = play(NONLINEAR_PI, npi(reversal_speed=1.0), samples)
    assert slow[-1] > commands[-1] + 0.002


def test_back_calculation_of_the_nonlinear_pi() -> None:
    """Limit 0.4 V, 0.5 V wanted, T_t = 20 ms: the integral takes 2 mV - 1 ms * 0.1 V / 20 ms = -3 mV."""
    _, state = play(NONLINEAR_PI, npi(tracking_time=20e-3), [(1.0, 0.0)], limit=0.4)
    assert state.integral == pytest.approx(-0.003, rel=1e-12)


def test_nonlinear_pi_ends_the_hunting_of_pi() -> None:
    """100 V/m and 1000 V/(m s) sustain 1.095 mm peak to peak at about 1.05 s with PI (another simulation)."""
    linear, _ = hunting(PID, pid.Settings(100.0, 1000.0))
    assert linear.verdict == "sustained"
    assert linear.amplitude == pytest.approx(1.095e-3, rel=0.03)
    assert linear.period == pytest.approx(1.05, rel=0.01)
    verdict, late = hunting(NONLINEAR_PI, nonlinear_pi.Settings(100.0, 1000.0))
    assert verdict.verdict == "none"
    assert late < 1e-3


def test_nonlinear_pi_tracks_between_p_and_pi() -> None:
    """5 mm at 0.1 Hz: P alone has 0.079 mm rms; the integral takes most of it, anew each half period."""
    linear = tracking_error(PID, pid.Settings(500.0, 2000.0), 5e-3, 0.1)
    error = tracking_error(NONLINEAR_PI, nonlinear_pi.Settings(), 5e-3, 0.1)
    assert linear < error < 0.25 * 0.079


def test_settings_of_the_nonlinear_pi() -> None:
    with pytest.raises(ValueError, match="sliding_speed is 0, expected a value above 0"):
        NONLINEAR_PI.design(npi(sliding_speed=0.0), BELIEF, H)
    with pytest.raises(ValueError, match=r"retained is 1\.5, expected a share between 0 and 1"):
        NONLINEAR_PI.design(npi(retained=1.5), BELIEF, H)
