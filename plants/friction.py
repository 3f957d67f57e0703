"""Friction laws: pure functions of velocity and, where they have one, of the state of the contact.

All forces are in N and oppose the motion when they have the sign of the velocity. A belief of a controller about
friction is one of these laws too, with parameters of its own.
"""

from typing import Annotated, NamedTuple, Protocol, runtime_checkable

import numpy as np

from plants.equation import Scalar, equation, select

LEVEL_FLOOR = 0.01
"""Smallest steady bristle level, as a share of the static level. Measured sets have a Coulomb level of 0, for
which g -> 0 away from rest, the bristle's rate constant sigma0 |v| / g grows without bound and explicit
integration blows up."""

TINY_LEVEL = 1e-12
"""N. Keeps 0/0 out of a contact without any friction level (such a contact must have no bristle stiffness)."""

TINY = 1e-20
"""m/s or m. Makes the length of a vector smooth at 0, far below any speed or deflection of interest."""


class LuGre(NamedTuple):
    """Parameters of the LuGre law for one direction of motion (thesis 3.2.5)."""

    coulomb: Annotated[float, "N"]
    stribeck: Annotated[float, "N"]
    viscous: Annotated[float, "N s/m"]
    stribeck_velocity: Annotated[float, "m/s"]
    bristle_stiffness: Annotated[float, "N/m"]
    bristle_damping: Annotated[float, "N s/m"]


class Friction(NamedTuple):
    """LuGre parameters for both directions of motion; a symmetric contact has the same set twice."""

    positive: LuGre
    negative: LuGre


@runtime_checkable
class HasFriction(Protocol):
    """Parameters of a contact along which something slides, with LuGre's numbers for either direction."""

    @property
    def friction(self) -> Friction: ...


def friction_in(parameters: object) -> Friction | None:
    """The numbers of the contact among a plant's parameters, in whatever units; None where it has no such contact."""
    found = getattr(parameters, "friction", None)
    return found if getattr(found, "_fields", ()) == Friction._fields else None


@equation
def directed(velocity: Scalar, bristle: Scalar, friction: Friction) -> LuGre:
    """The set that applies to a contact moving at `velocity` (m/s) with `bristle` deflection (m).

    Levels, viscosity and damping go with the direction of motion. The stiffness goes with the side to which
    the bristle is bent, since a force sigma0 z that changed its stiffness at a reversal would jump.
    """
    forward = velocity >= 0.0
    bent_forward = bristle >= 0.0
    a = friction.positive
    b = friction.negative
    return LuGre(
        select(forward, a.coulomb, b.coulomb),
        select(forward, a.stribeck, b.stribeck),
        select(forward, a.viscous, b.viscous),
        select(forward, a.stribeck_velocity, b.stribeck_velocity),
        select(bent_forward, a.bristle_stiffness, b.bristle_stiffness),
        select(forward, a.bristle_damping, b.bristle_damping),
    )


@equation
def blended(motion: Scalar, bend: Scalar, friction: Friction) -> LuGre:
    """The set that applies to a surface that moves and is bent at an angle to the axis.

    `motion` and `bend` are the direction cosines v_axial/|v| and z_axial/|z|. Between purely forward (1) and purely
    backward (-1) the sets mix linearly: a switch at v_axial = 0 would make the friction of a turning rod jump.
    """
    forward = 0.5 + 0.5 * motion
    bent_forward = 0.5 + 0.5 * bend
    a = friction.positive
    b = friction.negative
    return LuGre(
        b.coulomb + forward * (a.coulomb - b.coulomb),
        b.stribeck + forward * (a.stribeck - b.stribeck),
        b.viscous + forward * (a.viscous - b.viscous),
        b.stribeck_velocity + forward * (a.stribeck_velocity - b.stribeck_velocity),
        b.bristle_stiffness + bent_forward * (a.bristle_stiffness - b.bristle_stiffness),
        b.bristle_damping + forward * (a.bristle_damping - b.bristle_damping),
    )


@equation
def stribeck_level(speed: Scalar, p: LuGre) -> Scalar:
    """Steady friction without the viscous part (N): g(v) = a0 + a1 exp(-(v/v_s)^2). Thesis (3.32).

    Floored at `LEVEL_FLOOR` of the static level a0 + a1.
    """
    level = p.coulomb + p.stribeck * np.exp(-((speed / p.stribeck_velocity) ** 2))
    return np.maximum(level, LEVEL_FLOOR * (p.coulomb + p.stribeck) + TINY_LEVEL)


@equation
def coulomb_level(speed: Scalar, p: LuGre) -> Scalar:
    """Steady friction without the viscous part (N) that is a0 at any speed."""
    return p.coulomb


@equation
def stribeck_slope(speed: Scalar, p: LuGre) -> Scalar:
    """dg/dv (N s/m) of `stribeck_level` at a `speed` (m/s) of at least 0: not above 0, and 0 on its floor."""
    ratio = speed / p.stribeck_velocity
    bell = np.exp(-(ratio**2))
    falling = stribeck_level(speed, p) <= p.coulomb + p.stribeck * bell
    return select(falling, -2.0 * ratio / p.stribeck_velocity * p.stribeck * bell, 0.0)


@equation
def lugre(velocity: Scalar, bristle: Scalar, friction: Friction) -> tuple[Scalar, Scalar]:
    """Friction force (N) and bristle rate (m/s) at `velocity` (m/s) and `bristle` deflection (m).

        dz/dt = v - sigma0 |v| z / g(v)
        F     = sigma0 z + sigma1 dz/dt + a2 v

    Canudas de Wit, Olsson, Astrom, Lischinsky 1995; thesis (3.31) to (3.33). With a constant sigma1 the law is
    guaranteed passive only for a2 > sigma1 a1 / a0.
    """
    p = directed(velocity, bristle, friction)
    rate = velocity - p.bristle_stiffness * np.abs(velocity) * bristle / stribeck_level(velocity, p)
    return p.bristle_stiffness * bristle + p.bristle_damping * rate + p.viscous * velocity, rate


@equation
def length(axial: Scalar, rotary: Scalar) -> Scalar:
    """Length of a vector, smooth at 0, where it is `TINY`."""
    return np.sqrt(axial**2 + rotary**2 + TINY**2)


@equation
def helical_speed(axial: Scalar, rotary: Scalar) -> Scalar:
    """Speed along the helix (m/s) of a surface that moves `axial` and `rotary` (m/s). Thesis 3.3.2."""
    return length(axial, rotary)


@equation
def lugre_helical(axial: Scalar, rotary: Scalar, bristle: Scalar, friction: Friction) -> tuple[Scalar, Scalar, Scalar]:
    """Axial and rotary friction (N) and bristle rate (m/s) of one scalar bristle along the helix.

        v_h   = sqrt(v^2 + w^2),  dz/dt = v_h - sigma0 v_h z / g(v_h)
        F_h   = sigma0 z + sigma1 dz/dt + a2 v_h
        axial = F_h v / v_h,  rotary = F_h w / v_h

    Thesis (3.45) to (3.47), as printed. The bristle only ever bends forward (z >= 0), so that this law has
    neither presliding nor reversal and does not become the non-rotating one at w = 0: there its friction at rest is a
    bare sign function, on which an integrator chatters. Not for rods that stand still: take `lugre_isotropic`.
    """
    speed = helical_speed(axial, rotary)
    p = blended(axial / speed, axial / speed, friction)
    rate = speed - p.bristle_stiffness * speed * bristle / stribeck_level(speed, p)
    force = p.bristle_stiffness * bristle + p.bristle_damping * rate + p.viscous * speed
    return force * axial / speed, force * rotary / speed, rate


@equation
def lugre_isotropic(
    axial: Scalar, rotary: Scalar, bristle_axial: Scalar, bristle_rotary: Scalar, friction: Friction
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Axial and rotary friction (N) and the rates (m/s) of a bristle with a component along each.

        dz/dt = v - sigma0 |v| z / g(|v|),  F = sigma0 z + sigma1 dz/dt + a2 v     (v, z, F vectors)

    The scalar law with vectors in place of signed numbers: at w = 0, with the rotary component at 0, it is
    `lugre`. Sets that differ with direction are `blended`.
    """
    speed = helical_speed(axial, rotary)
    p = blended(axial / speed, bristle_axial / length(bristle_axial, bristle_rotary), friction)
    relax = p.bristle_stiffness * speed / stribeck_level(speed, p)
    rate_axial = axial - relax * bristle_axial
    rate_rotary = rotary - relax * bristle_rotary
    return (
        p.bristle_stiffness * bristle_axial + p.bristle_damping * rate_axial + p.viscous * axial,
        p.bristle_stiffness * bristle_rotary + p.bristle_damping * rate_rotary + p.viscous * rotary,
        rate_axial,
        rate_rotary,
    )


@equation
def steady_friction(velocity: Scalar, p: LuGre) -> Scalar:
    """Friction (N) after a long time at constant `velocity` (m/s): g(v) sgn(v) + a2 v. Thesis (4.7)."""
    return stribeck_level(velocity, p) * np.sign(velocity) + p.viscous * velocity


class Tustin(NamedTuple):
    """Parameters of the modified Tustin law: F = (al0 + al1 |v|^(1/2) + al2 |v|) sgn(v)."""

    constant: Annotated[float, "N"]
    root: Annotated[float, "N s^0.5/m^0.5"]
    linear: Annotated[float, "N s/m"]


@equation
def modified_tustin(velocity: Scalar, p: Tustin) -> Scalar:
    """Friction (N) at `velocity` (m/s) by Tafazoli's modified Tustin law (thesis 2.8); al1 < 0 gives the drop."""
    speed = np.abs(velocity)
    return (p.constant + p.root * np.sqrt(speed) + p.linear * speed) * np.sign(velocity)


@equation
def dahl(velocity: Scalar, bristle: Scalar, coulomb: Scalar, stiffness: Scalar) -> tuple[Scalar, Scalar]:
    """Friction (N) and bristle rate (m/s) by Dahl's law, exponent 1: LuGre with a constant level, undamped.

        dz/dt = v - sigma0 |v| z / F_c,  F = sigma0 z        Dahl 1968

    `coulomb` in N, `stiffness` in N/m.
    """
    return stiffness * bristle, velocity - stiffness * np.abs(velocity) * bristle / np.maximum(coulomb, TINY_LEVEL)


@equation
def classical(velocity: Scalar, applied: Scalar, stick_speed: Scalar, p: LuGre) -> Scalar:
    """Friction (N) by the classical law: Coulomb, viscous and Stribeck when sliding, a balance when stuck.

    Within `stick_speed` (m/s) friction balances the `applied` force (N) up to the static level a0 + a1
    (Karnopp 1985); beyond it, `steady_friction`. The bristle parameters are not used.
    """
    static = p.coulomb + p.stribeck
    held = np.minimum(np.maximum(applied, -static), static)
    return select(np.abs(velocity) <= stick_speed, held, steady_friction(velocity, p))
