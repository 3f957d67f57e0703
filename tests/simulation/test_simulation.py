"""The loop around the integrators: feeds, saturation, outcomes, speed of rotation, compiled against plain Python."""

import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys
from support import OSCILLATOR, PENDULUM, registered, start

from controllers.interface import Controller, Reference
from controllers.pid import PID, Gains
from controllers.registry import controllers
from controllers.speed_servo import SPEED_SERVO
from controllers.velocity import filtered_differentiator
from plants.equation import fields, from_array
from plants.friction_gauge import gauged
from plants.interface import Measurement, Plant
from plants.registry import THESIS
from workbench.fitting.replay import Sampled
from workbench.simulation import compilation, engine
from workbench.simulation.compilation import compile_derivatives
from workbench.simulation.references import Multisine, Ramp, Recorded, ReferenceSignal, Sine, Steps
from workbench.simulation.sensors import Channel, Sensors
from workbench.simulation.simulate import Feed, Integrator, Loop, Run, Setup, simulate

CUBIC = Integrator(tolerance=1e-12)


def proportional(gain: float) -> Loop:
    return Loop(PID, Gains(gain, 0.0, 0.0, 0.0, 0.0, filtered_differentiator(2e-3, 1e-3)))


def test_held_feed_on_a_free_mass() -> None:
    """A force held over each sample: v(k) = h sum F, x(k) = h sum v + h^2/2 sum F."""
    h, force = 1e-3, np.random.default_rng(7).normal(size=300)
    time = h * np.arange(force.size)
    run = simulate(
        start(
            OSCILLATOR,
            duration=time[-1],
            feeds=(Feed("pull", Recorded(time, force), linear=False),),
            integrator=CUBIC,
        )
    )
    velocity = h * np.concatenate([[0.0], np.cumsum(force[:-1])])
    steps = h * velocity[:-1] + 0.5 * h * h * force[:-1]
    assert run.state("velocity") == pytest.approx(velocity, abs=1e-13)
    assert run.state("position") == pytest.approx(np.concatenate([[0.0], np.cumsum(steps)]), abs=1e-13)


def test_linear_feed_on_a_free_mass() -> None:
    """A force a t from 0.1 s on: v = a s^2/2, x = a s^3/6 with s = t - 0.1 s; a held feed lags by half a sample."""
    slope, begin = 12.0, 0.1
    setup = start(OSCILLATOR, feeds=(Feed("pull", Ramp(slope, begin)),), integrator=CUBIC)
    run = simulate(setup)
    s = np.maximum(run.time - begin, 0.0)
    assert run.state("velocity") == pytest.approx(slope * s**2 / 2.0, abs=1e-12)
    assert run.state("position") == pytest.approx(slope * s**3 / 6.0, abs=1e-12)
    assert run.inputs[:, 1] == pytest.approx(slope * s, abs=1e-12)

    held = simulate(replace(setup, feeds=(Feed("pull", Ramp(slope, begin), linear=False),)))
    lag = slope * s[-1] * setup.sample_time / 2.0
    assert run.state("velocity")[-1] - held.state("velocity")[-1] == pytest.approx(lag, rel=1e-9)


@pytest.mark.parametrize("late", [0.0, 0.3, 1.0, 2.3])
def test_a_held_command_that_comes_late_changes_within_a_sample(late: float) -> None:
    """In each sample a force for the share of it by which it is late, and the next one for the rest."""
    h, force = 1e-3, np.random.default_rng(7).normal(size=300)
    times, whole = h * np.arange(force.size), int(late)
    feed = Feed("force", Sampled(times, force), linear=False, delay=late * h)
    run = simulate(start(OSCILLATOR, duration=times[-1], feeds=(feed,), integrator=CUBIC))
    first, rest = (late - whole) * h, (1.0 - late + whole) * h
    arrived = np.concatenate([np.full(whole + 1, force[0]), force])
    before, after = arrived[: force.size - 1], arrived[1 : force.size]
    velocity = np.concatenate([[0.0], np.cumsum(first * before + rest * after)])
    steps = h * velocity[:-1] + before * (first * h - 0.5 * first**2) + after * 0.5 * rest**2
    assert run.state("velocity") == pytest.approx(velocity, abs=1e-13)
    assert run.state("position") == pytest.approx(np.concatenate([[0.0], np.cumsum(steps)]), abs=1e-13)


def test_two_feeds_of_one_input_add_up() -> None:
    feeds = (Feed("pull", Ramp(2.0)), Feed("pull", Steps((3.0,), 1.0), linear=False))
    run = simulate(start(OSCILLATOR, feeds=feeds, integrator=CUBIC))
    assert run.inputs[:, 1] == pytest.approx(3.0 + 2.0 * run.time, abs=1e-12)


def test_ramping_command_stops_at_the_limit() -> None:
    """A command 10 t N with a limit of 2 N, reached at 0.2 s: v = 5 t^2, then 0.2 + 2 (t - 0.2)."""
    run = simulate(start(OSCILLATOR, limit=2.0, feeds=(Feed("force", Ramp(10.0)),), integrator=CUBIC))
    t = run.time
    assert run.command == pytest.approx(np.minimum(10.0 * t, 2.0), abs=1e-12)
    expected = np.where(t < 0.2, 5.0 * t**2, 0.2 + 2.0 * (t - 0.2))
    assert run.state("velocity") == pytest.approx(expected, abs=1e-12)


def test_limit_holds_for_the_command_alone() -> None:
    """The command's limit does not clip what else pulls at the plant."""
    run = simulate(start(OSCILLATOR, limit=2.0, feeds=(Feed("pull", Ramp(10.0)),), integrator=CUBIC))
    assert run.state("velocity") == pytest.approx(5.0 * run.time**2, abs=1e-12)


def test_a_loop_drives_the_input_that_it_names_and_no_limit_but_the_command_s_holds() -> None:
    """4 N/m of the way to 1 m pull at 1 kg, x = 1 - cos 2t but for the samples; the command stays what its feed is."""
    loop = replace(proportional(4.0), drives="pull")
    feeds = (Feed("force", Ramp(0.0)),)
    run = simulate(start(OSCILLATOR, limit=0.5, loop=loop, reference=Steps((1.0,), 1.0), feeds=feeds, integrator=CUBIC))
    assert np.all(run.command == 0.0)
    assert run.inputs[:, 1] == pytest.approx(4.0 * (1.0 - run.state("position")), abs=1e-12)
    assert run.state("position") == pytest.approx(1.0 - np.cos(2.0 * run.time), abs=5e-3)


def test_saturated_throughout() -> None:
    """1000 N/m times 1 m asks for 1000 N of 0.5 N: the mass gets 0.5 m/s^2 and never comes near."""
    reference = Steps((1.0,), 1.0)
    run = simulate(start(OSCILLATOR, limit=0.5, loop=proportional(1000.0), reference=reference))
    assert run.outcome == "saturated throughout"
    assert run.state("position") == pytest.approx(0.25 * run.time**2, abs=1e-9)


def test_end_stop_holds_the_piston() -> None:
    """5 V drive the piston into the stop: 1e8 N/m carry 2.94 MPa on 6.33e-4 m^2 less what friction still holds."""
    command = Feed("valve_voltage", Steps((5.0,), 1.0), linear=False)
    run = simulate(registered("non_rotating", duration=1.0, feeds=(command,)))
    assert run.outcome == "end stop"
    held = run.signals["axial_friction"][-1]
    assert abs(held) < 370.0 + 217.0
    assert 1e8 * (run.state("position")[-1] - 0.03) == pytest.approx(2.94e6 * 6.33e-4 - held, rel=1e-4)
    assert abs(run.state("velocity")[-1]) < 1e-6


def test_stuck_mass_moves_by_its_bristle_alone() -> None:
    """0.5 N of a static friction of 1.5 N, risen slowly over a quarter of a sine, at whose end nothing moves.

    From a straight bristle dz/dx = 1 - sigma0 z/g with sigma0 z = F, so x = -(g/sigma0) ln(1 - F/g) = 6.08 um.
    """
    setup = registered(
        "drive_force", "canudas1995", duration=5.0, loop=proportional(1.0), reference=Sine(0.5, 1.0 / 20.0)
    )
    run = simulate(setup)
    assert run.outcome == "stuck"
    assert run.state("position")[-1] == pytest.approx(-1.5e-5 * np.log(1.0 - 0.5 / 1.5), rel=1e-3)
    assert simulate(replace(setup, reference=Steps((0.0,), 1.0))).outcome == "completed"


@pytest.mark.parametrize(
    ("gain", "reference"), [(2.0, Sine(5e-3, 1.0)), (2.0, Sine(5e-3, 1.0, 5e-3)), (0.2, Steps((5e-3,), 2.0))]
)
def test_a_rod_that_hardly_moves(gain: float, reference: ReferenceSignal) -> None:
    """2 V/m ask for some 10 mV, which move the rod by 0.7 mm/s, 2 % of the sine; 400 V/m are followed."""
    setup = registered("non_rotating", duration=2.0, reference=reference, loop=proportional(gain))
    assert simulate(setup).outcome == "hardly moves"
    assert simulate(replace(setup, loop=proportional(400.0))).outcome == "completed"


def test_diverged_run_has_finite_signals_and_no_warning() -> None:
    """The bristle with explicit Euler steps of 1 ms is unstable beyond 2 g/(sigma0 h) = 0.13 m/s (at 10 V: 0.68).

    A warning would be an error here.
    """
    command = Feed("valve_voltage", Steps((10.0,), 1.0), linear=False)
    run = simulate(registered("non_rotating", duration=1.0, feeds=(command,), integrator=Integrator("euler", 1e-3)))
    assert run.outcome == "diverged"
    assert run.time.size < 100
    assert run.signals["axial_friction"].size == run.time.size
    assert np.all(np.isfinite(run.states))


def test_same_setup_gives_the_same_bytes() -> None:
    sensors = Sensors({"position": Channel(noise=1e-5, resolution=1e-6, anti_alias=200.0)}, delay=1.3e-3)
    setup = registered(
        "non_rotating", duration=0.5, loop=proportional(500.0), reference=Sine(0.01, 2.0), sensors=sensors, seed=4
    )
    first = simulate(setup)
    with ThreadPoolExecutor(2) as pool:
        others = list(pool.map(simulate, [setup] * 4))
    for other in others:
        for name in ("states", "inputs", "measurements"):
            assert getattr(first, name).tobytes() == getattr(other, name).tobytes()
    assert simulate(replace(setup, seed=5)).states.tobytes() != first.states.tobytes()


def test_signals_carry_reference_error_and_inputs() -> None:
    run = simulate(registered("non_rotating", duration=0.2, loop=proportional(500.0), reference=Sine(0.01, 2.0)))
    wanted = 0.01 * np.sin(4.0 * np.pi * run.time)
    assert run.signals["reference_position"] == pytest.approx(wanted, abs=1e-15)
    assert run.signals["error"] == pytest.approx(wanted - run.states[:, 0], abs=1e-15)
    assert run.signals["valve_voltage"] == pytest.approx(500.0 * run.signals["error"], abs=1e-12)
    assert np.array_equal(run.signals["disturbance_force"], np.zeros(run.time.size))


def test_plug_in_plants_do_not_share_compiled_code() -> None:
    """Two plants of one file that differ in one function: a sine, and a slower swing from the same height."""
    oscillator, pendulum = (
        simulate(start(plant, 2.0, stiffness=1.0, integrator=CUBIC)).state("position")[-1]
        for plant in (OSCILLATOR, PENDULUM)
    )
    assert oscillator == pytest.approx(2.0 * np.cos(1.0), abs=1e-9)
    assert pendulum > oscillator + 0.3


# --- speed of rotation ---------------------------------------------------------------------------------------

SPEED = 460.0 * 2.0 * np.pi / 60.0
"""rad/s"""


def rotating(name: str = "rotating_helical", **options: Any) -> Setup:
    chosen = {"rpm": 460.0, "duration": 3.0, "motor_limits": False}
    return registered(name, **chosen, loop=proportional(500.0), reference=Sine(0.03, 0.9), **options)


def droop(run: Run) -> float:
    """Largest deviation from the wanted speed of rotation (rpm)."""
    return float(np.max(np.abs(run.signals["rotation_speed"] - SPEED))) * 60.0 / (2.0 * np.pi)


def test_speed_servo_holds_the_speed_under_a_moving_piston() -> None:
    setup = rotating()
    assert simulate(replace(setup, reference=None)).signals["rotation_speed"] == pytest.approx(SPEED, rel=1e-9)
    settings = SPEED_SERVO.Settings(SPEED, setup.state.motor_current)
    gains = SPEED_SERVO.design(settings, setup.parameters, setup.sample_time)
    servo = replace(setup, rotary=Loop(SPEED_SERVO, gains), rotation_speed=SPEED)
    servo = replace(servo, inputs=servo.inputs._replace(motor_voltage=0.0))
    voltage, held = droop(simulate(setup)), droop(simulate(servo))
    assert voltage > 0.5
    assert held < voltage / 4.0


def test_imposed_speed_is_held_exactly() -> None:
    run = simulate(rotating("rotating_helical_ideal"))
    assert run.outcome == "completed"
    assert droop(run) < 1e-10


# --- every controller, compiled against plain Python ---------------------------------------------------------


def replay(controller: Controller, gains: Any, setup: Setup, run: Run) -> np.ndarray:
    """Commands of the plain Python equations over the measurements of a run, told what the run realised."""
    state = controller.start(setup.plant.measure(setup.state, setup.parameters), gains)
    commands = []
    profile = np.column_stack(run.reference)
    for wanted, reading, realised in zip(profile, run.measurements, run.command, strict=True):
        reference, measurement = Reference(*map(float, wanted)), Measurement(*map(float, reading))
        command, state = controller.step(reference, measurement, state, gains, setup.sample_time)
        commands.append(float(command))
        state = controller.commit(float(realised), state, gains, setup.sample_time)
    return np.array(commands)


def with_limit(setup: Setup, volts: float) -> Setup:
    hydraulics = setup.parameters.hydraulics._replace(voltage_limit=volts)
    return replace(setup, parameters=setup.parameters._replace(hydraulics=hydraulics))


@pytest.mark.parametrize("controller", [*controllers().values(), SPEED_SERVO], ids=lambda item: item.name)
def test_compiled_controller_equals_its_equations(controller: Controller) -> None:
    """Random gains and noise on every sensor, with an amplifier that saturates three times in ten."""
    numbers = np.random.default_rng(11).uniform(0.05, 0.3, len(fields(controller.Gains)))
    gains = from_array(controller.Gains, map(float, numbers))
    noise = {"position": 1.0, "pressure_1": 1e4, "pressure_2": 1e4, "rotation_speed": 1.0}
    setup = registered(
        "rotating_helical",
        rpm=460.0,
        duration=0.1,
        reference=Multisine(0.01, 10.0, (1, 3)),
        loop=Loop(controller, gains),
        sensors=Sensors({name: Channel(noise=size) for name, size in noise.items()}),
    )
    if controller.gauge:
        setup = replace(setup, plant=gauged(setup.plant))
    unlimited = simulate(with_limit(setup, 1e6))
    limit = float(np.quantile(np.abs(unlimited.command), 0.7))
    for run, bound in ((unlimited, 1e6), (simulate(with_limit(setup, limit)), limit)):
        assert run.time.size == 101
        expected = np.clip(replay(controller, gains, setup, run), -bound, bound)
        assert run.command == pytest.approx(expected, rel=1e-12, abs=1e-15)


def test_the_compiled_loop_has_no_array_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """It has pointers alone; numba would free an array of its own before the last use, under the feet of other threads.

    Each array that is handed in takes one block, for numba's view of it.
    """
    allocated, handed = [], []

    def counted(*arguments: Any) -> Any:
        groups = [item if isinstance(item, tuple) else (item,) for item in arguments]
        handed.append(sum(isinstance(one, np.ndarray) for group in groups for one in group))
        before = rtsys.get_allocation_stats().alloc
        found = run_loop(*arguments)
        allocated.append(rtsys.get_allocation_stats().alloc - before)
        return found

    run_loop = engine.run_loop
    monkeypatch.setattr(engine, "run_loop", counted)
    enabled = _nrt_python.memsys_stats_enabled()
    _nrt_python.memsys_enable_stats()
    try:
        simulate(start(OSCILLATOR, duration=0.1, loop=proportional(3.0), reference=Sine(1.0, 2.0)))
    finally:
        if not enabled:
            _nrt_python.memsys_disable_stats()
    assert allocated == handed


def test_two_threads_run_the_same_code(monkeypatch: pytest.MonkeyPatch) -> None:
    """Were it compiled for each, that of one would be freed while its addresses are in use."""
    made = []

    def slowly(plant: Plant) -> Any:
        time.sleep(0.05)
        made.append(compile_derivatives(plant))
        return made[-1]

    monkeypatch.setattr(compilation, "compile_derivatives", slowly)
    plant = replace(THESIS, name="of this test alone")
    with ThreadPoolExecutor(4) as threads:
        addresses = set(threads.map(compilation.plant_addresses, [plant] * 4))
    assert len(made) == len(addresses) == 1
