"""Dither: by hand, and on the simulated plant."""

import numpy as np
import pytest
from position_loops import BELIEF, LAG, NO_LOAD_GAIN, H, hunting, loop, play, tracking_error

from controllers import dither
from controllers.dither import DITHER
from workbench.metrics.evaluate import evaluate
from workbench.metrics.limit_cycle import judge
from workbench.simulation.references import Steps
from workbench.simulation.simulate import simulate


def test_sine_and_square_by_hand() -> None:
    """125 Hz at 1 kHz: eight samples a turn, on top of 0.5 V; the ninth and tenth begin the next turn."""
    root = 3.0 * np.sqrt(0.5)
    settings = dither.Settings(amplitude=3.0, frequency=125.0)
    sine, _ = play(DITHER, settings, [(1.0, 0.0)] * 10)
    expected = np.array([0.0, root, 3.0, root, 0.0, -root, -3.0, -root, 0.0, root]) + 0.5
    assert sine == pytest.approx(list(expected), abs=1e-12)
    square, _ = play(DITHER, settings._replace(shape="square", frequency=250.0), [(1.0, 0.0)] * 6)
    assert square == pytest.approx([3.5, 3.5, -2.5, -2.5, 3.5, 3.5], rel=1e-12)


def test_integral_does_not_see_the_dither() -> None:
    """Unlimited, the integral goes on by 2 mV a sample whatever the dither; limited, by the excess as well."""
    settings = dither.Settings(ki=2000.0, amplitude=2.0, tracking_time=20e-3, shape="square", frequency=250.0)
    _, state = play(DITHER, settings, [(1.0, 0.0)] * 5)
    assert state.pid.integral == pytest.approx(0.010, rel=1e-12)
    _, state = play(DITHER, settings, [(1.0, 0.0)], limit=2.4)
    assert state.pid.integral == pytest.approx(0.002 - H * 0.1 / 20e-3, rel=1e-12)


def test_what_reaches_spool_and_piston() -> None:
    """2.5 V at 50 Hz behind the lag of 12 ms: K_sv V 0.2564 at the spool, K_q V 0.2564 / (100 pi) at the piston.

    The loop answers with 500 V/m times 0.12 mm, which is 3 % of the dither. Friction of up to 587 N takes up to
    587/1861 of the supply pressure; the flow falls with the root of what is left.
    """
    run = simulate(loop(DITHER, dither.Settings(), Steps((0.0,), 1.0), 1.0))
    share = 1.0 / np.hypot(1.0, 100.0 * np.pi * LAG)
    late = run.time > 0.5
    spool, moved = (0.5 * np.ptp(run.state(name)[late]) for name in ("spool_position", "position"))
    assert spool == pytest.approx(6e-5 * 2.5 * share, rel=0.03)
    free = NO_LOAD_GAIN * 2.5 * share / (100.0 * np.pi)
    assert free * np.sqrt(1.0 - 587.0 / (6.33e-4 * 2.94e6)) < moved < free
    assert moved > 587.0 / 5.77e6  # the bristles' deflection at break-away


def test_the_dithers_own_motion_is_no_limit_cycle_and_what_it_does_not_quench_is() -> None:
    steps = Steps((0.0,), 3.0)
    run = simulate(loop(DITHER, dither.Settings(), steps, 3.0))
    assert np.ptp(run.signals["error"][run.time > 2.0]) > 1e-4
    assert evaluate(run, steps, 0.0)["limit_cycle"] == "none"

    time = run.time
    shaking, cycle = 2e-4 * np.sin(2.0 * np.pi * 50.0 * time), 2e-4 * np.sin(2.0 * np.pi * 4.0 * time)
    found = judge(time, shaking + cycle, np.gradient(shaking + cycle, time), 1e-6, forced=0.02)
    assert (found.verdict, found.period) == ("sustained", pytest.approx(0.25, rel=5e-3))
    assert judge(time, shaking, np.gradient(shaking, time), 1e-6, forced=0.0203).verdict == "none"


def test_dither_quenches_the_limit_cycle_at_a_price() -> None:
    """The hunting of 1.095 mm is no longer sustained; a sine that P tracks to 0.079 mm has the dither on top."""
    verdict, late = hunting(DITHER, dither.Settings(100.0, 1000.0))
    assert verdict.verdict != "sustained"
    assert late < 0.1 * 1.095
    own = 1e3 * NO_LOAD_GAIN * 2.5 / np.hypot(1.0, 100.0 * np.pi * LAG) / (100.0 * np.pi) / np.sqrt(2.0)
    assert tracking_error(DITHER, dither.Settings(), 5e-3, 0.1) == pytest.approx(np.hypot(0.079, own), rel=0.1)


@pytest.mark.parametrize("frequency", [0.0, 251.0])
def test_frequency_that_samples_cannot_carry(frequency: float) -> None:
    with pytest.raises(ValueError, match="expected more than 0 and at most 250 Hz"):
        DITHER.design(dither.Settings(frequency=frequency), BELIEF, H)
