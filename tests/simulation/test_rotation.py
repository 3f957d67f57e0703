"""Rotation as it is: the real speed against the commanded one, what a constant voltage does, what the motor gives."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scenario_study import row_of
from scipy.linalg import expm
from scipy.optimize import brentq

from controllers.speed_servo import SPEED_SERVO, holds, runaway_rate
from workbench.simulation.simulate import Run, simulate
from workbench.study.plan import plan
from workbench.study.reading import read_study
from workbench.study.resolve import Resolved, resolve
from workbench.study.unfold import unfold

RPM = 60.0 / (2.0 * np.pi)

REFERENCES = """
[references.slow_sine]
kind = "sine"
amplitude = "5 mm"
frequency = "0.1 Hz"
[references.fast_sine]
kind = "sine"
amplitude = "20 mm"
frequency = "0.5 Hz"
[references.steps]
kind = "steps"
levels = ["10 mm", "0 mm", "10 mm", "0 mm"]
dwell = "1.5 s"
[references.ramps]
kind = "triangle"
amplitude = "10 mm"
speed = "10 mm/s"
"""

SIMULATED = 'bristle = "isotropic"\nparameters = "owen2001_simulation"\nmotor_limits = false\n'
RIG = 'bristle = "anisotropic"\nparameters = "owen2001_experiment"\n'
UP = "[plant.scale]\ncoulomb = 1.3\nstribeck = 1.3\n"
UP_RIG = UP + "coulomb_rotary = 1.3\nstribeck_rotary = 1.3\n"

SECONDS = {"slow_sine": "12 s"}
"""A whole period of each reference after 2 s; the others take 6 s."""


def text(plant: str, reference: str, rpm: float, more: str = "") -> str:
    gain = 500 if "simulation" in plant else 100
    return (
        f'title = "t"\n[plant]\nmodel = "rotating"\n{plant}{more}[axes]\nrpm = [{rpm}]\nreference = ["{reference}"]\n'
        f'[controllers.p]\ntype = "pid"\nkp = "{gain} V/m"\n{REFERENCES}'
        f'[simulation]\nduration = "{SECONDS.get(reference, "6 s")}"\ntransient = "2 s"\n'
    )


def resolved(folder: Path, content: str) -> Resolved:
    path = folder / "study.toml"
    path.write_text(content, encoding="utf-8")
    study = read_study(path)
    (case,) = unfold(study)
    return resolve(study, case)


def figures(folder: Path, content: str) -> dict[str, float]:
    """The row of the one case of a study."""
    path = folder / "study.toml"
    path.write_text(content, encoding="utf-8")
    study = read_study(path)
    (case,) = unfold(study)
    return row_of(study, case)


def late_rpm(run: Run) -> np.ndarray:
    return RPM * run.signals["rotation_speed"][run.time >= 2.0]


# --- the servo ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rpm", [2, 5, 10, 25, 50, 75, 100, 125])
@pytest.mark.parametrize("reference", ["slow_sine", "fast_sine", "steps", "ramps"])
@pytest.mark.parametrize(
    "machine",
    [(SIMULATED, ""), (SIMULATED, UP), (RIG, ""), (RIG, UP_RIG)],
    ids=["simulated", "simulated_up", "rig", "rig_up"],
)
def test_the_rod_turns_as_commanded(tmp_path: Path, machine: tuple[str, str], reference: str, rpm: int) -> None:
    """The mean within 2 %, also with friction 30 % up; and no stick-slip: it never turns back, or stands for long."""
    plant, changed = machine
    content = text(plant, reference, rpm) + changed.replace("[plant", "[scenarios.up.plant")
    if changed:
        content = content.replace("[axes]\n", '[axes]\nscenario = ["up"]\n')
    run = simulate(resolved(tmp_path, content).setup)
    speed = late_rpm(run)
    assert run.outcome == "completed"
    assert np.mean(speed) == pytest.approx(rpm, rel=0.02)
    assert np.min(speed) > 0.1 * rpm
    if reference == "slow_sine":
        assert np.min(speed) > 0.95 * rpm


@pytest.mark.parametrize("rpm", [8, 10, 12, 15])
def test_no_stick_slip_where_friction_falls_most_steeply(tmp_path: Path, rpm: int) -> None:
    """The steepest fall lies at 11.4 rpm (v_s / sqrt(2)), where a loop too slow sticks and slips."""
    speed = late_rpm(simulate(resolved(tmp_path, text(SIMULATED, "slow_sine", rpm)).setup))
    assert np.min(speed) > 0.99 * rpm
    assert np.max(speed) < 1.01 * rpm


@pytest.mark.parametrize("inductance", [0.7, 1.0, 1.3])
@pytest.mark.parametrize("sample_time", [1e-3, 2e-3])
def test_the_sampled_loop_is_stable_on_every_slope(tmp_path: Path, sample_time: float, inductance: float) -> None:
    """Eigenvalues of rod, winding and integral from sample to sample, V_m held: dw/dt = a w + K_t i / J.

    `inductance`: what the true one is to the believed one.
    """
    belief = resolved(tmp_path, text(SIMULATED, "slow_sine", 10)).belief
    motor, g = belief.motor, SPEED_SERVO.design(SPEED_SERVO.Settings(), belief, sample_time)
    true = inductance * motor.motor_inductance

    def radius(a: float) -> float:
        plant = np.zeros((3, 3))
        plant[0, :2] = a, motor.torque_constant / motor.rotary_inertia
        plant[1] = -motor.back_emf_constant / true, -motor.motor_resistance / true, 1.0 / true
        held = expm(plant * sample_time)
        driving = g.resistance / (1.0 - g.decay)
        feedback = np.array([g.back_emf - driving * g.proportional, -driving * g.decay, driving])
        loop = np.zeros((3, 3))
        loop[:2, :2], loop[2] = held[:2, :2], (-sample_time * g.integral, 0.0, 1.0)
        loop[:2] += np.outer(held[:2, 2], feedback)
        return float(np.max(np.abs(np.linalg.eigvals(loop))))

    rates = np.array([-7.0, -3.0, -1.0, -0.3, 0.0, 0.2, 0.7 / 1.5]) / sample_time
    assert max(radius(a) for a in rates) < 1.0
    assert radius(0.7 / sample_time) > 1.0


def test_the_steepest_fall_of_friction_that_matters(tmp_path: Path) -> None:
    """With 1.5 times the believed Stribeck part 1.5 a1 sqrt(2/e) / v_s - a2 at v_s / sqrt(2); less steep above it."""
    belief = resolved(tmp_path, text(SIMULATED, "slow_sine", 10)).belief
    steepest = 1.5 * 217.0 * np.sqrt(2.0 / np.e) / 0.032 - 2318.0
    assert runaway_rate(belief, 10.0 / RPM) == pytest.approx(steepest * 19e-3**2 / 0.006137, rel=1e-4)
    fast = 0.5 * 100.0 / RPM * 19e-3
    slope = 1.5 * 217.0 * 2.0 * fast / 0.032**2 * np.exp(-((fast / 0.032) ** 2)) - 2318.0
    assert runaway_rate(belief, 100.0 / RPM) == pytest.approx(slope * 19e-3**2 / 0.006137, rel=1e-4)
    assert holds(belief, 10.0 / RPM, 1e-3)
    assert not holds(belief, 10.0 / RPM, 2e-3)


def test_from_standstill_without_windup(tmp_path: Path) -> None:
    """To 460 rpm on the rig, whose motor is at its 30 A meanwhile; the integral takes nothing up that overshoots."""
    start = 'start = "standstill"\n'
    item = resolved(tmp_path, text(RIG + start, "slow_sine", 460))
    run = simulate(item.setup)
    speed, current = RPM * run.signals["rotation_speed"], run.state("motor_current")
    assert speed[0] == 0.0
    assert np.max(np.abs(current)) == pytest.approx(30.0, rel=3e-3)
    assert np.max(speed) < 1.02 * 460.0
    assert speed[-1] == pytest.approx(460.0, rel=1e-3)
    assert run.outcome == "completed"


def test_a_servo_sampled_faster(tmp_path: Path) -> None:
    item = resolved(
        tmp_path, text(SIMULATED, "fast_sine", 10).replace("[simulation]", '[simulation]\nsample_time = "0.1 ms"')
    )
    speed = late_rpm(simulate(item.setup))
    assert np.mean(speed) == pytest.approx(10.0, rel=0.001)
    assert np.min(speed) > 8.5


@pytest.mark.parametrize(
    ("machine", "sensors", "least"),
    [
        (SIMULATED, '[sensors]\ndelay = "2 ms"\n', 8.4),
        (RIG, '[sensors]\ndelay = "2 ms"\n', 9.9),
        (SIMULATED, '[sensors.rotation_speed]\nnoise = "0.02 rad/s"\n[sensors.motor_current]\nnoise = "10 mA"\n', 8.0),
        (RIG, '[sensors.rotation_speed]\nnoise = "0.02 rad/s"\nanti_alias = "194 Hz"\n', 9.0),
    ],
    ids=["simulated_delay", "rig_delay", "simulated_noise", "rig_noise_and_filter"],
)
def test_a_servo_with_sensors_of_a_machine(tmp_path: Path, machine: str, sensors: str, least: float) -> None:
    """A delay is that of the rig's data acquisition: the motor's drive reads speed and current itself, and at once."""
    run = simulate(resolved(tmp_path, text(machine, "fast_sine", 10) + sensors).setup)
    assert run.outcome == "completed"
    assert np.mean(late_rpm(run)) == pytest.approx(10.0, rel=0.02)
    assert np.min(late_rpm(run)) > least


# --- a constant voltage ---------------------------------------------------------------------------------------


VOLTAGE = SIMULATED + 'rotation = "voltage"\n'


@pytest.mark.parametrize("rpm", [5, 10, 15])
def test_a_constant_voltage_on_the_falling_slope_runs_away(tmp_path: Path, rpm: int) -> None:
    """To the speed above that takes the same voltage at rest: R_m F(w) R / K_t + K_bemf w / R, here by bisection."""
    item = resolved(tmp_path, text(VOLTAGE, "slow_sine", rpm))

    def voltage(speed: float) -> float:
        w = speed / RPM * 19e-3
        friction = 370.0 + 217.0 * np.exp(-((w / 0.032) ** 2)) + 2318.0 * w
        return float(1.65 * friction * 19e-3 / 0.77 + 0.6685 * speed / RPM)

    stable = brentq(lambda speed: voltage(speed) - voltage(rpm), 21.5, 60.0)
    assert np.mean(late_rpm(simulate(item.setup))) == pytest.approx(stable, rel=0.01)
    assert stable > 1.5 * rpm


def test_a_believed_voltage_on_more_friction_stalls(tmp_path: Path) -> None:
    """25 rpm is stable, but its believed 22.3 V are 27.05 V on 30 % more friction: the rod falls back below 2 rpm."""
    content = text(VOLTAGE, "slow_sine", 25) + UP.replace("[plant", "[scenarios.up.plant")
    content = content.replace("[axes]\n", '[axes]\nscenario = ["up"]\n')
    item = resolved(tmp_path, content)
    assert item.setup.inputs.motor_voltage == pytest.approx(22.30, abs=0.02)
    truth = item.setup.plant.equilibrium(item.setup.parameters, 25.0 / RPM * 19e-3)[1].motor_voltage
    assert truth == pytest.approx(27.05, abs=0.02)
    assert np.mean(late_rpm(simulate(item.setup))) == pytest.approx(1.0, abs=0.1)


def warned(folder: Path, content: str) -> list[str]:
    path = folder / "study.toml"
    path.write_text(content, encoding="utf-8")
    return [line for line in plan(read_study(path)).warnings if "plant.rotation" in line]


@pytest.mark.parametrize(("rpm", "unstable"), [(3.9, False), (4.1, True), (10, True), (21.0, True), (21.3, False)])
def test_an_unstable_voltage_is_warned_of(tmp_path: Path, rpm: float, unstable: bool) -> None:
    """R^2 (a2 - 2 a1 w / v_s^2 exp(-(w/v_s)^2)) + K_t K_bemf / R_m is negative from 4.0 to 21.1 rpm."""
    w = rpm / RPM * 19e-3
    slope = 2318.0 - 217.0 * 2.0 * w / 0.032**2 * np.exp(-((w / 0.032) ** 2))
    assert bool(19e-3**2 * slope + 0.77 * 0.6685 / 1.65 < 0.0) is unstable
    found = warned(tmp_path, text(VOLTAGE, "fast_sine", rpm))
    assert bool(found) is unstable
    assert not warned(tmp_path, text(SIMULATED, "fast_sine", rpm))
    if unstable:
        assert "study.toml:7: plant.rotation: a constant voltage holds no " in found[0]


def test_speeds_that_no_servo_holds_are_warned_of(tmp_path: Path) -> None:
    """The rig's friction along the rod falls steepest at 0.5 rpm; its drive ends at 500 rpm."""
    (steep,) = warned(tmp_path, text(RIG.replace("anisotropic", "isotropic"), "fast_sine", 0.6))
    assert "no servo sampled every 0.001 s is sure to hold it" in steep
    (fast,) = warned(tmp_path, text(RIG, "fast_sine", 600))
    assert "600 rpm is beyond what the motor's drive is limited to, 500 rpm" in fast
    assert not warned(tmp_path, text(RIG + "motor_limits = false\n", "fast_sine", 600))


def test_a_rod_that_nothing_turns_is_warned_of(tmp_path: Path) -> None:
    content = text(SIMULATED, "fast_sine", 0)
    assert not warned(tmp_path, content)
    (still,) = warned(tmp_path, content.replace("rpm = [0]\n", ""))
    assert "no rpm is given: the rod does not turn" in still


# --- the motor ------------------------------------------------------------------------------------------------


def test_a_motor_that_cannot(tmp_path: Path) -> None:
    """588 N static at the simulated rod's 19 mm are 11 N m; at 460 rpm it takes 47 N m, twice what 30 A give."""
    within = figures(tmp_path, text(SIMULATED.replace("false", "true"), "fast_sine", 10))
    assert within["outcome"] == "completed"
    assert within["torque_limited_fraction"] == 0.0
    beyond = figures(tmp_path, text(SIMULATED.replace("false", "true"), "fast_sine", 460))
    assert beyond["outcome"] == "torque-limited"
    assert beyond["torque_limited_fraction"] > 0.9
    assert beyond["motor_torque_rms_N_m"] == pytest.approx(30.0 * 0.77, rel=0.01)
    assert beyond["rotation_speed_mean_rpm"] < 250.0
    lifted = figures(tmp_path, text(SIMULATED, "fast_sine", 460))
    assert lifted["outcome"] == "completed"
    assert lifted["motor_torque_rms_N_m"] == pytest.approx(47.0, abs=0.5)
    assert lifted["torque_limited_fraction"] == 0.0


def test_a_motor_that_starts_beyond_its_limit_slows_down(tmp_path: Path) -> None:
    """A constant voltage asks for 77 A at 600 rpm, and the drive gives 30."""
    plant = SIMULATED.replace("false", "true") + 'rotation = "voltage"\n'
    run = simulate(resolved(tmp_path, text(plant, "fast_sine", 600)).setup)
    assert np.max(np.abs(run.state("motor_current"))) <= 30.0 * (1.0 + 1e-9)
    assert np.max(late_rpm(run)) < 400.0


def test_limits_that_an_axis_lifts_are_lifted_for_the_servo_too(tmp_path: Path) -> None:
    plant = SIMULATED.replace("motor_limits = false\n", "")
    content = text(plant, "fast_sine", 600).replace("[axes]\n", '[axes]\n"plant.motor_limits" = [true, false]\n')
    (tmp_path / "study.toml").write_text(content, encoding="utf-8")
    limited, free = (simulate(item.setup) for item in plan(read_study(tmp_path / "study.toml")).resolved)
    assert limited.outcome == "torque-limited"
    assert np.mean(late_rpm(free)) == pytest.approx(600.0, rel=0.02)


@pytest.mark.parametrize("motor", ["printed", "consistent"])
def test_power_at_the_terminals(tmp_path: Path, motor: str) -> None:
    """V i - R_m i^2 = K_bemf i omega, the shaft's F w = K_t i omega: they agree where the constants do."""
    row = figures(tmp_path, text(SIMULATED + f'motor = "{motor}"\n', "slow_sine", 50))
    current, omega = row["motor_torque_rms_N_m"] / 0.77, 50.0 / RPM
    emf = 0.77 if motor == "consistent" else 0.6685
    loss = 1.65 * current**2 + (emf - 0.77) * current * omega
    assert row["motor_loss_W"] == pytest.approx(loss, rel=1e-3)
    assert row["motor_electric_power_W"] == pytest.approx(row["rotation_power_W"] + row["motor_loss_W"], rel=1e-9)
    assert row["paid_power_W"] == pytest.approx(row["supply_power_W"] + row["motor_electric_power_W"], rel=1e-12)


@cache
def cost(folder: Path, bristle: str) -> tuple[float, float, float]:
    plant = f'bristle = "{bristle}"\nparameters = "owen2001_experiment"\nmotor_limits = false\n'
    row = figures(folder, text(plant, "slow_sine", 50))
    return row["rotation_power_W"], row["motor_torque_rms_N_m"], row["rotation_speed_mean_rpm"]


def test_the_friction_around_the_rod_decides_the_cost(tmp_path: Path) -> None:
    """50 rpm on the rig: (g + a2 w) w with the axial set is 756 W; with what was measured around the rod 6 W.

    There F_r = S_r^2 w / sqrt((S_a v)^2 + (S_r w)^2) + a2 w, with the reference's v.
    """
    w = 50.0 / RPM * 31.75e-3
    along = (0.5 * (330.0 + 290.0) + 0.5 * (22800.0 + 28200.0) * w) * w
    assert cost(tmp_path, "isotropic") == pytest.approx((along, along / w * 31.75e-3, 50.0), rel=0.01)
    assert cost(tmp_path, "helical") == pytest.approx(cost(tmp_path, "isotropic"), rel=0.01)
    power, torque, speed = cost(tmp_path, "anisotropic")
    assert along == pytest.approx(756.0, rel=0.005)
    v = 5e-3 * 0.2 * np.pi * np.cos(np.linspace(0.0, 2.0 * np.pi, 1001)[1:])
    level = 34.7 + 14.6 * np.exp(-((w / 0.042) ** 2))
    around = level**2 * w / np.hypot(310.0 * v, level * w) + 8.3 * w
    assert power == pytest.approx(np.mean(around) * w, rel=0.02)
    assert torque < 8.0 < along / w * 31.75e-3
    assert speed == pytest.approx(50.0, rel=0.001)


def test_below_the_stribeck_speed(tmp_path: Path) -> None:
    """Slow sine: |v| up to 3.1 mm/s; 10 rpm are 19.9 mm/s and 25 rpm 49.7 mm/s, with a Stribeck velocity of 32 mm/s."""
    share = [figures(tmp_path, text(SIMULATED, "slow_sine", rpm))["below_stribeck_fraction"] for rpm in (10, 25)]
    assert share == [1.0, 0.0]
    fast = figures(tmp_path, text(SIMULATED, "fast_sine", 10))["below_stribeck_fraction"]
    # v = 20 mm pi cos(pi t) less what P lags, w = 19.9 mm/s: |v| < 25.1 mm/s in 26 % of the time of the reference
    assert fast == pytest.approx(2.0 / np.pi * np.arcsin(np.sqrt(32.0**2 - 19.9**2) / (20.0 * np.pi)), abs=0.02)
