"""Friction laws: what must hold for all parameters and motions, and their known solutions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from plants.friction import (
    Friction,
    LuGre,
    Tustin,
    classical,
    dahl,
    lugre,
    lugre_helical,
    lugre_isotropic,
    modified_tustin,
    steady_friction,
    stribeck_level,
)

THESIS = LuGre(370.0, 217.0, 2318.0, 0.032, 5.77e6, 2.28e4)
"""The set of chapter 3."""

speeds = st.floats(1e-6, 1.0)
velocities = st.builds(lambda side, speed: side * speed, st.sampled_from([-1.0, 1.0]), speeds)
shares = st.floats(-1.0, 1.0)
"""Bristle deflection over the largest that its static level allows."""

sets = st.builds(
    LuGre,
    coulomb=st.floats(1.0, 1e3),
    stribeck=st.floats(0.0, 5e2),
    viscous=st.floats(0.0, 4e4),
    stribeck_velocity=st.floats(1e-3, 0.1),
    bristle_stiffness=st.floats(1e4, 1e7),
    bristle_damping=st.floats(0.0, 1e5),
)


def passive(p: LuGre, excess: float) -> LuGre:
    """`p` with a viscous friction on (excess 0) or above the bound of a passive law, a2 = sigma1 a1/a0."""
    return p._replace(viscous=p.bristle_damping * p.stribeck / p.coulomb * (1.0 + excess))


passive_sets = st.builds(passive, sets, st.floats(0.0, 2.0))


def largest_deflection(p: LuGre) -> float:
    """(a0 + a1)/sigma0 (m), beyond which no motion bends a bristle."""
    return (p.coulomb + p.stribeck) / p.bristle_stiffness


@given(velocities, sets)
def test_steady_friction_opposes_motion(velocity: float, p: LuGre) -> None:
    """Between Coulomb and static level, and the viscous part, all with the sign of the velocity."""
    dry = steady_friction(velocity, p) * np.sign(velocity) - p.viscous * abs(velocity)
    tolerance = 1e-12 * (p.coulomb + p.stribeck + p.viscous)
    assert p.coulomb - tolerance <= dry <= p.coulomb + p.stribeck + tolerance


@given(velocities, sets, sets)
def test_lugre_settles_on_steady_friction(velocity: float, forward: LuGre, backward: LuGre) -> None:
    """At z = g sgn(v)/sigma0 the bristle rests, and the force is that of the direction of motion."""
    p = forward if velocity > 0.0 else backward
    bent = np.sign(velocity) * stribeck_level(velocity, p) / p.bristle_stiffness
    force, rate = lugre(velocity, bent, Friction(forward, backward))
    assert abs(rate) <= 1e-14 * abs(velocity)
    assert force == pytest.approx(steady_friction(velocity, p), rel=1e-9)


@given(velocities, shares, passive_sets, passive_sets)
def test_lugre_dissipates(velocity: float, share: float, forward: LuGre, backward: LuGre) -> None:
    """F v >= d/dt (sigma0 z^2/2): what goes in is stored in the bristle or lost, whatever the direction."""
    side = forward if share >= 0.0 else backward
    bent = share * largest_deflection(side)
    force, rate = lugre(velocity, bent, Friction(forward, backward))
    stored = side.bristle_stiffness * bent * rate
    assert force * velocity - stored >= -1e-12 * (abs(force * velocity) + abs(stored))


@given(st.lists(st.tuples(velocities, st.floats(1e-5, 0.1)), min_size=1, max_size=20), passive_sets)
def test_no_motion_draws_energy_from_a_passive_contact(motion: list[tuple[float, float]], p: LuGre) -> None:
    """Over spans of constant velocity force and bristle rate are linear in z, so that the work is exact:
    z = z_s + (z0 - z_s) exp(-l t). The work done on the contact never falls below the energy in its bristle."""
    friction = Friction(p, p)
    bent, work, size = 0.0, 0.0, 0.0
    for velocity, span in motion:
        unbent_force, unbent_rate = lugre(velocity, 0.0, friction)
        unit = largest_deflection(p)
        unit_force, unit_rate = lugre(velocity, unit, friction)
        constant = (unbent_rate - unit_rate) / unit
        settled = unbent_rate / constant
        decayed = -np.expm1(-constant * span)
        integral = settled * span + (bent - settled) * decayed / constant
        work += velocity * (unbent_force * span + (unit_force - unbent_force) / unit * integral)
        size += abs(velocity) * span * (abs(unbent_force) + abs(unit_force))
        bent += (settled - bent) * decayed
        assert work >= 0.5 * p.bristle_stiffness * bent**2 - 1e-9 * size


@given(velocities, shares, sets, sets)
def test_force_is_continuous_where_the_direction_changes(
    velocity: float, share: float, forward: LuGre, backward: LuGre
) -> None:
    """No jump where the velocity passes 0 with the bristle bent, nor where the bristle passes 0 in motion."""
    friction = Friction(forward, backward)
    bent = share * largest_deflection(forward if share >= 0.0 else backward)
    before, after = (lugre(side * 1e-15, bent, friction)[0] for side in (-1.0, 1.0))
    assert after == pytest.approx(before, rel=1e-9, abs=1e-6)
    before, after = (lugre(velocity, side * 1e-20, friction)[0] for side in (-1.0, 1.0))
    assert after == pytest.approx(before, rel=1e-9, abs=1e-6)


def test_level_is_floored_without_coulomb_friction() -> None:
    """Thesis table 5.4 at 25 rpm: Coulomb 0, static 50 N; at 11 mm/s 1 % of the static level is left."""
    p = LuGre(0.0, 50.0, 34800.0, 3.0e-3, 2.6e6, 1.1e4)
    assert stribeck_level(0.0, p) == pytest.approx(50.0)
    assert stribeck_level(3.0e-3, p) == pytest.approx(50.0 / np.e)
    assert stribeck_level(0.011, p) == pytest.approx(0.5)
    assert stribeck_level(10.0, p) == pytest.approx(0.5)


def test_bristles_of_the_thesis_give_way_at_their_level() -> None:
    """Pulled slowly, far below v_s: F = g (1 - exp(-sigma0 x/g)) + a2 v, the solution for a constant level."""
    speed, level = 1e-5, 587.0
    path = np.linspace(0.0, 5e-4, 40)
    friction = Friction(THESIS, THESIS)
    bristle = solve_ivp(
        lambda t, z: [lugre(speed, z[0], friction)[1]],
        (0.0, path[-1] / speed),
        [0.0],
        t_eval=path / speed,
        rtol=1e-9,
        atol=1e-13,
        method="LSODA",
    ).y[0]
    force = lugre(speed, bristle, friction)[0]
    decay = np.exp(-THESIS.bristle_stiffness * path / level)
    damped = (THESIS.bristle_damping * decay + THESIS.viscous) * speed
    assert force == pytest.approx(level * (1.0 - decay) + damped, abs=1e-3)


# --- along the helix -----------------------------------------------------------------------------------------


@given(velocities, shares, sets, sets)
def test_isotropic_law_without_rotation_is_the_scalar_law(
    velocity: float, share: float, forward: LuGre, backward: LuGre
) -> None:
    friction = Friction(forward, backward)
    bent = share * largest_deflection(forward if share >= 0.0 else backward)
    force, rate = lugre(velocity, bent, friction)
    axial, rotary, rate_axial, rate_rotary = lugre_isotropic(velocity, 0.0, bent, 0.0, friction)
    p = forward if velocity > 0.0 else backward
    size = (p.bristle_damping + p.viscous) * abs(velocity) + p.coulomb
    assert axial == pytest.approx(force, rel=1e-9, abs=1e-9 * size)
    assert rate_axial == pytest.approx(rate, rel=1e-9, abs=1e-9 * abs(velocity))
    assert (rotary, rate_rotary) == (0.0, 0.0)


@given(velocities, velocities, shares, shares, st.floats(-np.pi, np.pi), sets)
def test_isotropic_law_knows_no_direction(
    axial: float, rotary: float, along: float, around: float, angle: float, p: LuGre
) -> None:
    """Turn velocity and bristle by an angle, and force and rate turn with them."""
    friction, unit = Friction(p, p), largest_deflection(p)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    velocity, bristle = np.array([axial, rotary]), unit * np.array([along, around])
    plain = np.reshape(lugre_isotropic(*velocity, *bristle, friction), (2, 2))
    turned = np.reshape(lugre_isotropic(*(turn @ velocity), *(turn @ bristle), friction), (2, 2))
    sizes = np.max(np.abs(plain), axis=1)
    floor = np.array([p.coulomb, np.hypot(axial, rotary)])
    assert np.max(np.abs(turned - plain @ turn.T).max(axis=1) / (sizes + floor)) < 1e-9


@pytest.mark.parametrize("law", ["helical", "isotropic"])
@given(axial=velocities, rotary=speeds, p=sets)
def test_steady_friction_along_the_helix(law: str, axial: float, rotary: float, p: LuGre) -> None:
    """At rest in its bristles each law opposes the helical velocity with g(v_h) + a2 v_h."""
    speed = np.hypot(axial, rotary)
    bent = stribeck_level(speed, p) / p.bristle_stiffness
    if law == "helical":
        forces = lugre_helical(axial, rotary, bent, Friction(p, p))[:2]
    else:
        forces = lugre_isotropic(axial, rotary, bent * axial / speed, bent * rotary / speed, Friction(p, p))[:2]
    expected = steady_friction(speed, p)
    assert np.hypot(*forces) == pytest.approx(expected, rel=1e-9)
    assert forces[0] * rotary == pytest.approx(forces[1] * axial, rel=1e-6)
    assert forces[0] * axial > 0.0


@pytest.mark.parametrize("rpm", [120, 290, 460, 630, 800])
def test_rotation_makes_axial_friction_a_slope(rpm: float) -> None:
    """About v = 0 dF/dv = a2 + a0/w where w is far above v_s: Coulomb friction turned into a viscous one."""
    surface_speed = rpm * 2.0 * np.pi / 60.0 * 0.019
    bent = THESIS.coulomb / THESIS.bristle_stiffness
    slow = 1e-6
    slopes = [
        (lugre_helical(slow, surface_speed, bent, Friction(THESIS, THESIS))[0]) / slow,
        lugre_isotropic(slow, surface_speed, bent * slow / surface_speed, bent, Friction(THESIS, THESIS))[0] / slow,
    ]
    assert slopes == pytest.approx([2318.0 + 370.0 / surface_speed] * 2, rel=1e-6)


# --- the other laws ------------------------------------------------------------------------------------------


@given(velocities, st.floats(1.0, 1e3), st.floats(1e4, 1e7))
def test_dahl_settles_on_coulomb(velocity: float, coulomb: float, stiffness: float) -> None:
    force, rate = dahl(velocity, np.sign(velocity) * coulomb / stiffness, coulomb, stiffness)
    assert force == pytest.approx(np.sign(velocity) * coulomb, rel=1e-12)
    assert abs(rate) <= 1e-12 * abs(velocity)


def test_dahl_presliding_and_reversal() -> None:
    """Dahl's curves over displacement: F = F_c (1 - exp(-s x/F_c)), and back from F1 by x:
    F = -F_c + (F_c + F1) exp(-s x/F_c)."""
    coulomb, stiffness, reach = 10.0, 1e5, 2e-4
    path = np.linspace(0.0, reach, 30)
    curves, bristle = [], 0.0
    for direction in (1.0, -1.0):
        z = solve_ivp(
            lambda x, z, v=direction: [dahl(v, z[0], coulomb, stiffness)[1]],
            (0.0, reach),
            [bristle],
            t_eval=path,
            rtol=1e-10,
            atol=1e-16,
        ).y[0]
        bristle = z[-1]
        curves.append(dahl(direction, z, coulomb, stiffness)[0])
    there = coulomb * (1.0 - np.exp(-stiffness * path / coulomb))
    back = -coulomb + (coulomb + there[-1]) * np.exp(-stiffness * path / coulomb)
    assert curves[0] == pytest.approx(there, abs=1e-7)
    assert curves[1] == pytest.approx(back, abs=1e-7)


FITTED = Tustin(693.0, -1754.0, 4613.0)
"""Fit to the thesis's steady friction over 1 mm/s to 0.25 m/s, 14 N rms off."""


@given(velocities)
def test_modified_tustin_is_odd(velocity: float) -> None:
    assert modified_tustin(-velocity, FITTED) == -modified_tustin(velocity, FITTED)


def test_modified_tustin_has_its_minimum_and_slope() -> None:
    """dF/dv = al1/(2 sqrt v) + al2 is 0 at (al1/(2 al2))^2 = 36.1 mm/s, where F = al0 - al1^2/(4 al2)."""
    lowest = (1754.0 / (2.0 * 4613.0)) ** 2
    assert modified_tustin(lowest, FITTED) == pytest.approx(693.0 - 1754.0**2 / (4.0 * 4613.0), rel=1e-12)
    for speed in (1e-3, lowest, 0.2):
        step = 1e-4 * speed
        slope = (modified_tustin(speed + step, FITTED) - modified_tustin(speed - step, FITTED)) / (2.0 * step)
        assert slope == pytest.approx(-1754.0 / (2.0 * np.sqrt(speed)) + 4613.0, rel=1e-6, abs=1e-2)


def test_modified_tustin_fits_the_thesis() -> None:
    speed = np.linspace(1e-3, 0.25, 500)
    error = modified_tustin(speed, FITTED) - steady_friction(speed, THESIS)
    assert np.sqrt(np.mean(error**2)) == pytest.approx(14.0, abs=1.0)


@given(velocities, st.floats(-2e3, 2e3))
def test_classical_law_sticks_and_slips(velocity: float, applied: float) -> None:
    """Stuck, it balances the applied force up to 587 N; sliding, it does not know of it."""
    held = classical(1e-4 * velocity, applied, 1e-4, THESIS)
    assert held == (applied if abs(applied) <= 587.0 else np.sign(applied) * 587.0)
    if abs(velocity) > 1e-4:
        dry = 370.0 + 217.0 * np.exp(-((velocity / 0.032) ** 2))
        expected = dry * np.sign(velocity) + 2318.0 * velocity
        assert classical(velocity, applied, 1e-4, THESIS) == pytest.approx(expected, rel=1e-12)


@given(rotary=st.floats(0.01, 2.0), bristle_axial=st.floats(-1e-4, 1e-4), bristle_rotary=st.floats(1e-5, 1e-4))
def test_friction_of_a_turning_rod_does_not_jump_where_the_axial_motion_turns(
    rotary: float, bristle_axial: float, bristle_rotary: float
) -> None:
    friction = Friction(
        LuGre(330.0, 150.0, 22_800.0, 2.4e-3, 2.6e6, 1.1e4), LuGre(290.0, 110.0, 28_200.0, 3.1e-3, 2.6e6, 11.3e4)
    )
    forward, backward = (
        lugre_isotropic(axial, rotary, bristle_axial, bristle_rotary, friction)[:2] for axial in (1e-12, -1e-12)
    )
    assert forward == pytest.approx(backward, rel=1e-6, abs=1e-3)
