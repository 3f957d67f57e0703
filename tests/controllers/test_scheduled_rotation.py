"""Scheduled rotation: by hand, on the simulated plants, and asked for by a study."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import changed, write
from position_loops import BELIEF, H, replayed
from support import registered

from controllers import pid, rotation_on_demand, speed_servo
from controllers.interface import Reference
from controllers.pid import PID
from controllers.rotation_on_demand import SCHEDULED_ROTATION
from plants.interface import Measurement
from workbench.errors import UserError
from workbench.simulation.references import Sine
from workbench.simulation.sensors import Channel, Sensors
from workbench.simulation.simulate import Loop, Run, Setup, simulate
from workbench.study.reading import read_study
from workbench.study.resolve import resolve
from workbench.study.unfold import unfold

RADIUS = 19e-3


def turn(
    input_name: str, positions: np.ndarray, turning: float, bias: float = 0.0
) -> tuple[list[float], list[float], Any]:
    """Commands and scheduled speeds over positions (m) for a minimum of 5 rad/s, starting at `turning` (rad/s)."""
    controller = SCHEDULED_ROTATION[input_name]
    gains = controller.design(rotation_on_demand.Settings(5.0, bias), BELIEF, H)
    state = controller.start(Measurement(positions[0], np.nan, np.nan, turning), gains)
    commands, scheduled = [], []
    for position in positions:
        measured = Measurement(position, np.nan, np.nan, turning, bias)
        command, state = controller.step(Reference(5.0, 0.0, 0.0), measured, state, gains, H)
        state = controller.commit(command, state, gains, H)
        commands.append(float(command))
        scheduled.append(float(state.demanded))
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
    """Bias 2 A at 5 rad/s is 2.02 A at 5.05, plus the servo's gain times 0.05 rad/s, plus its integral.

    From 2 A the winding of 10.4 mH and 1.65 ohm gets there in a sample of 1 ms, and has 0.6685 V s/rad against it.
    """
    commands, _, gains = turn("motor_voltage", np.zeros(2), 5.0, bias=2.0)
    servo = speed_servo.design(speed_servo.Settings(5.0, 2.0), BELIEF, H)
    assert gains.servo == servo
    first = 2.02 + 0.05 * servo.proportional
    decay = np.exp(-1.65 * H / 10.4e-3)
    voltages = [
        0.6685 * 5.0 + 1.65 * (current - decay * 2.0) / (1.0 - decay)
        for current in (first, first + H * servo.integral * 0.05)
    ]
    assert commands == pytest.approx(voltages, rel=1e-12)


def turned(plant: str, minimum: float, command: Callable[[Setup], Loop] | None) -> Run:
    """P 500 V/m on 20 mm at 0.5 Hz while the rod turns: as it started, or by the rotary loop of `command`."""
    setup = registered(plant, rpm=minimum / RADIUS * 30.0 / np.pi, duration=6.0, reference=Sine(20e-3, 0.5))
    setup = replace(setup, loop=Loop(PID, PID.design(pid.Settings(500.0), setup.parameters, H)))
    if command is not None:
        inputs = setup.inputs._replace(**{str(setup.plant.rotary_command): 0.0})
        setup = replace(setup, rotary=command(setup), rotation_speed=minimum / RADIUS, inputs=inputs)
    return simulate(setup)


def scheduled_loop(setup: Setup, surface_acceleration: float = 5.0) -> Loop:
    name = str(setup.plant.rotary_command)
    speed = float(np.nan_to_num(setup.plant.measure(setup.state, setup.parameters).rotation_speed))
    current = getattr(setup.state, "motor_current", 0.0)
    settings = rotation_on_demand.Settings(speed, current, surface_acceleration)
    return Loop(SCHEDULED_ROTATION[name], SCHEDULED_ROTATION[name].design(settings, setup.parameters, H))


def servo_loop(setup: Setup) -> Loop:
    settings = speed_servo.Settings(setup.state.surface_speed / RADIUS, setup.state.motor_current)
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
    expected = rotation_on_demand.MARGIN * 0.05 * np.sqrt(1.0 - (braking / 0.3) ** 2)
    assert lowest == pytest.approx(expected, rel=0.02)
    assert lowest < 0.95 * 0.05


@pytest.mark.parametrize("setting", ["surface_acceleration", "velocity_time_constant"])
def test_settings_of_the_schedule(setting: str) -> None:
    settings = rotation_on_demand.Settings()._replace(**{setting: 0.0})
    with pytest.raises(ValueError, match=f"{setting} is 0, expected a value above 0"):
        rotation_on_demand.design(settings, BELIEF, H)


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


# --- in a study ---


TURNED = 'parameters = "owen2001_simulation"\nrotation = "scheduled"\nminimum_helical_speed = "50 mm/s"\n'
SCHEDULED = changed('parameters = "owen2001_simulation"\n', TURNED, changed("[0, 460]", "[0, 20]"))
"""The tests' small study, at rest and scheduled."""


def setups(folder: Path, text: str) -> list[Setup]:
    study = read_study(write(folder, text))
    return [resolve(study, case).setup for case in unfold(study)]


def test_study_asks_for_the_schedule(tmp_path: Path) -> None:
    """At 0 rpm the plant does not rotate; elsewhere the key says how fast, or else rpm does: 20 rpm of 19 mm."""
    still, keyed = setups(tmp_path, SCHEDULED)
    assert still.rotary is None
    assert keyed.rotary is not None
    assert keyed.rotary.controller is SCHEDULED_ROTATION["motor_voltage"]
    assert keyed.rotation_speed == pytest.approx(0.05 / RADIUS, rel=1e-12)
    assert keyed.state.surface_speed == pytest.approx(0.05, rel=1e-12)
    assert keyed.inputs.motor_voltage == 0.0
    assert keyed.rotary.gains.servo.bias == pytest.approx(
        keyed.plant.equilibrium(keyed.parameters, 0.05)[0].motor_current, rel=1e-12
    )
    _, by_rpm = setups(tmp_path, SCHEDULED.replace('minimum_helical_speed = "50 mm/s"\n', ""))
    assert by_rpm.rotation_speed == pytest.approx(20.0 * np.pi / 30.0, rel=1e-12)
    assert by_rpm.state.surface_speed == pytest.approx(20.0 * np.pi / 30.0 * RADIUS, rel=1e-12)
    (ideal,) = setups(tmp_path, SCHEDULED.replace("by_rpm", "rotating_isotropic_ideal").replace("0, 20", "20"))
    assert ideal.rotary is not None
    assert ideal.rotary.controller is SCHEDULED_ROTATION["surface_speed"]
    assert ideal.inputs.surface_speed == 0.0


def test_minimum_without_schedule_is_a_mistake(tmp_path: Path) -> None:
    with pytest.raises(UserError, match='minimum_helical_speed belongs to rotation = "scheduled"'):
        setups(tmp_path, SCHEDULED.replace('"scheduled"', '"servo"'))
