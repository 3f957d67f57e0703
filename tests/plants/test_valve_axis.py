"""The valve-driven axis: against its equations written down again, with delays that are no multiples of the samples."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command import Answer, workbench
from scipy.integrate import solve_ivp

from controllers.pid import PID
from plants.valve_axis import VALVE_AXIS, Inputs, Parameters, Side, State, Valve
from workbench.fitting.replay import Sampled
from workbench.linear.open_loop import margins
from workbench.simulation.references import Ramp
from workbench.simulation.setup import Feed, Integrator, Loop, Setup
from workbench.simulation.simulate import simulate

GAIN, BAND, DELAY = 0.05, 1.1, 0.1537
GAIN_NEGATIVE, BAND_NEGATIVE, DELAY_NEGATIVE = 0.03, 0.6, 0.0291
LAG, DRIFT = 0.08, -0.002
STEP = 0.053

STUDY = """\
title = "an axis without pressures"
[plant]
model = "valve_axis"
parameters = "axis.toml"
[controllers.chosen]
type = "{}"
[references.ramp]
kind = "ramp"
rate = "10 mm/s"
[simulation]
duration = "1 s"
"""

AXIS = """\
title = "an axis"
source = "made up"
[parameters]
velocity_gain = {value = "50 mm/(s V)", source = "made up"}
dead_band = {value = "1 V", source = "made up"}
command_delay = {value = "0.15 s", source = "made up"}
axis_time_constant = {value = "80 ms", source = "made up"}
"""


PARAMETERS = Parameters(
    Valve(GAIN, BAND, DELAY, Side(GAIN_NEGATIVE, BAND_NEGATIVE, DELAY_NEGATIVE)), LAG, DRIFT, np.inf, 10.0
)


def driven(times: np.ndarray, volts: np.ndarray, *, linear: bool, parameters: Parameters = PARAMETERS, **changes):
    """The axis from rest, driven by volts at the sample instants, held or ramps between."""
    feed = Feed("valve_voltage", Sampled(times, volts), linear=linear)
    setup = Setup(
        VALVE_AXIS,
        parameters,
        State(0.0, 0.0),
        Inputs(0.0, 0.0, 0.0),
        times[-1],
        feeds=(feed,),
        integrator=Integrator(tolerance=1e-10),
        sample_time=STEP,
        **changes,
    )
    return simulate(setup)


def expected(times: np.ndarray, volts: np.ndarray, *, linear: bool) -> np.ndarray:
    """Positions (m) by the equations, written down again: from each instant at which anything bends to the next."""

    def command(time: float) -> float:
        if time < 0.0:
            return 0.0
        if linear:
            return float(np.interp(time, times, volts))
        return float(volts[np.searchsorted(times, time, side="right") - 1])

    def target(time: float) -> float:
        up, down = command(time - DELAY), command(time - DELAY_NEGATIVE)
        forward = GAIN * (up - BAND) if up > BAND else 0.0
        backward = GAIN_NEGATIVE * (down + BAND_NEGATIVE) if down < -BAND_NEGATIVE else 0.0
        return forward + backward + DRIFT

    bends = [times, times + DELAY, times + DELAY_NEGATIVE]
    if linear:  # where the ramps pass an edge of a dead band
        for level, late in ((BAND, DELAY), (-BAND_NEGATIVE, DELAY_NEGATIVE)):
            k = np.flatnonzero(np.diff(np.sign(volts - level)))
            bends.append(times[k] + STEP * (level - volts[k]) / (volts[k + 1] - volts[k]) + late)
    edges = np.unique(np.concatenate(bends))
    edges = edges[edges <= times[-1]]
    positions, state = {0.0: 0.0}, np.zeros(2)
    for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        inside = begin + 1e-9 * (end - begin), end - 1e-9 * (end - begin)
        if not linear:
            level = target(0.5 * (begin + end))
        slope = solve_ivp(
            lambda t, y: (y[1], ((target(np.clip(t, *inside)) if linear else level) - y[1]) / LAG),  # noqa: B023
            (begin, end),
            state,
            method="DOP853",
            rtol=1e-12,
            atol=1e-14,
        )
        state = slope.y[:, -1]
        positions[end] = state[0]
    return np.array([positions[float(time)] for time in times])


@pytest.mark.parametrize("linear", [False, True])
def test_trajectories_are_those_of_the_equations(linear: bool) -> None:
    times = STEP * np.arange(120)
    volts = np.random.default_rng(3).uniform(-4.0, 4.0, times.size)
    run = driven(times, volts, linear=linear)
    np.testing.assert_allclose(run.state("position"), expected(times, volts, linear=linear), rtol=0.0, atol=1e-8)


def steady_speed(volts: float) -> float:
    """Speed (m/s) long after a constant command came."""
    times = STEP * np.arange(100)
    run = driven(times, np.full(times.size, volts), linear=False)
    position = run.state("position")
    return float((position[-1] - position[-21]) / (20 * STEP))


@pytest.mark.parametrize(
    ("volts", "speed"),
    [
        (BAND + 2.0, 2.0 * GAIN + DRIFT),
        (BAND - 1e-3, DRIFT),
        (0.0, DRIFT),
        (-BAND_NEGATIVE + 1e-3, DRIFT),
        (-BAND_NEGATIVE - 2.0, -2.0 * GAIN_NEGATIVE + DRIFT),
    ],
)
def test_gain_and_dead_band_are_each_direction_s_own(volts: float, speed: float) -> None:
    assert steady_speed(volts) == pytest.approx(speed, abs=1e-9)


def test_nothing_moves_before_the_delay_of_its_direction_is_over() -> None:
    times = STEP * np.arange(10)
    still = PARAMETERS._replace(drift_velocity=0.0)
    for volts, delay in ((5.0, DELAY), (-5.0, DELAY_NEGATIVE)):
        moved = np.abs(driven(times, np.full(times.size, volts), linear=False, parameters=still).state("position"))
        assert np.all(moved[times <= delay] == 0.0)
        assert np.all(moved[times > delay] > 0.0)


def test_an_end_stop_is_not_passed_and_lets_go() -> None:
    times = STEP * np.arange(200)
    volts = np.where(times < 5.0, 6.0, -6.0)
    short = PARAMETERS._replace(stroke=0.2)
    run = driven(times, volts, linear=False, parameters=short)
    position, velocity = run.state("position"), run.signals["velocity"]
    assert run.outcome == "end stop"
    assert np.max(position) == pytest.approx(0.1, abs=1e-6)
    resting = (times > 4.0) & (times < 5.0)
    np.testing.assert_allclose(velocity[resting], 0.0, atol=1e-12)
    away = position[times > 5.0 + DELAY_NEGATIVE + 3 * LAG]
    assert away[1] < away[0] < 0.1


def test_a_drift_is_held_at_rest() -> None:
    for drift in (-0.004, 0.0, 0.003):
        parameters = PARAMETERS._replace(drift_velocity=drift)
        state, inputs = VALVE_AXIS.equilibrium(parameters, 0.0)
        np.testing.assert_allclose(VALVE_AXIS.derivatives(0.0, state, inputs, parameters), 0.0, atol=1e-15)


def closed_loop(parameters: Parameters = PARAMETERS, **settings: float) -> Setup:
    """The axis under a PID that knows it, sampled at 1 kHz."""
    gains = PID.design(PID.Settings(**settings), parameters, 1e-3)
    state, inputs = VALVE_AXIS.equilibrium(parameters, 0.0)
    return Setup(VALVE_AXIS, parameters, state, inputs, 1.0, Loop(PID, gains))


@pytest.mark.parametrize(("speed", "gain", "delay"), [(0.05, GAIN, DELAY), (-0.05, GAIN_NEGATIVE, DELAY_NEGATIVE)])
def test_the_margins_of_a_p_loop_are_the_textbook_s_with_the_delay(speed: float, gain: float, delay: float) -> None:
    """K g exp(-s T) / (s (tau s + 1)): 90 - atan(w tau) - w (T + h/2) degrees at the crossover."""
    kp, h = 40.0, 1e-3
    found = margins(closed_loop(kp=kp), speed)
    square = (np.sqrt(1.0 + (2.0 * LAG * kp * gain) ** 2) - 1.0) / (2.0 * LAG**2)
    crossover = np.sqrt(square)
    phase = 90.0 - np.degrees(np.arctan(crossover * LAG) + crossover * (delay + h / 2.0))
    assert found.phase_deg == pytest.approx(phase, abs=0.01)
    assert found.phase_frequency == pytest.approx(crossover, rel=1e-4)


def test_feedforward_and_dead_band_are_inverted_in_either_direction() -> None:
    """With both, and a share of 1, nothing is left for the error of a ramp to do; without, it drives the axis."""
    still = PARAMETERS._replace(drift_velocity=0.0)
    for speed, gain, band in ((0.05, GAIN, BAND), (-0.05, GAIN_NEGATIVE, BAND_NEGATIVE)):
        for share in (1.0, 0.0):
            setup = closed_loop(still, kp=40.0, feedforward=share, dead_band=share)
            run = simulate(replace(setup, reference=Ramp(speed), duration=20.0))
            left = (1.0 - share) * (speed / gain + np.sign(speed) * band) / 40.0
            assert run.signals["error"][-1] == pytest.approx(left, abs=1e-6)


def checked(folder: Path, controller: str) -> Answer:
    """What `workbench check` says of a study of the axis with a controller of that type."""
    needed = {"pid": 'kp = "20 V/m"', "relay": 'amplitude = "2 V"', "disturbance_observer": 'kp = "20 V/m"'}
    (folder / "axis.toml").write_text(AXIS)
    text = STUDY.format(controller).replace("[references", f"{needed.get(controller, '')}\n[references")
    (folder / "study.toml").write_text(text)
    return workbench("check", folder / "study.toml")


@pytest.mark.parametrize("name", ["lugre", "static_map", "uncompensated", "ekf"])
def test_what_needs_friction_or_pressures_is_refused_in_one_line(name: str, tmp_path: Path) -> None:
    answer = checked(tmp_path, name)
    assert (answer.code, answer.err.count("\n")) == (2, 1)
    assert 'needs "friction" among the parameters' in answer.err or "needs a hydraulic plant" in answer.err


@pytest.mark.parametrize("name", ["pid", "nonlinear_pi", "dither", "relay", "disturbance_observer"])
def test_what_knows_of_a_velocity_alone_drives_it(name: str, tmp_path: Path) -> None:
    assert checked(tmp_path, name).code == 0
