"""The bristle with levels of its own along and around: its ellipse, its limits, its power, and the measured rig."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from command import STUDIES
from hypothesis import given, settings
from hypothesis import strategies as st
from numba_equations import njit
from support import registered

from controllers.speed_servo import SPEED_SERVO
from plants.anisotropic import Film, Guide, anisotropic_levels, level_fall, lugre_anisotropic, steady_anisotropic
from plants.bristles import ANISOTROPIC, GuidedBristle
from plants.friction import Friction, LuGre, lugre, lugre_isotropic, steady_friction, stribeck_level
from plants.registry import plants
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.references import Sine, Steps
from workbench.simulation.simulate import Feed, Loop, Setup, simulate, solver_error
from workbench.study.reading import read_study
from workbench.study.resolve import resolve
from workbench.study.unfold import unfold

SET = read_parameters(named_sets()["owen2001_experiment"])
MEASURED = build(ANISOTROPIC.Parameters, SET)
FORWARD = Friction(MEASURED.friction.positive, MEASURED.friction.positive)
RADIUS = 31.75e-3
RPM = 2.0 * np.pi / 60.0 * RADIUS
FASTEST = 800.0 * RPM
NO_FILM, NO_GUIDE = Film(), Guide()


def steady(axial: Any, rotary: float, friction: Friction = FORWARD, guide: Guide = NO_GUIDE) -> Any:
    return steady_anisotropic(axial, rotary, friction, MEASURED.rotary, NO_FILM, guide)[0]


@pytest.mark.parametrize(
    ("rpm", "at_rest", "regression"), [(75.0, 12550.0, 11600.0), (100.0, 9510.0, 9075.0), (125.0, 7470.0, 7256.0)]
)
def test_added_slope(rpm: float, at_rest: float, regression: float) -> None:
    """S_a^2/(S_r v_r) at rest, and the slope of a regression over 0 to 0.0114 m/s, both above a2 = 22 800."""
    velocity = np.linspace(0.0, 0.0114, 400)
    force = steady(velocity, rpm * RPM) - 22800.0 * velocity
    small = 1e-6
    assert (steady(small, rpm * RPM) / small - 22800.0) == pytest.approx(at_rest, rel=0.03)
    assert np.polyfit(velocity, force, 1)[0] == pytest.approx(regression, rel=0.03)


@settings(max_examples=200, deadline=None)
@given(axial=st.floats(-0.16, 0.16), rotary=st.floats(0.01, FASTEST), film=st.floats(0.3, 1.0))
def test_friction_lies_on_the_ellipse(axial: float, rotary: float, film: float) -> None:
    """(F_a/S_a)^2 + (F_r/S_r)^2 = 1 without the viscous part, S at the helical speed, by the measured set."""
    thin = Film(film, 0.04)
    along, around = steady_anisotropic(axial, rotary, FORWARD, MEASURED.rotary, thin, NO_GUIDE)
    speed = np.hypot(axial, rotary)
    level = (330.0 + 150.0 * np.exp(-((speed / 0.0024) ** 2))) * (film + (1 - film) * np.exp(-((speed / 0.04) ** 2)))
    turned = 34.7 + 14.6 * np.exp(-((speed / 0.042) ** 2))
    dry = ((along - 22800.0 * axial) / level) ** 2 + ((around - 8.3 * rotary) / turned) ** 2
    assert dry == pytest.approx(1.0, rel=1e-6)


@settings(max_examples=200, deadline=None)
@given(axial=st.floats(-0.16, 0.16), bent=st.floats(-2e-4, 2e-4))
def test_without_rotation_it_is_lugre(axial: float, bent: float) -> None:
    force, torque, rate, around, _ = lugre_anisotropic(
        axial, 0.0, GuidedBristle(bent, 0.0, 0.0), MEASURED.friction, MEASURED.rotary, Film(), Guide()
    )
    expected = lugre(axial, bent, MEASURED.friction)
    assert (float(force), float(rate)) == pytest.approx(tuple(map(float, expected)), rel=1e-9, abs=1e-9)
    assert (float(torque), float(around)) == (0.0, 0.0)


@settings(max_examples=200, deadline=None)
@given(
    axial=st.floats(-0.16, 0.16),
    rotary=st.floats(-0.5, 0.5),
    along=st.floats(-1e-4, 1e-4),
    around=st.floats(-1e-4, 1e-4),
)
def test_with_equal_levels_it_is_isotropic(axial: float, rotary: float, along: float, around: float) -> None:
    law = LuGre(370.0, 217.0, 2318.0, 0.032, 5.77e6, 1e3)
    both = Friction(law, law)
    found = lugre_anisotropic(axial, rotary, GuidedBristle(along, around, 0.0), both, law, NO_FILM, NO_GUIDE)
    expected = lugre_isotropic(axial, rotary, along, around, both)
    assert [float(value) for value in found[:4]] == pytest.approx(
        [float(value) for value in expected], rel=1e-6, abs=1e-6
    )


@pytest.mark.parametrize("velocity", [1e-3, 6e-3, -8e-3])
def test_the_guide_is_a_part_of_what_is_measured_without_rotation(velocity: float) -> None:
    guide = Guide(10.0, 40.0, 0.0025)
    law = MEASURED.friction.positive if velocity > 0.0 else MEASURED.friction.negative
    found = steady(velocity, 0.0, MEASURED.friction, guide=guide)
    assert found == pytest.approx(float(steady_friction(velocity, law)), rel=1e-9)
    turning = steady(1e-9, 0.3, guide=guide)
    assert turning == pytest.approx(50.0, rel=1e-3), "rotation leaves the guide's static friction"


@njit
def _settled(
    axial: float, rotary: float, h: float, friction: Friction, around: LuGre, film: Film, guide: Guide
) -> GuidedBristle:
    """The bristles after 60 000 steps of Euler's method at one velocity, in compiled code."""
    z = GuidedBristle(0.0, 0.0, 0.0)
    for _ in range(60_000):
        found = lugre_anisotropic(axial, rotary, z, friction, around, film, guide)
        z = GuidedBristle(z[0] + h * found[2], z[1] + h * found[3], z[2] + h * found[4])
    return z


@pytest.mark.parametrize(
    ("velocity", "rpm"), [(0.01, 0.0), (0.004, 10.0), (-0.008, 50.0), (0.011, 125.0), (0.1, 800.0)]
)
def test_the_bristles_settle_on_steady_friction(velocity: float, rpm: float) -> None:
    film, guide = Film(0.7, 0.04), Guide(10.0, 30.0, 0.003)
    bristles = _settled(velocity, rpm * RPM, 2e-6 if rpm else 2e-5, MEASURED.friction, MEASURED.rotary, film, guide)
    force, *_ = lugre_anisotropic(velocity, rpm * RPM, bristles, MEASURED.friction, MEASURED.rotary, film, guide)
    assert float(force) == pytest.approx(
        float(steady_anisotropic(velocity, rpm * RPM, MEASURED.friction, MEASURED.rotary, film, guide)[0]), rel=2e-3
    )


@njit
def _integrated(
    axial: np.ndarray,
    rotary: np.ndarray,
    h: float,
    friction: Friction,
    around: LuGre,
    film: Film,
    guide: Guide,
) -> tuple[np.ndarray, np.ndarray]:
    """Heun's method in compiled code."""
    z = np.zeros(3)
    work, stored = np.zeros(axial.size), np.zeros(axial.size)
    for k in range(1, axial.size):
        a, r = 0.5 * (axial[k] + axial[k - 1]), 0.5 * (rotary[k] + rotary[k - 1])
        first = lugre_anisotropic(a, r, GuidedBristle(z[0], z[1], z[2]), friction, around, film, guide)
        m = GuidedBristle(z[0] + 0.5 * h * first[2], z[1] + 0.5 * h * first[3], z[2] + 0.5 * h * first[4])
        middle = lugre_anisotropic(a, r, m, friction, around, film, guide)
        work[k] = work[k - 1] + h * (middle[0] * a + middle[1] * r)
        for i in range(3):
            z[i] += h * middle[2 + i]
        share = (guide.guide_coulomb + guide.guide_stribeck) / 480.0
        # The stiffness is the same for both directions, 2.6e6 N/m.
        stiffness = 2.6e6
        stored[k] = 0.5 * stiffness * ((1.0 - share) * z[0] ** 2 + share * z[2] ** 2) + 0.5 * 300.0 * z[1] ** 2
    return work, stored


def power_and_storage(seed: int, film: Film, guide: Guide) -> tuple[np.ndarray, np.ndarray]:
    """Work done on the contact since the start, and what its bristles hold (J), along a random motion of 4 s."""
    rng = np.random.default_rng(seed)
    h, count = 1e-5, 100_000
    time = h * np.arange(count)

    def random_speed(largest: float) -> np.ndarray:
        frequency, phase = rng.uniform(0.2, 30.0, 6), rng.uniform(0.0, 2.0 * np.pi, 6)
        waves = np.sin(2.0 * np.pi * frequency[:, None] * time + phase[:, None]).sum(axis=0)
        return largest * waves / np.max(np.abs(waves))

    axial = random_speed(rng.choice([0.005, 0.02, 0.16]))
    rotary = rng.choice([0.0, 0.1, 1.0]) * random_speed(FASTEST)
    return _integrated(axial, rotary, h, MEASURED.friction, MEASURED.rotary, film, guide)


@pytest.mark.parametrize("seed", range(8))
def test_dissipates_in_the_range_of_the_thesis(seed: int) -> None:
    """Work is never less than what the bristles hold: random motions to 0.16 m/s and 800 rpm, the measured sets."""
    work, stored = power_and_storage(seed, NO_FILM, NO_GUIDE)
    assert np.min(work - stored) > -1e-3 * np.max(work)
    assert work[-1] > 0.0


@pytest.mark.parametrize("seed", range(4))
def test_a_film_dissipates(seed: int) -> None:
    work, stored = power_and_storage(seed, Film(0.502, 0.042), NO_GUIDE)
    assert np.min(work - stored) > -1e-3 * np.max(work)


@pytest.mark.parametrize("speed", [0.5e-3, 3.1e-3, 0.02, 0.1])
def test_fall_of_the_level_is_its_logarithmic_slope(speed: float) -> None:
    film, guide, along = Film(0.502, 0.042), Guide(20.0, 15.0, 0.002), MEASURED.friction.negative

    def level(v: float) -> float:
        return float(anisotropic_levels(v, 0.0, along, MEASURED.rotary, film, guide).axial)

    h = 1e-4
    slope = (np.log(level(speed * (1.0 + h))) - np.log(level(speed * (1.0 - h)))) / (2.0 * h)
    assert float(level_fall(speed, along, film, guide)) == pytest.approx(-slope, rel=1e-5)


@pytest.mark.parametrize("scenario", ["extend", "retract"])
def test_film_and_guide_slide_smoothly_without_rotation(scenario: str) -> None:
    """The quasi-static run of the study, less than 2.5 um/s from one ms to the next: no swing of 1 mm/s at 60 Hz."""
    study = read_study(STUDIES / "thesis_chapter5.toml")
    (case,) = (
        case
        for case in unfold(study)
        if case.columns["case"] == "corrected" and (case.axes["scenario"], case.rpm) == (scenario, 0.0)
    )
    run = simulate(resolve(study, case).setup)
    assert run.outcome == "completed"
    velocity = run.signals["velocity"]
    assert np.max(np.abs(np.diff(velocity))) < 2.5e-6
    reached = -9.5e-3 if scenario == "retract" else 9.5e-3
    assert velocity[-1] / reached > 0.9


@pytest.mark.parametrize("rpm", [0.0, 10.0, 50.0, 125.0, 800.0])
@pytest.mark.parametrize("volts", [0.3, -2.0, 10.0])
def test_stable_with_the_measured_sets(rpm: float, volts: float) -> None:
    """Open loop from rest to 0.16 m/s and back to rest, at every rpm: no divergence, error under 1e-7 m."""
    setup = registered("rotating_anisotropic", "owen2001_experiment", rpm=rpm, duration=0.6)
    steps = Steps((volts, 0.0), 0.3)
    setup = replace(setup, feeds=(Feed("valve_voltage", steps, linear=False),))
    run = simulate(setup)
    assert run.outcome == "completed"
    error = solver_error(setup, run)
    assert error is not None
    assert error < 1e-7
    if volts == 10.0:
        assert np.max(run.signals["velocity"]) > 0.15
    final = stribeck_level(0.0, MEASURED.friction.positive)
    assert np.max(np.abs(run.signals["axial_friction"])) < final + 0.2 * 28200.0 + 1500.0


@pytest.mark.parametrize("rpm", [10.0, 125.0, 450.0])
def test_a_speed_servo_holds_the_measured_sets(rpm: float) -> None:
    """Rotary viscous friction of 8.3 N s/m, not the axial 22 800, is what the servo has to know of."""
    plant = plants()["rotating_anisotropic"]
    parameters = build(plant.Parameters, SET)
    state, inputs = plant.equilibrium(parameters, rpm * RPM)
    state = state._replace(position=-50e-3)
    speed = rpm * 2.0 * np.pi / 60.0
    servo = SPEED_SERVO.design(SPEED_SERVO.Settings(speed, state.motor_current), parameters, 1e-3)
    loop, fed = Loop(SPEED_SERVO, servo), inputs._replace(motor_voltage=0.0)
    valve = Feed("valve_voltage", Sine(9.5, 0.5))
    run = simulate(Setup(plant, parameters, state, fed, 2.0, rotary=loop, rotation_speed=speed, feeds=(valve,)))
    assert run.outcome == "completed"
    assert np.max(np.abs(run.signals["velocity"])) > 0.14
    late = run.time > 1.5
    assert np.mean(run.signals["rotation_speed"][late]) == pytest.approx(speed, rel=0.05)
