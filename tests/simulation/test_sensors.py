"""Sensors against their definitions: noise statistics, converter steps, analogue filter, delay, systematic errors."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support import OSCILLATOR, hydraulic, registered, start

from controllers.pid import PID
from plants.interface import Measurement
from workbench.simulation.references import Steps
from workbench.simulation.sensors import Channel, Sensors, systematic_error
from workbench.simulation.simulate import Integrator, Loop, Run, simulate

FREQUENCY = 7.0
OMEGA = 2.0 * np.pi * FREQUENCY
AMPLITUDE = 3e-3

COSINE = start(
    OSCILLATOR,
    AMPLITUDE,
    stiffness=OMEGA**2,
    duration=1.0,
    integrator=Integrator(tolerance=1e-12),
)
"""An undamped mass on a spring: x = A cos(w t), v = -A w sin(w t)."""


def measured(run: Run, name: str = "position") -> np.ndarray:
    return run.measurements[:, Measurement._fields.index(name)]


def test_ideal_sensors_read_the_plant() -> None:
    run = simulate(COSINE)
    assert np.array_equal(measured(run), run.state("position"))
    assert np.array_equal(measured(run, "pressure_1"), run.state("velocity"))
    assert measured(run) == pytest.approx(AMPLITUDE * np.cos(OMEGA * run.time), abs=1e-12)


def test_noise_is_white_with_the_given_deviation() -> None:
    """N = 20 001: mean, deviation and lag-one correlation within four of their own standard errors."""
    sigma = 13e-6
    sensors = Sensors({"position": Channel(noise=sigma)})
    run = simulate(replace(COSINE, duration=20.0, sensors=sensors, seed=1))
    noise = (measured(run) - run.state("position")) / sigma
    n = noise.size
    assert abs(np.mean(noise)) < 4.0 / np.sqrt(n)
    assert np.std(noise) == pytest.approx(1.0, abs=4.0 / np.sqrt(2.0 * n))
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 4.0 / np.sqrt(n)
    assert np.mean(np.abs(noise) < 1.0) == pytest.approx(0.6827, abs=4.0 * np.sqrt(0.68 * 0.32 / n))


def test_channels_draw_from_streams_of_their_own() -> None:
    """Noise on another channel changes nothing on this one, and is not the same noise."""
    one = Sensors({"position": Channel(noise=1.0)}).noise(5000, 3)
    two = Sensors({"position": Channel(noise=1.0), "pressure_1": Channel(noise=2.0)}).noise(5000, 3)
    assert np.array_equal(one[:, 0], two[:, 0])
    assert np.all(one[:, 1:] == 0.0)
    assert abs(np.corrcoef(two[:, 0], two[:, 1])[0, 1]) < 4.0 / np.sqrt(5000)


def test_seed_decides_the_noise() -> None:
    setup = replace(COSINE, sensors=Sensors({"position": Channel(noise=1e-5)}), seed=8)
    first, again, other = (measured(simulate(replace(setup, seed=seed))) for seed in (8, 8, 9))
    assert first.tobytes() == again.tobytes()
    assert not np.any(first == other)


def test_converter_rounds_to_the_nearest_step() -> None:
    step = 2.0**-14
    run = simulate(replace(COSINE, sensors=Sensors({"position": Channel(resolution=step)})))
    counts = measured(run) / step
    assert np.array_equal(counts, np.rint(counts))
    assert np.max(np.abs(measured(run) - run.state("position"))) <= step / 2.0
    assert np.ptp(counts) == 2 * np.rint(AMPLITUDE / step)


def test_converter_comes_after_the_noise() -> None:
    """A sensor at rest that is finer in noise than in steps still delivers whole steps only."""
    step = 1e-5
    channel = Channel(noise=step, resolution=step)
    run = simulate(replace(COSINE, state=COSINE.state._replace(position=0.0), sensors=Sensors({"position": channel})))
    counts = measured(run) / step
    assert counts == pytest.approx(np.rint(counts), abs=1e-9)
    assert set(np.rint(counts)) >= {-2.0, -1.0, 0.0, 1.0, 2.0}


@pytest.mark.parametrize("cutoff", [2.0, 7.0, 150.0])
def test_filter_is_the_analytic_first_order_lag(cutoff: float) -> None:
    """dy/dt = wc (x - y) from y = x: A Re(H e^(i w t)) + A (1 - Re H) e^(-wc t), H = wc/(wc + i w)."""
    run = simulate(replace(COSINE, sensors=Sensors({"position": Channel(anti_alias=cutoff)})))
    wc = 2.0 * np.pi * cutoff
    response = wc / (wc + 1j * OMEGA)
    steady = (response * np.exp(1j * OMEGA * run.time)).real
    expected = AMPLITUDE * (steady + (1.0 - response.real) * np.exp(-wc * run.time))
    assert measured(run) == pytest.approx(expected, abs=1e-11)
    assert np.array_equal(measured(run, "pressure_1"), run.state("velocity"))


def test_filter_gain_and_phase_at_its_cutoff() -> None:
    """At the cutoff: gain 1/sqrt(2), 45 degrees behind."""
    run = simulate(replace(COSINE, sensors=Sensors({"position": Channel(anti_alias=FREQUENCY)})))
    late = run.time >= 1.0 - 2.0 / FREQUENCY
    basis = np.column_stack([np.cos(OMEGA * run.time), np.sin(OMEGA * run.time)])[late]
    cosine, sine = np.linalg.lstsq(basis, measured(run)[late], rcond=None)[0]
    assert np.hypot(cosine, sine) / AMPLITUDE == pytest.approx(1.0 / np.sqrt(2.0), abs=1e-6)
    assert np.degrees(np.arctan2(sine, cosine)) == pytest.approx(45.0, abs=1e-4)


@pytest.mark.parametrize("milliseconds", [0.4, 1.0, 1.5, 2.7, 3.0, 10.25, 40.0])
def test_delayed_reading_is_the_position_of_that_time_ago(milliseconds: float) -> None:
    delay = milliseconds * 1e-3
    run = simulate(replace(COSINE, sensors=Sensors(delay=delay)))
    age = np.maximum(run.time - delay, 0.0)
    assert measured(run) == pytest.approx(AMPLITUDE * np.cos(OMEGA * age), abs=1e-12)
    assert measured(run, "pressure_1") == pytest.approx(-AMPLITUDE * OMEGA * np.sin(OMEGA * age), abs=1e-10)


@pytest.mark.parametrize("integrator", [Integrator("rk4", 1e-4), Integrator(tolerance=1e-12)])
def test_delay_does_not_disturb_the_plant(integrator: Integrator) -> None:
    """A fractional delay makes the integrator land between samples, which costs nothing in accuracy."""
    run = simulate(replace(COSINE, sensors=Sensors(delay=0.3e-3), integrator=integrator))
    assert run.state("position") == pytest.approx(AMPLITUDE * np.cos(OMEGA * run.time), abs=1e-11)


def test_filter_and_delay_together() -> None:
    """The delay holds back what the filter gave."""
    channel = Channel(anti_alias=20.0)
    prompt = simulate(replace(COSINE, sensors=Sensors({"position": channel})))
    late = simulate(replace(COSINE, sensors=Sensors({"position": channel}, delay=5e-3)))
    assert measured(late)[5:] == pytest.approx(measured(prompt)[:-5], abs=1e-15)
    assert np.all(measured(late)[:5] == AMPLITUDE)


def test_sensors_of_a_rig_read_pressures_speed_and_current() -> None:
    """At rest the chambers share the supply pressure (2.94 MPa), the rod turns at 460 rpm and the motor holds it."""
    run = simulate(registered("rotating_helical", rpm=460.0, duration=0.01))
    current = float(run.signals["rotary_friction"][0]) * 0.019 / 0.77
    expected = [0.0, 1.47e6, 1.47e6, 460.0 * 2.0 * np.pi / 60.0, current]
    assert run.measurements[-1, :5] == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert np.all(np.isnan(run.measurements[:, 5]))  # no rig has a gauge of friction


def test_an_imposed_speed_shows_no_motor_and_a_standing_rod_none_that_works() -> None:
    imposed = simulate(registered("rotating_helical_ideal", rpm=460.0, duration=0.01))
    assert np.all(np.isnan(measured(imposed, "motor_current")))
    assert np.all(measured(simulate(registered("non_rotating", duration=0.01)), "motor_current") == 0.0)


def test_a_filter_on_a_sensor_that_is_not_there_harms_nothing() -> None:
    """An imposed speed is not measured: its readings stay NaN and the run completes."""
    sensors = Sensors({"rotation_speed": Channel(anti_alias=194.0)})
    run = simulate(replace(registered("rotating_helical_ideal", rpm=60.0, duration=0.01), sensors=sensors))
    assert run.outcome == "completed"
    assert np.all(np.isnan(measured(run, "rotation_speed")))


# --- in the loop, and systematic errors ---


def moving(channels: dict[str, Channel], **options: Any) -> Run:
    return simulate(replace(hydraulic(), reference=Steps((8e-3, -8e-3), 0.5), sensors=Sensors(channels), **options))


def test_offset_and_gain_of_a_sensor() -> None:
    """The sensor reads (1 + g) y + b; the loop brings what it reads, not the position, to the reference."""
    offset, gain = 0.2e-3, 0.01
    run = moving({"position": Channel(offset=offset, gain_error=gain), "pressure_1": Channel(offset=5e4)})
    assert measured(run) == pytest.approx((1.0 + gain) * run.state("position") + offset, abs=1e-15)
    assert measured(run, "pressure_1") == pytest.approx(run.signals["pressure_1"] + 5e4, rel=1e-14)
    assert np.array_equal(measured(run, "pressure_2"), run.signals["pressure_2"])
    assert run.state("position")[499] == pytest.approx((8e-3 - offset) / (1.0 + gain), abs=2e-6)


def curve(peak: float, travel: float, seed: int, at: np.ndarray) -> np.ndarray:
    channel = Channel(calibration_error=peak, calibration_travel=travel, calibration_seed=seed)
    return systematic_error(at, Sensors({"position": channel}).errors()[0])


@pytest.mark.parametrize("seed", range(5))
def test_calibration_curve_is_smooth_has_its_peak_and_repeats(seed: int) -> None:
    """Peak within 1e-4; a wave of n periods and amplitude a has slopes up to 2 pi n a / travel; no mean."""
    peak, travel = 0.07e-3, 0.2
    at = np.linspace(-0.5, 0.5, 7001) * travel
    errors = curve(peak, travel, seed, at)
    assert np.max(np.abs(errors)) == pytest.approx(peak, rel=1e-4)
    spectrum = np.abs(np.fft.rfft(errors[:-1])) / 3500.0
    assert spectrum[1:5] == pytest.approx(spectrum[1] / np.arange(1, 5), rel=1e-9)
    assert np.max(np.delete(spectrum, [1, 2, 3, 4])) < 1e-9 * peak
    assert np.array_equal(errors, curve(peak, travel, seed, at))
    assert np.max(np.abs(errors - curve(peak, travel, seed + 1, at))) > 0.2 * peak


def test_calibration_error_is_what_the_engine_adds_before_noise_and_converter() -> None:
    """What a noisy, quantised channel shows: rint((y + e(y) + noise) / q) q, noise as without calibration error."""
    seed, step = 11, 2.0**-18
    channel = Channel(
        noise=1e-5, resolution=step, calibration_error=0.07e-3, calibration_travel=0.2, calibration_seed=3
    )
    run = moving({"position": channel}, seed=seed)
    position = run.state("position")
    noise = Sensors({"position": Channel(noise=1e-5)}).noise(position.size, seed)[:, 0]
    analogue = position + curve(0.07e-3, 0.2, 3, position) + noise
    assert np.max(np.abs(measured(run) - analogue)) <= 0.5 * step + 1e-12
    assert np.max(np.abs(measured(run) - position - noise)) > 1e-5


def test_controller_starts_from_what_the_sensor_shows() -> None:
    """An offset alone is no motion: the filtered velocity starts at 0 and a derivative gain has nothing to act on."""
    setup = registered("non_rotating", duration=0.05)
    gains = PID.design(PID.Settings(kp=0.0, kd=50.0), setup.parameters, setup.sample_time)
    sensors = Sensors({"position": Channel(offset=1e-3)})
    run = simulate(replace(setup, loop=Loop(PID, gains), reference=Steps((0.0,), 1.0), sensors=sensors))
    assert np.max(np.abs(run.command)) < 1e-12
