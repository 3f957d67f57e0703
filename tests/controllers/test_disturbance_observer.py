"""Linear disturbance observer: by hand, and on the simulated plant."""

import numpy as np
import pytest
from position_loops import BELIEF, KEEP, LAG, NO_LOAD_GAIN, H, hunting, play, tracking_error
from support import registered

from controllers import disturbance_observer
from controllers.disturbance_observer import DISTURBANCE_OBSERVER
from controllers.interface import Reference
from plants.interface import Measurement


def test_observer_by_hand() -> None:
    """1 V for one sample moves the nominal plant by K_q (h - tau (1 - exp(-h/tau))); the piston stays where it is.

    Then v^ = (1 - E) of that over h, and d^ = (1 - exp(-h/T_q)) v^ / K_q; T_q = 20 ms.
    """
    commands, state = play(DISTURBANCE_OBSERVER, disturbance_observer.Settings(), [(2.0, 0.0), (2.0, 0.0)])
    lacking = (1.0 - KEEP) * (H - LAG * (1.0 - np.exp(-H / LAG))) / H
    expected = (1.0 - np.exp(-H / 20e-3)) * lacking
    assert commands == pytest.approx([1.0, 1.0 + expected], rel=1e-9)
    assert state.disturbance == pytest.approx(expected, rel=1e-9)


def test_limited_command_moves_the_nominal_plant_as_the_real_one() -> None:
    gains = DISTURBANCE_OBSERVER.design(disturbance_observer.Settings(), BELIEF, H)
    still = Measurement(0.0, np.nan, np.nan, np.nan)
    state, moved, leads = DISTURBANCE_OBSERVER.start(still, gains), 0.0, []
    for _ in range(2000):
        command, state = DISTURBANCE_OBSERVER.step(Reference(20.0, 0.0, 0.0), still, state, gains, H)
        state = DISTURBANCE_OBSERVER.commit(min(command, 1.0), state, gains, H)
        moved += state.nominal  # it was put back to the piston before
        leads.append(state.nominal)
    assert state.lagged == pytest.approx(1.0, rel=1e-9)
    assert moved == pytest.approx(NO_LOAD_GAIN * (2000 * H - LAG), rel=1e-9)
    assert max(leads) < 1.01 * NO_LOAD_GAIN * H, "what never comes back stays small"


@pytest.mark.parametrize("ratio", [0.3, 0.7, 1.0, 1.5, 1.9])
def test_observer_restores_the_velocity_gain(ratio: float) -> None:
    """A valve and piston with `ratio` times the believed gain, fed a ramp of 10 mm/s without position feedback.

    The velocity is 10 mm/s and the disturbance dr / K_q (1/ratio - 1); with ratio 1 it is 0 at every sample.
    """
    gains = DISTURBANCE_OBSERVER.design(disturbance_observer.Settings(kp=0.0), BELIEF, H)
    state = DISTURBANCE_OBSERVER.start(Measurement(5e-3, np.nan, np.nan, np.nan), gains)
    position, lagged, disturbances = 5e-3, 0.0, []
    keep = np.exp(-H / LAG)
    for _ in range(3000):
        measured = Measurement(position, np.nan, np.nan, np.nan)
        command, state = DISTURBANCE_OBSERVER.step(Reference(0.0, 10e-3, 0.0), measured, state, gains, H)
        state = DISTURBANCE_OBSERVER.commit(command, state, gains, H)
        before = position
        position += ratio * NO_LOAD_GAIN * (command * H + (lagged - command) * LAG * (1.0 - keep))
        lagged = command + (lagged - command) * keep
        disturbances.append(state.disturbance)
    assert (position - before) / H == pytest.approx(10e-3, rel=1e-6)
    assert disturbances[-1] == pytest.approx(10e-3 / NO_LOAD_GAIN * (1.0 / ratio - 1.0), rel=1e-6, abs=1e-12)
    if ratio == 1.0:
        assert np.max(np.abs(disturbances)) < 1e-12


@pytest.mark.parametrize("time_constant", [10e-3, 20e-3, 50e-3])
def test_tracking_error_that_the_observer_leaves(time_constant: float) -> None:
    """20 mm at 0.5 Hz, on a plant that P with feed-forward tracks to 0.238 mm rms (another simulation).

    Of this the valve's lag makes tau ddr / (K_p K_q), 0.049 mm, a quarter period ahead of the rest, which is a
    disturbance in phase with the velocity. The observer leaves of it w (T_q + tau + T_v), turned by a quarter period.
    """
    angular = np.pi
    lag = 1e3 * LAG * 20e-3 * angular**2 / (500.0 * NO_LOAD_GAIN) / np.sqrt(2.0)
    left = angular * (time_constant + LAG + 2e-3) * np.sqrt(0.238**2 - lag**2)
    settings = disturbance_observer.Settings(observer_time_constant=time_constant)
    assert tracking_error(DISTURBANCE_OBSERVER, settings, 20e-3, 0.5) == pytest.approx(lag + left, rel=0.05)


def test_observer_does_not_hunt_on_soft_hoses() -> None:
    verdict, late = hunting(DISTURBANCE_OBSERVER, disturbance_observer.Settings())
    assert verdict.verdict == "none"
    assert late < 1e-3


def test_observer_needs_a_valve() -> None:
    drive = registered("drive_force", "canudas1995", duration=1.0).parameters
    with pytest.raises(ValueError, match="needs a plant with a velocity gain"):
        DISTURBANCE_OBSERVER.design(disturbance_observer.Settings(), drive, H)
    with pytest.raises(ValueError, match="observer_time_constant is 0, expected a value above 0"):
        DISTURBANCE_OBSERVER.design(disturbance_observer.Settings(observer_time_constant=0.0), BELIEF, H)
