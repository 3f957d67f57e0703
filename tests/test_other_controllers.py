"""Nonlinear PI, dither, linear disturbance observer and scheduled rotation: by hand, and on the simulated plant."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import registered

from controllers import disturbance_observer, dither, nonlinear_pi, pid, scheduled_rotation, speed_servo
from controllers.disturbance_observer import DISTURBANCE_OBSERVER
from controllers.dither import DITHER
from controllers.interface import Controller, Reference
from controllers.nonlinear_pi import NONLINEAR_PI
from controllers.pid import PID
from controllers.scheduled_rotation import SCHEDULED_ROTATION
from plants.equation import to_array
from plants.interface import Measurement
from workbench.errors import UserError
from workbench.metrics import evaluate
from workbench.metrics.limit_cycle import LimitCycle, judge
from workbench.simulation.references import ReferenceSignal, Sine, Steps
from workbench.simulation.sensors import Channel, Sensors
from workbench.simulation.simulate import Loop, Run, Setup, simulate
from workbench.study.document import read_study, unfold
from workbench.study.resolve import resolve

H = 1e-3
LAG = 12e-3
KEEP = np.exp(-0.5)
"""Of the velocity filter: T_v 2 ms, 1 kHz."""

NO_LOAD_GAIN = 5.9e-4 * 6e-5 * np.sqrt(2.94e6 / 2.0) / 6.33e-4
"""K_q of the simulation set: 0.0678 m/s per V."""

BELIEF = registered("rotating_helical", duration=1.0).parameters


def play(
    controller: Controller, settings: Any, samples: list[tuple[float, float]], limit: float = np.inf
) -> tuple[list[float], Any]:
    """Commands over samples of reference and position (mm), and the last state; nothing but position is measured."""
    gains = controller.design(settings, BELIEF, H)
    state = controller.start(Measurement(samples[0][1] * 1e-3, np.nan, np.nan, np.nan), gains)
    commands = []
    for wanted, position in samples:
        measured = Measurement(position * 1e-3, np.nan, np.nan, np.nan)
        command, state = controller.step(Reference(wanted * 1e-3, 0.0, 0.0), measured, state, gains, H)
        state = controller.commit(min(max(command, -limit), limit), state, gains, H)
        commands.append(float(command))
    return commands, state


def loop(controller: Controller, settings: Any, reference: ReferenceSignal, duration: float, **changes: float) -> Setup:
    """A run of the simulation plant, believed as it is but for `changes` of its hydraulics."""
    setup = registered("non_rotating", duration=duration, reference=reference)
    gains = controller.design(settings, setup.parameters, H)
    parameters = setup.parameters._replace(hydraulics=setup.parameters.hydraulics._replace(**changes))
    return replace(setup, parameters=parameters, loop=Loop(controller, gains))


def tracking_error(controller: Controller, settings: Any, amplitude: float, frequency: float) -> float:
    """rms of the error (mm) over the second and third period of a sine."""
    run = simulate(loop(controller, settings, Sine(amplitude, frequency), 3.0 / frequency))
    return float(1e3 * np.sqrt(np.mean(run.signals["error"][run.time >= 1.0 / frequency] ** 2)))


# --- nonlinear PI --------------------------------------------------------------------------------------------


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


def hunting(controller: Controller, settings: Any) -> tuple[LimitCycle, float]:
    """Verdict for a step of 10 mm of the hose-fed plant (bulk modulus 30 MPa), and the largest late error (mm)."""
    run = simulate(loop(controller, settings, Steps((10e-3,), 30.0), 30.0, bulk_modulus=30e6))
    error = run.signals["error"]
    verdict = judge(run.time, error, run.state("velocity"), 0.0)
    return verdict, float(1e3 * np.max(np.abs(error[run.time > 20.0])))


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


# --- dither --------------------------------------------------------------------------------------------------


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


# --- disturbance observer ------------------------------------------------------------------------------------


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
    _, state = play(DISTURBANCE_OBSERVER, disturbance_observer.Settings(), [(20.0, 0.0)] * 2000, limit=1.0)
    assert state.lagged == pytest.approx(1.0, rel=1e-9)
    assert state.nominal == pytest.approx(NO_LOAD_GAIN * (2000 * H - LAG), rel=1e-9)


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


# --- scheduled rotation --------------------------------------------------------------------------------------

RADIUS = 19e-3


def turn(
    input_name: str, positions: np.ndarray, turning: float, bias: float = 0.0
) -> tuple[list[float], list[float], Any]:
    """Commands and scheduled speeds over positions (m) for a minimum of 5 rad/s, starting at `turning` (rad/s)."""
    controller = SCHEDULED_ROTATION[input_name]
    gains = controller.design(scheduled_rotation.Settings(bias), BELIEF, H)
    state = controller.start(Measurement(positions[0], np.nan, np.nan, turning), gains)
    commands, scheduled = [], []
    for position in positions:
        measured = Measurement(position, np.nan, np.nan, turning)
        command, state = controller.step(Reference(5.0, 0.0, 0.0), measured, state, gains, H)
        state = controller.commit(command, state, gains, H)
        commands.append(float(command))
        scheduled.append(float(state.scheduled))
    return commands, scheduled, gains


def test_schedule_by_hand() -> None:
    """At rest 1.01 times 5 rad/s; at 4 rad/s R along sqrt(5.05^2 - 4^2) = 3.0827; at 6 rad/s R none."""
    time = H * np.arange(200)
    for along, expected in [(0.0, 5.05), (4.0, 3.0826), (-4.0, 3.0826), (6.0, 0.0)]:
        commands, scheduled, _ = turn("surface_speed", along * RADIUS * time, 5.05)
        assert scheduled[-1] == pytest.approx(expected, abs=1e-3)
        assert commands[-1] == pytest.approx(RADIUS * scheduled[-1], rel=1e-12)


def test_schedule_changes_no_faster_than_allowed() -> None:
    """5 m/s^2 over 19 mm is 0.26316 rad/s a sample, from standstill."""
    _, scheduled, _ = turn("surface_speed", np.zeros(30), 0.0)
    assert scheduled[:3] == pytest.approx([0.26316, 0.52632, 0.78947], rel=1e-4)
    assert scheduled[-1] == pytest.approx(5.05, rel=1e-12)


def test_motor_voltage_by_hand() -> None:
    """Bias 2 V at 5 rad/s is 2.02 V at 5.05, plus the servo's gain times 0.05 rad/s, plus its integral."""
    commands, _, gains = turn("motor_voltage", np.zeros(2), 5.0, bias=2.0)
    servo = speed_servo.design(speed_servo.Settings(2.0), BELIEF, H)
    assert gains.servo == servo
    first = 2.02 + 0.05 * servo.proportional
    assert commands == pytest.approx([first, first + H * servo.integral * 0.05], rel=1e-12)


def turned(plant: str, minimum: float, command: Callable[[Setup], Loop] | None, duration: float = 6.0) -> Run:
    """P 500 V/m on 20 mm at 0.5 Hz while the rod turns: as it started, or by the rotary loop of `command`."""
    setup = registered(plant, rpm=minimum / RADIUS * 30.0 / np.pi, duration=duration, reference=Sine(20e-3, 0.5))
    setup = replace(setup, loop=Loop(PID, PID.design(pid.Settings(500.0), setup.parameters, H)))
    if command is not None:
        inputs = setup.inputs._replace(**{str(setup.plant.rotary_command): 0.0})
        setup = replace(setup, rotary=command(setup), rotation_speed=minimum / RADIUS, inputs=inputs)
    return simulate(setup)


def scheduled_loop(setup: Setup, surface_acceleration: float = 5.0) -> Loop:
    name = str(setup.plant.rotary_command)
    settings = scheduled_rotation.Settings(getattr(setup.inputs, name), surface_acceleration)
    return Loop(SCHEDULED_ROTATION[name], SCHEDULED_ROTATION[name].design(settings, setup.parameters, H))


def servo_loop(setup: Setup) -> Loop:
    settings = speed_servo.Settings(setup.inputs.motor_voltage)
    return Loop(speed_servo.SPEED_SERVO, speed_servo.design(settings, setup.parameters, H))


@pytest.mark.parametrize("bristle", ["helical", "isotropic"])
@pytest.mark.parametrize("drive", ["", "_ideal"])
@pytest.mark.parametrize("minimum", [0.05, 0.07])
def test_schedule_keeps_the_helical_speed_and_saves_power(bristle: str, drive: str, minimum: float) -> None:
    """20 mm at 0.5 Hz reaches 63 mm/s: more than a minimum of 50 mm/s, less than one of 70 mm/s.

    Sliding friction takes F_h w^2 / v_h on the rod with F_h the friction at the helical speed. Constant rotation has it
    at w = minimum, v_h = sqrt(v^2 + w^2); the schedule at v_h = max(minimum, |v|), w^2 = v_h^2 - v^2.
    """
    run = turned(f"rotating_{bristle}{drive}", minimum, scheduled_loop)
    constant = turned(f"rotating_{bristle}{drive}", minimum, None if drive else servo_loop)
    late = run.time >= 2.0
    signals, steady = run.signals, constant.signals
    assert np.min(signals["helical_speed"][late]) > 0.98 * minimum
    velocity = signals["velocity"][late]
    p = run.parameters.friction.positive

    def power(along: np.ndarray, around: np.ndarray) -> float:
        speed = np.hypot(along, around)
        level = p.coulomb + p.stribeck * np.exp(-((speed / p.stribeck_velocity) ** 2)) + p.viscous * speed
        return float(np.mean(level * around**2 / speed))

    needed = power(velocity, np.sqrt(np.maximum(minimum**2 - velocity**2, 0.0)))
    kept = power(steady["velocity"][late], np.full_like(velocity, minimum))
    assert np.mean(signals["rotation_power"][late]) == pytest.approx(needed, rel=0.04)  # margin 1.01, squared and more
    assert np.mean(steady["rotation_power"][late]) == pytest.approx(kept, rel=0.02)
    assert np.mean(signals["rotation_power"][late]) < 0.72 * np.mean(steady["rotation_power"][late])
    assert np.mean(signals["motor_electric_power"][late]) < 0.8 * np.mean(steady["motor_electric_power"][late])


def test_price_of_a_slow_motor() -> None:
    """Limited to r = 0.3 m/s^2 the speed falls to sqrt(1 - (a/r)^2) of what was aimed at.

    a = pi sqrt((20 mm pi)^2 - (50 mm/s)^2) = 0.120 m/s^2 is the piston's deceleration as it passes 50 mm/s.
    """
    run = turned("rotating_isotropic_ideal", 0.05, lambda setup: scheduled_loop(setup, 0.3))
    braking = np.pi * np.sqrt((20e-3 * np.pi) ** 2 - 0.05**2)
    lowest = np.min(run.signals["helical_speed"][run.time >= 2.0])
    expected = scheduled_rotation.MARGIN * 0.05 * np.sqrt(1.0 - (braking / 0.3) ** 2)
    assert lowest == pytest.approx(expected, rel=0.02)
    assert lowest < 0.95 * 0.05


@pytest.mark.parametrize("setting", ["surface_acceleration", "velocity_time_constant"])
def test_settings_of_the_schedule(setting: str) -> None:
    settings = scheduled_rotation.Settings()._replace(**{setting: 0.0})
    with pytest.raises(ValueError, match=f"{setting} is 0, expected a value above 0"):
        scheduled_rotation.design(settings, BELIEF, H)


STUDY = """title = "t"
[plant]
model = "by_rpm"
parameters = "owen2001_simulation"
rotation = "scheduled"
minimum_helical_speed = "50 mm/s"
[axes]
rpm = [0, 20]
[controllers.p]
type = "pid"
kp = "500 V/m"
[references.sine]
kind = "sine"
amplitude = "20 mm"
frequency = "0.5 Hz"
[simulation]
duration = "1 s"
"""


def setups(folder: Path, text: str) -> list[Setup]:
    path = folder / "study.toml"
    path.write_text(text, encoding="utf-8")
    study = read_study(path)
    return [resolve(study, case).setup for case in unfold(study)]


def test_study_asks_for_the_schedule(tmp_path: Path) -> None:
    """At 0 rpm the plant does not rotate; elsewhere the key says how fast, or else rpm does: 20 rpm of 19 mm."""
    still, keyed = setups(tmp_path, STUDY)
    assert still.rotary is None
    assert keyed.rotary is not None
    assert keyed.rotary.controller is SCHEDULED_ROTATION["motor_voltage"]
    assert keyed.rotation_speed == pytest.approx(0.05 / RADIUS, rel=1e-12)
    assert keyed.state.surface_speed == pytest.approx(0.05, rel=1e-12)
    assert keyed.inputs.motor_voltage == 0.0
    assert keyed.rotary.gains.servo.bias == pytest.approx(
        keyed.plant.equilibrium(keyed.parameters, 0.05)[1].motor_voltage, rel=1e-12
    )
    _, by_rpm = setups(tmp_path, STUDY.replace('minimum_helical_speed = "50 mm/s"\n', ""))
    assert by_rpm.rotation_speed == pytest.approx(20.0 * np.pi / 30.0, rel=1e-12)
    assert by_rpm.state.surface_speed == pytest.approx(20.0 * np.pi / 30.0 * RADIUS, rel=1e-12)
    (ideal,) = setups(tmp_path, STUDY.replace("by_rpm", "rotating_isotropic_ideal").replace("0, 20", "20"))
    assert ideal.rotary is not None
    assert ideal.rotary.controller is SCHEDULED_ROTATION["surface_speed"]
    assert ideal.inputs.surface_speed == 0.0


def test_minimum_without_schedule_is_a_mistake(tmp_path: Path) -> None:
    with pytest.raises(UserError, match='minimum_helical_speed belongs to rotation = "scheduled"'):
        setups(tmp_path, STUDY.replace('"scheduled"', '"servo"'))


# --- nothing reads the truth ---------------------------------------------------------------------------------


def replayed(
    loop: Loop, first: Measurement, record: np.ndarray, references: np.ndarray, realised: np.ndarray
) -> np.ndarray:
    """The commands of a controller that is given the record of the sensors and what was realised, and nothing else."""
    gains = loop.gains
    state = loop.controller.start(first, gains)
    commands = np.empty(len(record))
    for k, reading in enumerate(record):
        command, state = loop.controller.step(Reference(*references[k]), Measurement(*reading), state, gains, H)
        state = loop.controller.commit(realised[k], state, gains, H)
        commands[k] = command
    return commands


@pytest.mark.parametrize(
    ("controller", "settings"),
    [
        (NONLINEAR_PI, nonlinear_pi.Settings(feedforward=1.0)),
        (DITHER, dither.Settings(ki=1000.0)),
        (DISTURBANCE_OBSERVER, disturbance_observer.Settings()),
    ],
    ids=["nonlinear_pi", "dither", "disturbance_observer"],
)
def test_commands_follow_from_the_position_sensor_alone(controller: Controller, settings: Any) -> None:
    """Truth is not what is believed: valve 0.8 times, friction 1.3 times, noise on every sensor.

    The commands of the run come again from the record of its sensors, with pressures and speed of rotation blotted out
    (NaN); and the plant's truth did matter: a plant as believed gives others.
    """
    wrong = loop(controller, settings, Sine(20e-3, 0.5), 0.5, valve_flow_gain=0.8 * 5.9e-4)
    friction = wrong.parameters.friction
    both = (one._replace(coulomb=1.3 * one.coulomb, stribeck=1.3 * one.stribeck) for one in friction)
    wrong = replace(
        wrong,
        parameters=wrong.parameters._replace(friction=type(friction)(*both)),
        sensors=Sensors({"position": Channel(2e-6, 1e-6), "pressure_1": Channel(1e4), "pressure_2": Channel(1e4)}),
    )
    run = simulate(wrong)
    assert run.reference is not None
    blotted = run.measurements.copy()
    blotted[:, 1:] = np.nan
    first = Measurement(0.0, np.nan, np.nan, np.nan)
    commands = replayed(wrong.loop, first, blotted, np.column_stack(run.reference), run.command)
    assert np.clip(commands, -10.0, 10.0) == pytest.approx(run.command, rel=1e-9, abs=1e-9)
    believed = simulate(replace(wrong, parameters=loop(controller, settings, Sine(20e-3, 0.5), 0.5).parameters))
    assert np.max(np.abs(believed.command - run.command)) > 0.05


@pytest.mark.parametrize("plant", ["rotating_isotropic", "rotating_isotropic_ideal"])
def test_schedule_follows_from_position_and_speed_sensors_alone(plant: str) -> None:
    """Motor and masses are not what is believed; the rotary commands come again from the record."""
    setup = registered(plant, rpm=25.0, duration=0.5, reference=Sine(20e-3, 0.5))
    setup = replace(setup, loop=Loop(PID, PID.design(pid.Settings(500.0), setup.parameters, H)), rotation_speed=2.6)
    setup = replace(setup, rotary=scheduled_loop(setup))
    setup = replace(setup, inputs=setup.inputs._replace(**{str(setup.plant.rotary_command): 0.0}))
    truth = setup.parameters._replace(
        motor=setup.parameters.motor._replace(rotary_inertia=0.015, torque_constant=0.7),
        body=setup.parameters.body._replace(mass=50.0),
    )
    run = simulate(replace(setup, parameters=truth, sensors=Sensors({"position": Channel(2e-6)})))
    blotted = run.measurements.copy()
    blotted[:, 1:3] = np.nan
    realised = run.inputs[:, setup.plant.input_index(str(setup.plant.rotary_command))]
    references = np.zeros((run.time.size, 3))
    references[:, 0] = 2.6
    assert setup.rotary is not None
    first = setup.plant.measure(setup.state, truth)._replace(pressure_1=np.nan, pressure_2=np.nan)
    commands = replayed(setup.rotary, first, blotted, references, realised)
    assert commands == pytest.approx(realised, rel=1e-9, abs=1e-9)
    assert np.ptp(commands) > 0.01


def test_states_and_gains_are_plain_numbers() -> None:
    """What the compiled loop carries: vectors of finite numbers, the same length at every sample."""
    for controller in (NONLINEAR_PI, DITHER, DISTURBANCE_OBSERVER, *SCHEDULED_ROTATION.values()):
        gains = controller.design(controller.Settings(), BELIEF, H)
        measured = Measurement(1e-3, 1e6, 1e6, 5.0)
        state = controller.start(measured, gains)
        command, following = controller.step(Reference(2e-3, 0.0, 0.0), measured, state, gains, H)
        for value in (gains, state, following, controller.commit(command, following, gains, H)):
            assert np.all(np.isfinite(to_array(value)))
        assert to_array(following).size == to_array(state).size
