"""Compensators on a rod that turns: their friction is that of the believed law at the helical speed."""

import math
from dataclasses import replace
from typing import Any

import casadi
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import registered

from controllers import compensation as comp
from controllers import ekf_compensation as ekf
from controllers.believed_friction import believed_turning, filtered_rotation, measured_rotation
from controllers.extended_kalman import EkfSettings, believed_rates, design_ekf
from controllers.friction_observer import Belief, Memory, Seen
from controllers.friedland_park import friedland_park
from controllers.interface import Controller, Reference
from controllers.lugre_observer import decay_share, lugre_observer
from controllers.speed_servo import SPEED_SERVO
from controllers.speed_servo import Settings as ServoSettings
from controllers.static_map import static_map
from controllers.tafazoli import tafazoli
from plants import bristles
from plants.equation import to_array
from plants.friction import directed, modified_tustin, stribeck_level
from plants.interface import Measurement
from workbench.simulation.references import Sine
from workbench.simulation.simulate import Loop, Run, simulate

H = 1e-3
MACHINES = [("owen2001_simulation", "isotropic"), ("owen2001_experiment", "anisotropic")]
STILL = registered("non_rotating", "owen2001_experiment", duration=1.0).parameters
ESTIMATES = ["static_map", "tafazoli", "friedland_park", "lugre", "lugre_adaptive", "ekf"]


def plant(values: str, bristle: str, **changes: Any) -> Any:
    return registered(f"rotating_{bristle}", values, duration=1.0).parameters._replace(**changes)


def belief(values: str, bristle: str, **changed: Any) -> Belief:
    return comp.design(comp.Settings(**changed), plant(values, bristle), H).belief


def fresh(**changed: float) -> Memory:
    return Memory(0.0, 0.0, 1.0, 0.0, 0.0)._replace(**changed)


# --- at rest around the rod -----------------------------------------------------------------------------------

speeds = st.one_of(st.floats(-0.2, -1e-5), st.floats(1e-5, 0.2))


@pytest.mark.parametrize(("values", "bristle"), MACHINES)
@settings(deadline=None, max_examples=60)
@given(v=speeds, bend=st.floats(-1e-4, 1e-4), force=st.floats(-2e3, 2e3), before=speeds)
def test_without_rotation_the_laws_are_those_of_a_rod_that_slides(
    values: str, bristle: str, v: float, bend: float, force: float, before: float
) -> None:
    """Thesis (4.7), 2.7 to 2.9, 2.11 and 2.2.1.2, written out for |v| in place of the helical speed."""
    b = belief(values, bristle)
    p = directed(v, v, b.friction)
    level = float(stribeck_level(v, p))
    seen = Seen(v, before, force, 0.01, 0.0)
    sign = min(max(v / 1e-3, -1.0), 1.0)
    assert static_map(seen, fresh(), b, H)[0] == pytest.approx(level * sign + p.viscous * v, rel=1e-12)

    static = b.friction.positive.coulomb + b.friction.positive.stribeck
    held, moving = min(max(force, -static), static), modified_tustin(v, b.map)
    blend = math.exp(-((v / 3e-3) ** 2))
    assert tafazoli(seen, fresh(), b, H)[0] == pytest.approx(moving + (held - moving) * blend, rel=1e-10, abs=1e-9)

    q = directed(v, bend, b.friction)
    exponent = q.bristle_stiffness * abs(v) / level * H
    following = bend * math.exp(-exponent) + (v + 0.1 * 0.01) * H * float(decay_share(exponent))
    damping = q.bristle_damping * math.exp(-((v / q.stribeck_velocity) ** 2))
    expected = q.bristle_stiffness * following + damping * (following - bend) / H + q.viscous * v
    found, memory = lugre_observer(seen, fresh(bristle=bend), b, H)
    assert (found, memory.bristle) == pytest.approx((expected, following), rel=1e-10, abs=1e-9)

    middle, old = 0.5 * (v + before), 300.0
    wanted = math.copysign(1.0, middle) * (force - b.mass * (v - before) / H)
    new = min(max(old + (1.0 - math.exp(-1700.0 / b.mass * H)) * (wanted - old), 0.0), 2000.0)
    new = new if abs(middle) > 1e-4 else old
    found, memory = friedland_park(seen, fresh(level=old), b, H)
    assert found == pytest.approx(new * min(max(v / 1e-4, -1.0), 1.0), rel=1e-9)


@pytest.mark.parametrize("name", ESTIMATES)
@pytest.mark.parametrize("reading", [math.nan, 0.0])
def test_a_rotation_that_is_not_measured_counts_as_none(name: str, reading: float) -> None:
    """As with a plant that does not turn, to the last bit; and so does any reading where it is ignored."""
    turning = plant("owen2001_experiment", "isotropic")
    expected = commands(name, STILL, 0.0)
    assert commands(name, turning, reading) == expected
    assert commands(name, turning, 30.0, rotation="ignored") == expected
    assert commands(name, turning, 30.0) != expected


def commands(name: str, believed: Any, reading: float, **changed: Any) -> list[float]:
    """Commands over 60 samples of a made-up motion, the rod measured to turn at `reading` (rad/s)."""
    controller, gains = made(name, believed, **changed)
    state, given = controller.start(Measurement(0.0, 2.4e6, 2.4e6, reading), gains), []
    for k in range(60):
        x, load = 1e-3 * math.sin(0.1 * k), 1e5 * math.cos(0.1 * k)
        measured = Measurement(x, 2.4e6 + load, 2.4e6 - load, reading)
        command, state = controller.step(Reference(x + 1e-5, 0.1 * math.cos(0.1 * k), 0.0), measured, state, gains, H)
        state = controller.commit(command, state, gains, H)
        given.append(float(command))
    return given


def made(name: str, believed: Any, **changed: Any) -> tuple[Controller, Any]:
    """A compensator by valve inversion, and its gains."""
    if name == "ekf":
        return ekf.ekf_compensator(), ekf.design(ekf.Settings(**changed), believed, H)
    return comp.compensator(name), comp.design(comp.Settings(**changed), believed, H)


def test_the_measured_rotation_is_low_pass_filtered() -> None:
    """A step of 10 rad/s is at 1 - 1/e after the time constant, and a missing reading is a standing rod."""
    gains = comp.design(comp.Settings(rotation_time_constant=20e-3), plant(*MACHINES[0]), H)
    speed = 0.0
    for _ in range(20):
        speed = float(filtered_rotation(10.0, speed, gains.rotation_gain))
    assert speed == pytest.approx(10.0 * (1.0 - math.exp(-1.0)), rel=1e-12)
    assert float(measured_rotation(math.nan)) == 0.0
    with pytest.raises(ValueError, match="rotation_time_constant is 0, expected a value above 0"):
        comp.design(comp.Settings(rotation_time_constant=0.0), plant(*MACHINES[0]), H)


# --- turning --------------------------------------------------------------------------------------------------

LAWS = {"isotropic": bristles.ISOTROPIC, "anisotropic": bristles.ANISOTROPIC}


@pytest.mark.parametrize(("values", "bristle"), MACHINES)
@pytest.mark.parametrize("v", [0.06, 0.003, -0.02])
@pytest.mark.parametrize("w", [0.05, 0.25])
def test_steady_estimates_are_the_believed_law_s(values: str, bristle: str, v: float, w: float) -> None:
    """Static map and LuGre after a long time against the plant's steady friction along a rod that turns."""
    p, b = plant(values, bristle), belief(values, bristle, injection=0.0)
    expected, _ = LAWS[bristle].steady(v, w, p)
    seen = Seen(v, v, 0.0, 0.0, w)
    assert static_map(seen, fresh(), b, H)[0] == pytest.approx(float(expected), rel=1e-9)
    memory, force = fresh(), 0.0
    for _ in range(2000):
        force, memory = lugre_observer(seen, memory, b, H)
    assert force == pytest.approx(float(expected), rel=1e-9)


def test_a_film_and_a_guide_are_believed_too() -> None:
    p = plant("owen2001_experiment", "anisotropic")
    p = p._replace(film=p.film._replace(film_share=0.5), guide=p.guide._replace(guide_coulomb=32.0))
    b = comp.design(comp.Settings(), p, H).belief
    for v, w in ((0.02, 0.1), (-0.005, 0.2)):
        expected, _ = bristles.ANISOTROPIC.steady(v, w, p)
        assert static_map(Seen(v, v, 0.0, 0.0, w), fresh(), b, H)[0] == pytest.approx(float(expected), rel=1e-9)


@pytest.mark.parametrize("w", [0.05, 0.15])
def test_tafazolis_map_is_taken_at_the_helical_speed(w: float) -> None:
    """T(v_h) v / v_h where friction is the same along and around; without a blend at rest, where nothing sticks."""
    b = belief("owen2001_simulation", "isotropic")
    for v in (0.06, 0.001, -0.03):
        speed = math.hypot(v, w)
        found, _ = tafazoli(Seen(v, v, 1e3, 0.0, w), fresh(), b, H)
        assert found == pytest.approx(float(modified_tustin(speed, b.map)) * v / speed, rel=1e-9)


@pytest.mark.parametrize("w", [0.05, 0.2])
def test_friedland_parks_level_is_that_along_the_helix(w: float) -> None:
    """With F = a v / v_h its error decays at k mu / M = 50 1/s whatever the rotation, and slower below 2 mm/s."""
    b, true = belief("owen2001_simulation", "isotropic"), 500.0
    for v, share in ((0.05, 1.0), (-0.05, 1.0), (0.01, 1.0), (0.0005, (0.0005 / 0.002) ** 2)):
        cosine, memory, errors = v / math.hypot(v, w), fresh(previous_velocity=v), []
        for _ in range(30):
            force, memory = friedland_park(Seen(v, v, true * cosine, 0.0, w), memory, b, H)
            errors.append(true - memory.level)
        rate = -np.polyfit(H * np.arange(30), np.log(errors), 1)[0]
        assert rate == pytest.approx(share * 50.0, rel=0.06)
        assert force == pytest.approx(memory.level * cosine, rel=1e-9)


TURNED = [(0.03, 4e5, 5e-6, 1e-4), (-0.03, 4e5, -5e-6, -2e-4), (0.002, -2e6, 9e-7, 5e-4), (0.4, 1e6, 2e-5, 3e-4)]


@pytest.mark.parametrize("bristle", ["isotropic", "anisotropic"])
@pytest.mark.parametrize("core", TURNED)
@pytest.mark.parametrize("w", [0.02, 0.15])
def test_the_filter_s_jacobian_is_that_of_its_rates(bristle: str, core: tuple[float, ...], w: float) -> None:
    """By CasADi's differentiation; the sets of both directions alike, around the rod a third of the level."""
    p = plant("owen2001_simulation", bristle)
    if bristle == "anisotropic":
        p = p._replace(rotary=p.rotary._replace(coulomb=120.0, stribeck=60.0, stribeck_velocity=0.02))
        p = p._replace(film=p.film._replace(film_share=0.5), guide=p.guide._replace(guide_coulomb=32.0))
    gains = design_ekf(p, EkfSettings(), H)
    state, spool = casadi.SX.sym("core", 3), casadi.SX.sym("spool")
    before = casadi.GlobalOptions.getNumpyMode()
    casadi.GlobalOptions.setNumpyMode(1)
    try:
        symbols, _ = believed_rates(*casadi.vertsplit(state), spool, gains, w)
    finally:
        casadi.GlobalOptions.setNumpyMode(before)
    column = casadi.vertcat(*symbols)
    model = casadi.Function("model", [state, spool], [column, casadi.jacobian(column, state)])
    expected_rates, expected = model(core[:3], core[3])
    rates, jacobian = believed_rates(*core, gains, w)
    assert to_array(rates) == pytest.approx(expected_rates.full().ravel(), rel=1e-12)
    assert to_array(jacobian) == pytest.approx(expected.full().ravel(), rel=1e-9, abs=1e-9)


# --- in the loop ----------------------------------------------------------------------------------------------


def turning_loop(values: str, bristle: str, name: str, rpm: float, reference: Any, **changed: Any) -> Run:
    """Two periods of a sine under valve inversion, what is believed being true, a servo holding the rotation."""
    setup = registered(f"rotating_{bristle}", values, rpm=rpm, duration=2.0 / reference.frequency)
    servo = SPEED_SERVO.design(ServoSettings(setup.inputs.motor_voltage), setup.parameters, H)
    return simulate(
        replace(
            setup,
            inputs=setup.inputs._replace(motor_voltage=0.0),
            loop=Loop(*made(name, setup.parameters, **changed)),
            reference=reference,
            rotary=Loop(SPEED_SERVO, servo),
            rotation_speed=rpm * math.pi / 30.0,
        )
    )


def judged(run: Run, period: float) -> tuple[float, float]:
    """rms of the tracking error (m) and of the friction estimate's error (N) over the second period."""
    late = run.time >= period
    errors = (run.signals["error"][late], run.signals["friction_estimate_error"][late])
    return float(np.sqrt(np.mean(errors[0] ** 2))), float(np.sqrt(np.mean(errors[1] ** 2)))


@pytest.mark.parametrize(("values", "bristle"), MACHINES)
@pytest.mark.parametrize("rpm", [25.0, 75.0])
@pytest.mark.parametrize("name", ESTIMATES)
def test_who_knows_of_the_rotation_is_no_worse(values: str, bristle: str, rpm: float, name: str) -> None:
    """Slow and fast sine. The estimate is better, mostly by far, and tracking is no more than 1 % worse.

    That 1 % is where the valve's lag decides (the rig's 0.054 mm on the fast sine). What a reader should see: the
    LuGre observer that ignores the rotation is 545 N wrong on the simulated machine's slow sine at 25 rpm, where there
    are 22 N of friction along.
    """
    for reference in (Sine(0.02, 0.5), Sine(0.005, 0.1)):
        period = 1.0 / reference.frequency
        blind = judged(turning_loop(values, bristle, name, rpm, reference, rotation="ignored"), period)
        knows = judged(turning_loop(values, bristle, name, rpm, reference), period)
        assert knows[1] < blind[1]
        assert knows[0] < 1.01 * blind[0]
        if values == "owen2001_simulation":
            assert knows[1] < 0.4 * blind[1]


@pytest.mark.parametrize("name", ["lugre", "lugre_adaptive"])
def test_lugre_got_worse_when_the_rod_turned(name: str) -> None:
    """Fast sine at 75 rpm, simulated machine: more than the 0.0535 mm at rest while it ignores the rotation."""
    blind = judged(turning_loop(*MACHINES[0], name, 75.0, Sine(0.02, 0.5), rotation="ignored"), 2.0)
    knows = judged(turning_loop(*MACHINES[0], name, 75.0, Sine(0.02, 0.5)), 2.0)
    assert blind[0] > {"lugre": 2.0, "lugre_adaptive": 1.2}[name] * 53.5e-6
    assert knows[0] == pytest.approx(55.2e-6, rel=0.01)
    assert knows[1] < 3.0


def test_a_belief_without_a_motor_has_no_radius() -> None:
    assert believed_turning(STILL).radius == 0.0
    assert believed_turning(plant(*MACHINES[1])).radius == 31.75e-3
