"""The PID family: its law by hand, anti-windup, feed-forward, and tracking errors found by another simulation."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support import registered

from controllers.interface import Reference
from controllers.pid import PID, Gains, Settings, commit, design, start, step
from controllers.velocity import filtered_differentiator, kalman
from plants.interface import Measurement
from workbench.simulation.references import Sine, Steps
from workbench.simulation.simulate import Loop, Run, simulate

H = 1e-3
ESTIMATOR = filtered_differentiator(2e-3, H)

NO_LOAD_GAIN = 5.9e-4 * 6e-5 * np.sqrt(2.94e6 / 2.0) / 6.33e-4
"""K_q = K K_sv sqrt(P_s/2)/A of the simulation set: 0.0678 m/s per V."""


def law(kp: float = 0.0, ki: float = 0.0, kd: float = 0.0, feedforward: float = 0.0, tracking: float = 0.0) -> Gains:
    return Gains(kp, ki, kd, feedforward, tracking, ESTIMATOR)


def play(gains: Gains, samples: list[tuple[float, float, float]], limit: float = np.inf) -> list[float]:
    """Commands over samples of reference, its velocity and position (mm, mm/s, mm), from rest at 0."""
    state = start(Measurement(0.0, np.nan, np.nan, np.nan), gains)
    commands = []
    for wanted, speed, position in samples:
        reference = Reference(wanted * 1e-3, speed * 1e-3, 0.0)
        command, state = step(reference, Measurement(position * 1e-3, np.nan, np.nan, np.nan), state, gains, H)
        state = commit(min(max(command, -limit), limit), state, gains, H)
        commands.append(command)
    return commands


SAMPLES = [(1.0, 0.0, 0.0), (3.0, 200.0, 0.5), (3.0, 0.0, 1.5)]


def test_proportional() -> None:
    """500 V/m times 1, 2.5 and 1.5 mm."""
    assert play(law(kp=500.0), SAMPLES) == pytest.approx([0.5, 1.25, 0.75], rel=1e-12)


def test_integral_sees_the_errors_of_earlier_samples() -> None:
    """I = 2000 V/(m s) times 1 ms times 0, 1 and 3.5 mm."""
    assert play(law(kp=500.0, ki=2000.0), SAMPLES) == pytest.approx([0.5, 1.252, 0.757], rel=1e-12)


def test_derivative_of_the_filtered_velocity() -> None:
    """v^ = 0, then (1 - E) 500 mm/s, then E times that and (1 - E) 1000 mm/s; E = exp(-1/2); 2 V s/m."""
    keep = np.exp(-0.5)
    first = (1.0 - keep) * 0.5
    second = keep * first + (1.0 - keep) * 1.0
    expected = [0.5, 1.25 + 2.0 * (0.2 - first), 0.75 - 2.0 * second]
    assert play(law(kp=500.0, kd=2.0), SAMPLES) == pytest.approx(expected, rel=1e-12)


def test_feedforward() -> None:
    """15 V s/m times 0, 200 and 0 mm/s."""
    assert play(law(feedforward=15.0), SAMPLES) == pytest.approx([0.0, 3.0, 0.0], rel=1e-12)


def test_back_calculation_by_hand() -> None:
    """Limit 0.6 V: excess 0 and -0.652 V; with tracking 100 1/s the integral is 0, 2 and 7 - 65.2 mV."""
    commands = play(law(kp=500.0, ki=2000.0, tracking=100.0), SAMPLES, limit=0.6)
    assert commands == pytest.approx([0.5, 1.252, 0.75 + 0.007 - 0.0652], rel=1e-12)


def test_integral_settles_under_a_lasting_limit() -> None:
    """e = 50 mm, 500 V/m, limit 10 V: dI/dt = K_i e + (10 - K_p e - I)/T_t settles at 10 - 25 + K_i e T_t.

    Without tracking it is K_i e t.
    """
    samples = [(50.0, 0.0, 0.0)] * 2001
    held = play(law(kp=500.0, ki=2000.0, tracking=4.0), samples, limit=10.0)
    free = play(law(kp=500.0, ki=2000.0), samples, limit=10.0)
    assert held[-1] - 25.0 == pytest.approx(10.0 - 25.0 + 100.0 / 4.0, rel=1e-3)
    assert free[-1] - 25.0 == pytest.approx(100.0 * 2.0, rel=1e-9)


def loop(gains: Gains, reference: Any, duration: float) -> Run:
    return simulate(registered("non_rotating", duration=duration, loop=Loop(PID, gains), reference=reference))


def test_anti_windup_in_the_loop() -> None:
    """A step of 20 mm with an amplifier of 1 V, which moves the piston at K_q 1 V at most: 0.295 s and more.

    Meanwhile the integral of 1000 V/(m s) fills to more than 1000 * 20 mm * 0.295 s / 2 = 2.95 V and drives the
    piston far past its target. Tracked with T_t = K_p/K_i it does not.
    """
    reference = Steps((20e-3,), 3.0)
    setup = registered("non_rotating", duration=3.0, loop=Loop(PID, law(kp=500.0, ki=1000.0)), reference=reference)
    hydraulics = setup.parameters.hydraulics._replace(voltage_limit=1.0)
    setup = replace(setup, parameters=setup.parameters._replace(hydraulics=hydraulics))
    free = simulate(setup)
    held = simulate(replace(setup, loop=Loop(PID, law(kp=500.0, ki=1000.0, tracking=2.0))))
    for run in (free, held):
        arrival = np.argmax(run.state("position") > 19e-3) * H
        assert 0.295 < arrival + 1e-3 / NO_LOAD_GAIN < 1.3 * 0.295
    wound = 1000.0 * H * np.max(np.cumsum(free.signals["error"]))
    assert 2.95 < wound < 1.5 * 2.95
    free_over, held_over = (1e3 * (np.max(run.state("position")) - 20e-3) for run in (free, held))
    assert free_over > 5.0
    assert held_over < 0.2 * free_over


def tracking_error(feedforward: float, amplitude: float, frequency: float) -> tuple[float, float]:
    """rms and maximum of the error (mm) over the second and third period."""
    run = loop(law(kp=500.0, feedforward=feedforward), Sine(amplitude, frequency), 3.0 / frequency)
    steady = (run.time >= 1.0 / frequency - 1e-9) & (run.time < 3.0 / frequency - 1e-9)
    error = 1e3 * run.signals["error"][steady]
    return float(np.sqrt(np.mean(error**2))), float(np.max(np.abs(error)))


@pytest.mark.parametrize(
    ("feedforward", "amplitude", "frequency", "published"),
    [
        (0.0, 20e-3, 0.5, (1.54, 2.18)),
        (1.0, 20e-3, 0.5, (0.238, 0.340)),
        (0.0, 5e-3, 0.1, (0.079, 0.112)),
        (1.0, 5e-3, 0.1, (0.0138, 0.0196)),
    ],
)
def test_tracking_error_with_and_without_feedforward(
    feedforward: float, amplitude: float, frequency: float, published: tuple[float, float]
) -> None:
    """Values of an independent simulation (Runge-Kutta, 10 us) with 500 V/m and the derived flow."""
    assert tracking_error(feedforward / NO_LOAD_GAIN, amplitude, frequency) == pytest.approx(published, rel=0.01)


def test_design_feeds_forward_through_the_believed_velocity_gain() -> None:
    belief = registered("non_rotating", duration=1.0).parameters
    gains = design(Settings(500.0, feedforward=0.5), belief, H)
    assert gains.feedforward == pytest.approx(0.5 / NO_LOAD_GAIN, rel=1e-9)
    assert gains[:3] == (500.0, 0.0, 0.0)
    hydraulics = belief.hydraulics._replace(supply_pressure=4.0 * 2.94e6)
    other = design(Settings(500.0, feedforward=0.5), belief._replace(hydraulics=hydraulics), H)
    assert other.feedforward == pytest.approx(0.25 / NO_LOAD_GAIN, rel=1e-9)


def test_design_of_the_anti_windup() -> None:
    """By default the tracking time is K_p/K_i, never less than a sample; without integral there is none."""
    assert design(Settings(500.0, 2000.0), None, H).tracking == pytest.approx(4.0, rel=1e-12)
    assert design(Settings(500.0, 2000.0, tracking_time=0.05), None, H).tracking == pytest.approx(20.0, rel=1e-12)
    assert design(Settings(0.0, 2000.0), None, H).tracking == pytest.approx(1000.0, rel=1e-12)
    assert design(Settings(500.0), None, H).tracking == 0.0


def test_design_of_the_estimator() -> None:
    settings = Settings(500.0, kd=2.0)
    assert design(settings, None, H).estimator == ESTIMATOR
    assert design(settings._replace(velocity="kalman"), None, H).estimator == kalman(13e-6, 10.0, H)


def test_feedforward_needs_a_velocity_gain() -> None:
    drive = registered("drive_force", "canudas1995", duration=1.0).parameters
    with pytest.raises(ValueError, match="feedforward needs a plant with a velocity gain"):
        design(Settings(500.0, feedforward=1.0), drive, H)


def test_controller_starts_where_the_plant_is() -> None:
    """No derivative kick at the first sample of a piston that rests off its origin."""
    setup = registered("non_rotating", duration=0.1, loop=Loop(PID, law(kd=5.0)), reference=Steps((0.0,), 1.0))
    run = simulate(replace(setup, state=setup.state._replace(position=12e-3)))
    assert np.max(np.abs(run.command)) < 1e-12
