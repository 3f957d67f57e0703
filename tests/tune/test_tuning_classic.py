"""Relay, relay experiment, Ziegler-Nichols, slow model, pole placement, LQR: against numbers from elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from position_loops import NO_LOAD_GAIN, H, play
from support import OSCILLATOR, registered, start
from thesis_actuator import OF_OTHERS

from controllers import relay
from controllers.pid import PID
from controllers.relay import RELAY
from plants.effects.registry import effects
from plants.registry import plants
from workbench.errors import UserError
from workbench.linear.open_loop import margins
from workbench.linear.slow_model import SlowModel, slow_model
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.sensors import Channel, Sensors
from workbench.simulation.simulate import Loop, Setup
from workbench.tune.classic import lqr, pole_placement, starting_points, ziegler_nichols
from workbench.tune.relay_experiment import relay_test

SPEED = 0.03
VALVE = SlowModel(0.0, 1.0 / 12e-3, NO_LOAD_GAIN / 12e-3)
"""K_q / (s (tau s + 1)) of the simulation set."""


def under(setup: Setup, **gains: float) -> Setup:
    return replace(setup, loop=Loop(PID, PID.design(PID.Settings(**gains), setup.parameters, setup.sample_time)))


def test_relay_by_hand() -> None:
    """2 V to the side of the error, which within 0.1 mm stays what it was; forward at first."""
    errors = [0.0, 0.05, -0.05, 0.2, 0.0, -0.1, -0.11, 0.05, 0.11]
    commands, _ = play(RELAY, relay.Settings(2.0, 1e-4), [(error, 0.0) for error in errors])
    assert commands == [2.0, 2.0, 2.0, 2.0, 2.0, 2.0, -2.0, -2.0, 2.0]
    plain, state = play(RELAY, relay.Settings(2.0), [(1.0, 0.0), (-1.0, 0.0), (0.0, 0.0)], limit=1.0)
    assert plain == [2.0, -2.0, -2.0]
    assert state.side == -1.0


@pytest.mark.parametrize(("amplitude", "hysteresis"), [(0.0, 0.0), (1.0, -1e-6)])
def test_relay_refuses_what_it_cannot_have(amplitude: float, hysteresis: float) -> None:
    with pytest.raises(ValueError, match="expected"):
        RELAY.design(relay.Settings(amplitude, hysteresis), None, H)
    with pytest.raises(UserError, match="relay: "):
        relay_test(registered("non_rotating", duration=1.0), amplitude, SPEED, hysteresis)


def integrator(delay: float) -> Setup:
    """dx/dt = u read `delay` (s) later; of a mass of 1 kg that sheds its velocity in 0.1 ms, every 0.1 ms."""
    return start(OSCILLATOR, damping=1e4, duration=1.0, sensors=Sensors(delay=delay), sample_time=1e-4)


@pytest.mark.parametrize("speed", [0.0, 0.2])
def test_relay_on_an_integrator_with_a_delay(speed: float) -> None:
    """A triangle of period 4 T and height d T, from which 4 d / (pi a) is 8/pi^2 of the true pi / (2 T), exactly.

    T is the delay, the mass's 0.1 ms, and the half sample that the relay is late.
    """
    delay = 20e-3 + 1e-4 + 0.5e-4
    result = relay_test(integrator(20e-3), 1e4, speed)
    assert result.note == ""
    assert result.ultimate_period == pytest.approx(4.0 * delay, rel=0.01)
    assert result.amplitude == pytest.approx(delay, rel=0.01)
    assert result.bias == pytest.approx(1e4 * speed, abs=500.0)
    assert result.ultimate_gain == pytest.approx(8.0 / np.pi**2 * 1e4 * np.pi / (2.0 * delay), rel=0.01)


def test_hysteresis_of_the_relay_is_accounted_for() -> None:
    """With eps the triangle is d T + eps high; the gain by sqrt(a^2 - eps^2) stays within the describing function's."""
    result = relay_test(integrator(20e-3), 1e4, 0.0, hysteresis=4e-3)
    assert result.amplitude == pytest.approx(20.15e-3 + 4e-3, rel=0.01)
    assert result.ultimate_gain == pytest.approx(4e4 / np.pi / np.sqrt(24.15e-3**2 - 4e-3**2), rel=0.01)


@pytest.mark.parametrize("plant", ["non_rotating", "rotating_helical"])
def test_relay_finds_the_sliding_loops_ultimate_gain(plant: str) -> None:
    """Within 20 % of the margins' gain, from below: describing function, and a switch up to a sample of 20 late."""
    setup = registered(plant, rpm=460.0 if "rotating" in plant else 0.0, duration=1.0)
    relay = margins(under(setup, kp=500.0), SPEED)
    ultimate = 500.0 * 10.0 ** (relay.gain_dB / 20.0)
    for amplitude, speed in ((0.3, SPEED), (1.0, SPEED), (1.0, -SPEED)):
        result = relay_test(setup, amplitude, speed)
        assert result.note == ""
        assert 0.8 * ultimate < result.ultimate_gain < ultimate
        assert result.ultimate_period == pytest.approx(2.0 * np.pi / relay.gain_frequency + H, rel=0.1)
        assert result.amplitude * 2.0 * np.pi / result.ultimate_period < SPEED  # never back: friction keeps its side
        assert result.bias == pytest.approx(0.49 * np.sign(speed), abs=0.06)


def test_relay_says_why_nothing_came() -> None:
    setup = registered("non_rotating", duration=1.0)
    weak = relay_test(setup, 0.02, SPEED)
    assert weak.note == "no oscillation: the relay stays on one side with 0.02 V; take a larger amplitude"
    assert np.isnan([weak.ultimate_gain, weak.ultimate_period, weak.amplitude]).all()
    assert relay_test(setup, 1.0, SPEED, hysteresis=0.05).note.startswith("no oscillation: ")
    noisy = replace(setup, sensors=Sensors({"position": Channel(noise=1e-3)}))
    assert relay_test(noisy, 1.0, SPEED).note.startswith("no regular oscillation with 1 V")


def test_ziegler_nichols_table() -> None:
    """K_u 10, T_u 2 s, by the rows of the table."""
    result = ziegler_nichols(10.0, 2.0)
    assert result["p"] == {"kp": 5.0, "ki": 0.0, "kd": 0.0}
    assert result["pi"] == pytest.approx({"kp": 4.5, "ki": 4.5 / (2.0 / 1.2), "kd": 0.0})
    assert result["pd"] == pytest.approx({"kp": 8.0, "ki": 0.0, "kd": 8.0 * 0.25})
    assert result["pid"] == pytest.approx({"kp": 6.0, "ki": 6.0, "kd": 6.0 * 0.25})
    with pytest.raises(UserError, match="ultimate period is nan, expected a value above 0"):
        ziegler_nichols(10.0, np.nan)


def test_slow_model_of_a_mass_is_the_mass() -> None:
    """(s^2 + c s + k) / 1 of a linear plant comes back: 1 kg, 3 N s/m; k = 0, since a slide on a spring is none."""
    result = slow_model(start(OSCILLATOR, damping=3.0, loop=under(start(OSCILLATOR), kp=100.0, kd=20.0).loop), 0.5)
    assert (result.a0, result.a1, result.b) == pytest.approx((0.0, 3.0, 1.0), abs=1e-9)


def test_slow_model_of_the_valve_is_integrator_and_lag() -> None:
    """Its velocity gain b/a1 is K_q corrected for load pressure and friction's slope, as in the phase margin's test."""
    setup = registered("non_rotating", duration=1.0)
    result = slow_model(setup, SPEED)
    f, h = setup.parameters.friction.positive, setup.parameters.hydraulics
    bump = f.stribeck * np.exp(-((SPEED / f.stribeck_velocity) ** 2))
    pressure = (f.coulomb + bump + f.viscous * SPEED) / h.piston_area_1
    slope = (f.viscous - 2.0 * bump * SPEED / f.stribeck_velocity**2) / h.piston_area_1
    drop = h.supply_pressure - pressure
    gain = NO_LOAD_GAIN * np.sqrt(drop / h.supply_pressure) / (1.0 + 0.5 * SPEED * slope / drop)
    assert result.a0 == pytest.approx(0.0, abs=1e-9)
    assert result.b / result.a1 == pytest.approx(gain, rel=1e-6)
    assert 1.0 / result.a1 == pytest.approx(12e-3, rel=0.025)  # the valve's, and what mass and friction add


def test_slow_model_of_a_drive_has_frictions_slope() -> None:
    """a1 / b is dF/dv of the steady curve over the force gain: falling at 30 mm/s, viscous at 150 mm/s."""
    setup = registered_drive()
    f = setup.parameters.friction.positive
    for speed in (0.03, 0.15):
        bump = f.stribeck * np.exp(-((speed / f.stribeck_velocity) ** 2))
        slope = f.viscous - 2.0 * bump * speed / f.stribeck_velocity**2
        result = slow_model(setup, speed)
        assert result.a1 / result.b == pytest.approx(slope / OF_OTHERS["force_gain"], rel=1e-6)
    assert result.b == pytest.approx(OF_OTHERS["force_gain"] / 34.0, rel=1e-3)


def registered_drive() -> Setup:
    plant = plants()["drive_voltage"]
    numbers = read_parameters(named_sets()["owen2001_simulation"]) | OF_OTHERS
    parameters = build(plant.Parameters, numbers)
    state, inputs = plant.equilibrium(parameters, 0.0)
    return Setup(plant, parameters, state, inputs, 1.0)


@pytest.mark.parametrize("damping", [0.5, 0.8, 1.0, 1.5])
def test_poles_are_where_they_are_asked_for(damping: float) -> None:
    w, p = 150.0, 40.0
    pd = pole_placement(VALVE, w, damping)
    assert pd["ki"] == 0.0
    assert [VALVE.a1 + VALVE.b * pd["kd"], VALVE.b * pd["kp"]] == pytest.approx([2.0 * damping * w, w * w], rel=1e-6)
    pid = pole_placement(VALVE, w, damping, integral_pole=p)
    result = [1.0, VALVE.a1 + VALVE.b * pid["kd"], VALVE.b * pid["kp"], VALVE.b * pid["ki"]]
    wanted = np.polymul([1.0, 2.0 * damping * w, w * w], [1.0, p])
    np.testing.assert_allclose(result, wanted, rtol=1e-6)


def test_poles_slower_than_the_plants_own_are_refused() -> None:
    """2 zeta w = 14 below the valve's 83 1/s: the derivative would have to be negative."""
    with pytest.raises(UserError, match="a PID has no negative gain"):
        pole_placement(VALVE, 10.0)
    with pytest.raises(UserError, match="expected values above 0"):
        pole_placement(VALVE, 0.0)


def test_lqr_of_a_double_integrator() -> None:
    """x'' = b u: K_p = u_m / e_m, K_d = sqrt(2 K_p / b), the solution of its algebraic Riccati equation by hand."""
    b, error, command = 3.0, 2e-3, 10.0
    result = lqr(SlowModel(0.0, 0.0, b), error, command)
    assert result["kp"] == pytest.approx(command / error, rel=1e-8)
    assert result["kd"] == pytest.approx(np.sqrt(2.0 * command / error / b), rel=1e-8)
    assert result["ki"] == 0.0


def test_lqr_with_integral_solves_the_spectral_factorisation() -> None:
    """p(s) p(-s) = d(s) d(-s) + (b u_m/e_m)^2 (-s^2 + 1/T^2), d = s^2 (s + a1), and K_i = u_m / (e_m T)."""
    error, command, time = 2e-3, 10.0, 0.1
    result = lqr(VALVE, error, command, time)
    closed = np.array([1.0, VALVE.a1 + VALVE.b * result["kd"], VALVE.b * result["kp"], VALVE.b * result["ki"]])
    signs = np.array([-1.0, 1.0, -1.0, 1.0])
    opened = np.array([1.0, VALVE.a1, 0.0, 0.0])
    weight = (VALVE.b * command / error) ** 2
    wanted = np.polyadd(np.polymul(opened, signs * opened), weight * np.array([-1.0, 0.0, 1.0 / time**2]))
    np.testing.assert_allclose(np.polymul(closed, signs * closed), wanted, rtol=1e-7, atol=1e-7 * weight)
    assert result["ki"] == pytest.approx(command / (error * time), rel=1e-8)
    with pytest.raises(UserError, match="expected finite values above 0"):
        lqr(VALVE, error, np.inf)


@pytest.mark.parametrize("plant", ["non_rotating", "rotating_helical"])
def test_starting_points_are_stable_or_say_that_they_are_not(plant: str) -> None:
    setup = registered(plant, rpm=460.0 if "rotating" in plant else 0.0, duration=1.0)
    points = {point.name: point for point in starting_points(setup, setup.parameters, SPEED)}
    by_relay = [f"ziegler_nichols_{kind}" for kind in ("p", "pi", "pd", "pid")]
    by_model = ["pole_placement_pd", "pole_placement_pid", "lqr_pd", "lqr_pid"]
    assert list(points) == by_relay + by_model
    for point in points.values():
        assert point.controller == "pid"
        result = margins(under(setup, **point.settings), SPEED)
        assert result == point.margins
        assert result.stable != ("not stable at 0.03 m/s on the believed plant" in point.note)
    for name in by_model:
        result = points[name].margins
        assert result is not None
        assert result.gain_dB >= 6.0
        assert 45.0 <= result.phase_deg < 55.0
    assert points["ziegler_nichols_p"].margins.gain_dB == pytest.approx(6.0, abs=2.0)
    assert not points["ziegler_nichols_pi"].margins.stable  # PI of this rule on a plant that integrates


def test_starting_points_without_an_answer_say_so() -> None:
    """On friction that falls with speed a drive does not slide under any; it does where friction is viscous."""
    setup = registered_drive()
    falling = starting_points(setup, setup.parameters, SPEED)
    assert all("not stable" in point.note or "no closed loop" in point.note for point in falling)
    rising = {point.name: point for point in starting_points(setup, setup.parameters, 0.15)}
    assert rising["pole_placement_pd"].margins.stable
    unlimited = registered("drive_force", duration=1.0)
    with pytest.raises(UserError, match="give largest_command"):
        starting_points(unlimited, unlimited.parameters, SPEED)


def test_a_belief_has_none_of_the_effects_of_the_true_plant() -> None:
    """Pole placement and LQR see what is believed alone; the relay experiment swings the true plant."""
    plain = registered("non_rotating", duration=1.0)
    curved = plain.plant.with_effects(effects("m")["position_dependent_friction"])
    parameters = build(curved.Parameters, read_parameters(named_sets()["owen2001_simulation"]))
    true = replace(plain, plant=curved, parameters=parameters)
    true = replace(true, state=curved.equilibrium(parameters, 0.0)[0], inputs=curved.equilibrium(parameters, 0.0)[1])
    points = [starting_points(setup, plain.parameters, SPEED) for setup in (plain, true)]
    placed = [[point for point in each if not point.name.startswith("ziegler")] for each in points]
    assert placed[0] == placed[1]
    assert len(placed[0]) == 4
