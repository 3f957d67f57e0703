"""The linearised loop and its margins, against python-control, textbook formulas and the nonlinear simulation."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import control
import numpy as np
import pytest
from position_loops import LAG, NO_LOAD_GAIN, H
from support import OSCILLATOR, registered, start

from controllers.compensation import compensator
from controllers.disturbance_observer import DISTURBANCE_OBSERVER
from controllers.dither import DITHER
from controllers.interface import Controller
from controllers.pid import PID
from controllers.registry import controllers
from controllers.settings import settings_of
from plants.equation import from_array
from plants.friction_gauge import gauged
from plants.interface import Plant
from plants.laws.lugre import Bristle
from plants.registry import THESIS
from workbench.errors import UserError
from workbench.linear.linearise import linearise
from workbench.linear.open_loop import linear_controller, margins, open_loop
from workbench.linear.operating_point import slide
from workbench.simulation.references import Ramp, Steps
from workbench.simulation.sensors import Channel, Sensors
from workbench.simulation.simulate import Feed, Integrator, Loop, Setup, simulate

SPEED = 0.03
FREQUENCIES = np.geomspace(0.1, 3000.0, 300)
Z = np.exp(1j * FREQUENCIES * H)


def loop(controller: Controller = PID, plant: str = "non_rotating", rpm: float = 0.0, **settings: Any) -> Setup:
    setup = registered(plant, rpm=rpm, duration=1.0)
    chosen = controller.Settings(**settings)
    if controller.choose is not None:
        controller = controller.choose(chosen, setup.parameters)
    return replace(setup, loop=Loop(controller, controller.design(chosen, setup.parameters, H)))


def response(setup: Setup, speed: float = SPEED) -> np.ndarray:
    return np.asarray(open_loop(setup, speed)(Z))


def by_hand(kp: float) -> control.StateSpace:
    """P on the plant that slides steadily, by balances of force and flow, sampled by python-control."""
    p = registered("non_rotating", duration=1.0).parameters
    h, f = p.hydraulics, p.friction.positive
    level = f.coulomb + f.stribeck * np.exp(-((SPEED / f.stribeck_velocity) ** 2))
    pressure = (level + f.viscous * SPEED) / h.piston_area_1
    root = np.sqrt((h.supply_pressure - pressure) / 2.0)
    spool = h.piston_area_1 * SPEED / (h.valve_flow_gain * root)
    state = THESIS.State(0.0, SPEED, pressure, spool, Bristle(level / f.bristle_stiffness))
    _, inputs = THESIS.equilibrium(p, 0.0)
    inputs = inputs._replace(valve_voltage=spool / h.valve_position_gain)
    return control.sample_system(kp * linearise(THESIS, p, state, inputs)[0, 0], H, "zoh")


def dense_margins(model: control.StateSpace) -> tuple[float, float]:
    """Gain margin (dB) and phase margin (degrees) off a grid that is as fine as one of 40 000 frequencies where L
    crosses: to 0.01 of either.
    """

    def crossings(frequencies: np.ndarray, side: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        return np.flatnonzero(np.diff(np.sign(side(model(np.exp(1j * frequencies * H))))) != 0.0)

    def values(side: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        coarse = np.geomspace(1.0, np.pi / H, 2_000)
        fine = [np.geomspace(coarse[i], coarse[i + 1], 21) for i in crossings(coarse, side)]
        return np.concatenate([model(np.exp(1j * part[crossings(part, side)] * H)) for part in fine])

    real, unity = values(np.imag), values(lambda response: np.abs(response) - 1.0)
    gains = np.abs(20.0 * np.log10(np.abs(real[real.real < 0.0])))
    return float(np.min(gains)), float(np.min(np.abs(np.angle(-unity, deg=True))))


@pytest.mark.parametrize("kp", [200.0, 500.0, 5000.0])
def test_p_loop_is_that_of_python_control(kp: float) -> None:
    expected = by_hand(kp)
    setup = loop(kp=kp)
    np.testing.assert_allclose(response(setup), expected(Z), rtol=1e-5)
    found = margins(setup, SPEED)
    gain, phase = dense_margins(expected)
    assert found.stable
    assert found.gain_dB == pytest.approx(gain, abs=0.01)
    assert found.phase_deg == pytest.approx(phase, abs=0.01)


@pytest.mark.parametrize("kp", [200.0, 500.0, 1000.0])
def test_phase_margin_is_that_of_integrator_and_valve(kp: float) -> None:
    """K / (s (tau s + 1)) with half a sample of hold: up to 51 rad/s the crossover to 0.2 %, the phase to 0.8 degrees.

    K is the no-load gain, less what the load pressure F/A takes of the root, more what friction gives that falls with
    speed: dv/dx_s of A v = K x_s sqrt((P_s - F(v)/A)/2). What remains, 0.26 ms of lag, is the mass on that friction.
    """
    found = margins(loop(kp=kp), SPEED)
    p = loop(kp=kp).parameters
    f = p.friction.positive
    bump = f.stribeck * np.exp(-((SPEED / f.stribeck_velocity) ** 2))
    pressure = (f.coulomb + bump + f.viscous * SPEED) / p.hydraulics.piston_area_1
    slope = (f.viscous - 2.0 * bump * SPEED / f.stribeck_velocity**2) / p.hydraulics.piston_area_1
    drop = p.hydraulics.supply_pressure - pressure
    gain = kp * NO_LOAD_GAIN * np.sqrt(drop / p.hydraulics.supply_pressure) / (1.0 + 0.5 * SPEED * slope / drop)
    crossover = np.sqrt((np.sqrt(1.0 + 4.0 * (gain * LAG) ** 2) - 1.0) / (2.0 * LAG**2))
    phase = 90.0 - np.degrees(np.arctan(crossover * LAG) + crossover * H / 2.0)
    assert found.phase_frequency == pytest.approx(crossover, rel=2e-3)
    assert found.phase_deg == pytest.approx(phase, abs=0.8)


DELAYED = Sensors({"position": Channel(anti_alias=100.0)}, delay=2.3e-3)
LOOPS = {
    "p": lambda: loop(kp=500.0),
    "pid": lambda: loop(kp=500.0, ki=2000.0, kd=2.0),
    "pid_of_a_rotating_rod": lambda: loop(plant="rotating_helical", rpm=460.0, kp=500.0, kd=2.0),
    "p_with_delay_and_filter": lambda: replace(loop(kp=500.0), sensors=DELAYED),
    "lugre_inversion": lambda: loop(compensator("lugre"), law="valve_inversion"),
    "lugre_adaptive": lambda: loop(compensator("lugre_adaptive")),
    "friedland_park": lambda: loop(compensator("friedland_park")),
    "ekf": lambda: loop(controllers()["ekf"]),
    "disturbance_observer": lambda: loop(DISTURBANCE_OBSERVER),
}


@pytest.mark.parametrize("name", LOOPS)
def test_the_simulated_loop_loses_its_stability_at_the_gain_margin(name: str) -> None:
    """Small signals about the nonlinear slide decay 2 % below the gain that the margin says, and grow 2 % above."""
    setup = LOOPS[name]()
    found = margins(setup, SPEED)
    limit = 10.0 ** (found.gain_dB / 20.0)
    assert found.stable
    assert growth(setup, 0.98 * limit) < -0.3
    assert growth(setup, 1.02 * limit) > 0.3


def growth(setup: Setup, gain: float) -> float:
    """Rate (1/s) at which a push of 0.01 mm/s grows, in the nonlinear simulation that starts in the slide itself.

    The valve passes `gain` times what the command deviates: a constant voltage takes the rest, so that the slide is
    that of the loop as it is.
    """
    point, plant = slide(setup, SPEED), setup.plant
    hydraulics, voltage = setup.parameters.hydraulics, point.inputs.valve_voltage
    stronger = hydraulics._replace(valve_position_gain=gain * hydraulics.valve_position_gain)
    memory = from_array(setup.loop.controller.State, point.memory.tolist())
    warm = replace(setup.loop.controller, start=lambda measurement, gains: memory)
    rest = Steps((voltage / gain - voltage,), 10.0)
    pushed = replace(
        setup,
        parameters=setup.parameters._replace(hydraulics=stronger),
        state=point.state._replace(velocity=point.state.velocity + 1e-5),
        inputs=point.inputs._replace(valve_voltage=0.0),
        loop=Loop(warm, setup.loop.gains),
        rotary=None,
        reference=Ramp(SPEED, offset=point.reference[0]),
        feeds=(Feed(plant.command, rest, linear=False),),
        integrator=Integrator(tolerance=1e-11),
        duration=0.7,
    )
    changes = np.diff(simulate(pushed).state("velocity"))
    early, late = np.ptp(changes[200:350]), np.ptp(changes[550:])
    return float(np.log(late / early) / 0.35)


def test_the_controller_is_its_transfer_function() -> None:
    """C(z) = K_p + K_i h / (z - 1) + K_d (1 - E)/h (z - 1)/(z - E), E = exp(-h / T_v)."""
    setup = loop(kp=500.0, ki=2000.0, kd=2.0)
    point = slide(setup, SPEED)
    linear = linear_controller(setup.loop, point, H)
    position = point.reach[1][0]
    keep = np.exp(-H / 2e-3)
    expected = 500.0 + 2000.0 * H / (Z - 1.0) + 2.0 * (1.0 - keep) / H * (Z - 1.0) / (Z - keep)
    found = control.ss(linear.a, linear.b[:, [0]], linear.c, linear.d[:, [0]], H)(Z)
    np.testing.assert_allclose(-found / position, expected, rtol=1e-6)


def test_an_integral_turns_the_phase_back() -> None:
    """L_PI = L_P (1 + K_i h / (K_p (z - 1))): of 30 degrees at the corner, about atan(K_i / (K_p w)) elsewhere."""
    factor = 1.0 + 4000.0 / 500.0 * H / (Z - 1.0)
    p, pi = (loop(kp=500.0, ki=ki) for ki in (0.0, 4000.0))
    np.testing.assert_allclose(response(pi), response(p) * factor, rtol=3e-4)  # the slides differ by 0.01 % in speed
    before, after = margins(p, SPEED), margins(pi, SPEED)
    lost = np.degrees(np.arctan(8.0 / after.phase_frequency))
    assert before.phase_deg - after.phase_deg == pytest.approx(lost, abs=1.5)


def test_delays_and_filters_of_sensors_turn_the_phase() -> None:
    """A whole delay is z^-n exactly; part of a sample, and a first-order filter, as in continuous time."""
    plain = response(loop(kp=500.0))
    slow = FREQUENCIES < 100.0
    delayed = response(replace(loop(kp=500.0), sensors=Sensors(delay=2e-3)))
    np.testing.assert_allclose(delayed, plain * Z**-2.0, rtol=1e-6)
    part = response(replace(loop(kp=500.0), sensors=Sensors(delay=1.4e-3)))
    np.testing.assert_allclose((part / plain)[slow], np.exp(-1.4e-3j * FREQUENCIES[slow]), rtol=2e-3)
    filtered = response(replace(loop(kp=500.0), sensors=Sensors({"position": Channel(anti_alias=50.0)})))
    low_pass = 1.0 / (1.0 + 1j * FREQUENCIES[slow] / (2.0 * np.pi * 50.0))
    np.testing.assert_allclose((filtered / plain)[slow], low_pass, rtol=2e-3)


@pytest.mark.filterwarnings("ignore")  # its polynomials are ill-conditioned, and it says so
@pytest.mark.parametrize("name", LOOPS)
def test_margins_of_real_loops_are_those_of_python_control(name: str) -> None:
    """Off the loop's response: its polynomials are ill-conditioned, and cross at DC wherever rounding puts them."""
    setup = LOOPS[name]()
    found, frequencies = margins(setup, SPEED), np.geomspace(0.1, 0.999 * np.pi / H, 4_000)
    whole = open_loop(setup, SPEED)(np.exp(1j * frequencies * H))
    gm, pm, at_phase, at_gain = control.margin(control.frd(whole, frequencies, smooth=True))
    assert found.gain_dB == pytest.approx(20.0 * np.log10(gm), abs=1e-5)
    assert found.phase_deg == pytest.approx(pm, abs=1e-5)
    assert (found.gain_frequency, found.phase_frequency) == pytest.approx((at_phase, at_gain), rel=1e-6)


def test_a_dithered_loop_is_taken_at_its_mean() -> None:
    """A dither that is as good as none leaves the PID's loop; one of 2.5 V shakes its rod, yet counts as steady."""
    quiet, shaken = (margins(loop(DITHER, amplitude=volts), SPEED) for volts in (1e-6, 2.5))
    expected = margins(loop(kp=500.0), SPEED)
    assert quiet.phase_deg == pytest.approx(expected.phase_deg, abs=1e-3)
    assert quiet.gain_dB == pytest.approx(expected.gain_dB, abs=1e-3)
    assert shaken.stable
    assert shaken.phase_deg == pytest.approx(expected.phase_deg, abs=1.0)


def test_loops_that_do_not_slide_have_no_margins() -> None:
    """Twice the gain at the margin oscillates; a bias moves nothing; a load takes more voltage than there is."""
    beyond = 2.0 * 500.0 * 10.0 ** (margins(loop(kp=500.0), SPEED).gain_dB / 20.0)
    for setup, speed, words in (
        (loop(kp=beyond), SPEED, "keeps oscillating"),
        (loop(controllers()["open_loop"]), SPEED, "the rod moves at 0 m/s in place of 0.03 m/s"),
        (loop(kp=500.0), 0.7, "the command is at the amplifier's limit"),
    ):
        found = margins(setup, speed)
        assert not found.stable
        assert words in found.note
        assert (found.gain_dB, found.phase_deg) == (-np.inf, -np.inf)
        with pytest.raises(UserError, match="has no open loop at"):
            open_loop(setup, speed)
    with pytest.raises(UserError, match="speed is 0 m/s, expected one that slides"):
        margins(loop(kp=500.0), 0.0)


def test_a_loop_that_slides_unstably_is_told_by_its_poles() -> None:
    """K / (s (s + c)) of a mass of 1 kg, read 0.15 s late: 90 - atan(w_c/c) - w_c (0.15 s + h/2) degrees.

    The slide is simulated with ideal sensors, so that it is steady, and the delay is in the loop alone.
    """
    setup = start(OSCILLATOR, damping=20.0, duration=1.0, loop=Loop(PID, PID.design(PID.Settings(kp=200.0), None, H)))
    late = margins(replace(setup, sensors=Sensors(delay=0.15)), 0.5)
    crossover = np.sqrt(0.5 * (np.sqrt(20.0**4 + 4.0 * 200.0**2) - 20.0**2))
    expected = 90.0 - np.degrees(np.arctan(crossover / 20.0) + crossover * (0.15 + H / 2.0))
    assert margins(setup, 0.5).stable
    assert not late.stable
    assert late.phase_deg == pytest.approx(expected, abs=0.01)
    assert late.gain_dB < 0.0
    assert late.note == "the linearised loop is unstable"


@pytest.mark.parametrize("controller", controllers().values(), ids=lambda item: item.name)
def test_every_controller_has_margins_on_every_plant_that_it_serves(
    controller: Controller, plant: Plant, parameters: Any
) -> None:
    state, inputs = plant.equilibrium(parameters, 0.9 if plant.rotary_command else 0.0)
    given = {
        name: 500.0 if name == "kp" else 1.0
        for name, item in settings_of(controller.Settings).items()
        if item.default is None
    }
    settings = controller.Settings(**given)
    try:
        chosen = controller if controller.choose is None else controller.choose(settings, parameters)
        gains = chosen.design(settings, parameters, H)
        plant = gauged(plant) if chosen.gauge else plant
    except (ValueError, AttributeError):
        return  # it says itself that it does not serve this plant, or needs a friction that the plant has not
    found = margins(Setup(plant, parameters, state, inputs, 1.0, Loop(chosen, gains)), SPEED)
    assert not np.any(np.isnan([found.gain_dB, found.phase_deg, found.gain_frequency, found.phase_frequency]))
    assert found.stable == (found.note == "")
    assert found.stable == (found.gain_dB > 0.0) == (found.phase_deg > 0.0)
    if hasattr(parameters, "hydraulics") and controller.name not in ("open_loop", "relay"):
        assert found.stable
        assert found.phase_deg > 40.0
        assert found.gain_dB > 20.0
