"""Effects on force, contact, command and sensors against numbers found without them."""

import numpy as np
import pytest
from effect_machines import FREE_MASS, TRUTH, at_rest, having, remembered

from plants.effects.registry import effects
from plants.equation import replaced
from plants.friction import stribeck_level
from plants.registry import plants
from workbench.simulation.references import Ramp, Sine
from workbench.simulation.simulate import Feed, Integrator, Run, Setup, simulate

MASS = FREE_MASS["mass"]
FINE = Integrator(tolerance=1e-9)


def let_go(values: dict[str, float], duration: float, force: float = 0.0, **states: float) -> Run:
    """A run of a drive without friction from some states, under a constant force (N) of the drive."""
    plant, p = having("drive_force", values, FREE_MASS)
    state, inputs = at_rest(plant, p, **states)
    run = simulate(Setup(plant, p, state, replaced(inputs, {"drive_force": force}), duration, integrator=FINE))
    assert run.outcome == "completed"
    return run


# --- forces ---------------------------------------------------------------------------------------------------


def test_cogging_is_a_potential_over_the_position() -> None:
    """M v^2/2 + U is kept, U = p/(2 pi) (a sin(2 pi x/p) - b cos(2 pi x/p))."""
    a, b, pitch = 30.0, -20.0, 8e-3
    values = {"cogging_cosine": a, "cogging_sine": b, "cogging_pitch": pitch}
    run = let_go(values, 0.5, velocity=0.1)
    angle = 2.0 * np.pi * run.state("position") / pitch
    potential = pitch / (2.0 * np.pi) * (a * np.sin(angle) - b * np.cos(angle))
    energy = 0.5 * MASS * run.state("velocity") ** 2 + potential
    assert np.ptp(potential) > 0.5 * energy[0], "it is felt"
    assert energy == pytest.approx(energy[0], rel=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_cushion_throws_back_after_half_a_swing(side: float) -> None:
    """Back at its start after pi sqrt(M/k), having gone v sqrt(M/k) into it."""
    stiffness, start, speed = 2e4, 0.01, 0.1
    values = {"cushion_stiffness": stiffness, "cushion_start": side * start}
    swing, way = np.pi * np.sqrt(MASS / stiffness), speed * np.sqrt(MASS / stiffness)
    run = let_go(values, 2.0 * start / speed + swing, position=0.0, velocity=side * speed)
    assert side * run.state("position")[-1] == pytest.approx(0.0, abs=1e-4)
    assert run.state("velocity")[-1] == pytest.approx(-side * speed, rel=1e-6)
    assert np.max(side * run.state("position")) == pytest.approx(start + way, rel=1e-4)
    assert np.min(side * run.state("position")) > -1e-4, "the other side has none"


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_a_load_behind_a_spring_swings_at_its_frequency_over_the_root_of_the_rest(share: float) -> None:
    """Free at both ends f / sqrt(1 - s), and the declared mass goes on with its momentum."""
    values = {"compliant_share": share, "compliant_frequency": 8.0, "compliant_damping": 1e-9}
    run = let_go(values, 2.0, velocity=0.1)
    own, load = run.state("velocity"), run.state("load_velocity")
    assert MASS * ((1.0 - share) * own + share * load) == pytest.approx((1.0 - share) * 0.1 * MASS, rel=1e-6)
    swinging, frequency = own - load, 8.0 / np.sqrt(1.0 - share)
    assert swinging == pytest.approx(0.1 * np.cos(2.0 * np.pi * frequency * run.time), abs=1e-5)


def test_a_load_behind_a_spring_that_is_damped_is_moved_in_the_end() -> None:
    """The force a declared mass needs: F / M, once the swinging is over."""
    run = let_go({"compliant_share": 0.5, "compliant_frequency": 20.0, "compliant_damping": 0.3}, 1.0, force=5.0)
    rates = np.diff(run.state("velocity")) / np.diff(run.time)
    assert rates[-50:] == pytest.approx(5.0 / MASS, rel=1e-4)


def test_oil_warms_up_to_a_temperature() -> None:
    """a2 (1 + w (1 - exp(-t/T))): all of w in the end."""
    plant, p = having("drive_force", {"warming_share": -0.4, "warming_time": 3.0})
    state, inputs = at_rest(plant, p, velocity=0.1)
    start, later, end = (float(plant.derivatives(t, state, inputs, p).velocity) for t in (0.0, 1.5, 1e3))
    slower = 0.4 * TRUTH["viscous"] * 0.1 / TRUTH["mass"]
    assert end - start == pytest.approx(slower, rel=1e-9)
    assert later - start == pytest.approx((1.0 - np.exp(-0.5)) * slower, rel=1e-9)


# --- before sliding -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["drive_force", "non_rotating", "rotating_isotropic"])
@pytest.mark.parametrize("exponent", [0.7, 1.0, 2.0])
@pytest.mark.parametrize("velocity", [1e-3, -4e-3])
def test_the_rate_of_a_bristle_has_dahls_exponent(name: str, exponent: float, velocity: float) -> None:
    """dz/dt = v s |s|^(n-1), s = 1 - sigma0 z sgn(v) / g(v), also of a bristle that is bent the other way."""
    plant, p = having(name, {"dahl_exponent": exponent})
    contact = p.friction.positive if velocity > 0.0 else p.friction.negative
    level = float(stribeck_level(abs(velocity), contact))
    bristle = "bristle_axial" if "isotropic" in name else "bristle_deflection"
    for share in (-0.8, -0.1, 0.0, 0.3, 0.9):
        bent = share * np.sign(velocity) * level / contact.bristle_stiffness
        state, inputs = at_rest(plant, p, velocity=velocity, **{bristle: bent})
        rate = float(plant.derivatives(0.0, state, inputs, p).contact[0])
        if share < 0.0:  # bent against the motion: by the other direction's stiffness
            other = p.friction.negative if velocity > 0.0 else p.friction.positive
            share *= other.bristle_stiffness / contact.bristle_stiffness
        distance = 1.0 - share
        assert rate == pytest.approx(velocity * distance**exponent, abs=2e-3 * abs(velocity))


def test_a_contact_of_another_law_has_no_exponent() -> None:
    with pytest.raises(ValueError, match="it has no bristle"):
        plants()["rotating_anisotropic"].with_effects(effects()["presliding_curve"])


def test_a_second_element_springs_then_slips() -> None:
    """F = level (1 - exp(-k x / level)) on the way there; back from it level (2 exp(-k x / level) - 1), slid before."""
    level, stiffness, speed = 40.0, 2e5, 1e-3
    plant, p = having("drive_force", {"slip_level": level, "slip_stiffness": stiffness})
    times = np.linspace(0.0, 4.0, 4001)

    def motion(time: float) -> tuple[float, float]:
        return (speed * time, speed) if time < 2.0 else (speed * (4.0 - time), -speed)

    force = stiffness * remembered(plant, p, motion, lambda time: 0.0, times)[:, 0]
    way = speed * np.where(times <= 2.0, times, times - 2.0)
    fading = np.exp(-stiffness * way / level)
    assert force == pytest.approx(level * np.where(times <= 2.0, 1.0 - fading, 2.0 * fading - 1.0), abs=0.01 * level)
    state, inputs = at_rest(plant, p, slip_deflection=1e-4)
    moved = float(plant.derivatives(0.0, state, inputs, p).velocity)
    still = float(plant.derivatives(0.0, at_rest(plant, p)[0], inputs, p).velocity)
    assert still - moved == pytest.approx(stiffness * 1e-4 / TRUTH["mass"], rel=1e-12)


# --- command --------------------------------------------------------------------------------------------------


def test_a_spool_that_sticks_jumps_by_its_stiction() -> None:
    """A slow ramp makes stairs: it stays, then goes to where the command is by then."""
    stiction, rate = 0.2, 0.1
    plant, p = having("non_rotating", {"spool_stiction": stiction})
    state, inputs = plant.equilibrium(p, 0.0)
    run = simulate(Setup(plant, p, state, inputs, 10.0, feeds=(Feed(plant.command, Ramp(rate=rate, stop=10.0)),)))
    held = run.state("spool_position") / TRUTH["valve_position_gain"]
    gap = rate * run.time - held
    assert np.max(gap) == pytest.approx(stiction, rel=0.02)
    rests = np.abs(np.diff(held, prepend=held[0])) < 1e-9 * stiction
    assert np.mean(rests) > 0.9, "it rests nearly all the time"
    stairs = np.unique(np.round(held[rests], 3))
    assert np.diff(stairs[stairs > 0.1]) == pytest.approx(stiction, rel=0.02)


def test_a_spool_that_hardly_sticks_follows_a_held_command_as_one_that_does_not() -> None:
    """It comes free at once, however often it sticks: what it does to a motion goes to 0 with its stiction."""
    plant, p = having("non_rotating", {"spool_stiction": 1e-6})
    runs = []
    for own in (p, having("non_rotating", {"spool_stiction": 0.0})[1]):
        state, inputs = plant.equilibrium(own, 0.0)
        feeds = (Feed(plant.command, Sine(0.5, 0.7), linear=False),)
        runs.append(simulate(Setup(plant, own, state, inputs, 2.0, feeds=feeds, sample_time=0.01)).state("position"))
    assert np.ptp(runs[1]) > 1e-3
    assert runs[0] == pytest.approx(runs[1], abs=1e-5 * np.ptp(runs[1]))


def test_a_spool_that_sticks_does_not_follow_what_is_smaller() -> None:
    plant, p = having("non_rotating", {"spool_stiction": 0.2})
    state, inputs = plant.equilibrium(p, 0.0)
    feeds = (Feed(plant.command, Ramp(rate=0.18, stop=1.0)),)
    run = simulate(Setup(plant, p, state, inputs, 1.2, feeds=feeds))
    assert np.max(np.abs(run.state("spool_position"))) < 1e-9
    feeds = (Feed(plant.command, Ramp(rate=0.05, stop=5.0)),)  # so slow that it arrives before that has gone on
    run = simulate(Setup(plant, p, state, inputs, 5.2, feeds=feeds))
    assert run.outcome == "completed"
    came_free, to = run.time[np.abs(run.state("spool_position")) > 1e-8][0], 0.05 * 4.0
    assert came_free == pytest.approx(4.0, abs=0.01)
    assert run.state("spool_position")[-1] == pytest.approx(TRUTH["valve_position_gain"] * to, rel=0.02)


def test_hysteresis_is_looked_for() -> None:
    given = {name for name, effect in effects().items() if not effect.sought}
    assert {name for name in given if not name.endswith(("_curve", "_map"))} == {"valve_dynamics"}
    assert effects()["valve_hysteresis"].sought


# --- sensors --------------------------------------------------------------------------------------------------


def test_a_sensor_shows_an_error_that_repeats() -> None:
    values = {"position_ripple_cosine": 2e-5, "position_ripple_sine": -1e-5, "position_ripple_pitch": 3e-3}
    plant, p = having("drive_force", values)
    for position in (-7e-3, 0.0, 1e-3):
        angle = 2.0 * np.pi * position / 3e-3
        expected = position + 2e-5 * np.cos(angle) - 1e-5 * np.sin(angle)
        assert float(plant.measure(at_rest(plant, p, position=position)[0], p).position) == pytest.approx(expected)


def test_a_sensor_with_a_lag_shows_what_a_filter_makes_of_the_position() -> None:
    """Behind a mass that is pushed, x = a t^2/2, it shows a (t^2/2 - T t + T^2 (1 - exp(-t/T)))."""
    lag, push = 0.02, 5.0
    run = let_go({"position_sensor_lag": lag}, 0.3, force=push)
    shown = run.plant.measure(run.plant.State._make(_columns(run)), run.parameters).position
    time = run.time
    expected = push / MASS * (0.5 * time**2 - lag * time + lag**2 * (1.0 - np.exp(-time / lag)))
    assert np.max(np.abs(shown - expected)) < 1e-8
    assert np.max(np.abs(run.state("position") - expected)) > 1e-3


def _columns(run: Run) -> list[object]:
    """The run's states in their places: position, velocity, contact, effects."""
    filled = replaced(run.plant.equilibrium(run.parameters, 0.0)[0], {})
    lead = type(filled.effects)._make([type(filled.effects[0])._make([run.state("sensor_lead")])])
    contact = type(filled.contact)._make([run.state("bristle_deflection")])
    places = {"position": run.state("position"), "velocity": run.state("velocity"), "contact": contact, "effects": lead}
    return [places[name] for name in run.plant.State._fields]
