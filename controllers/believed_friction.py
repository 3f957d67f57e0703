"""What compensators believe of the friction of a rod that slides and may turn: the laws of `plants.anisotropic`.

    along, around, levels = contact(velocity, surface_speed, bristle, friction, turning)

The speed of rotation is measured (`Measurement.rotation_speed`), low-pass filtered, and counted at the piston's
surface. Without it, or where none is measured, all of this is the friction of a rod that only slides.
"""

from typing import Annotated, NamedTuple

import numpy as np

from controllers.belief import Anisotropic, HasFriction, HasMotor
from controllers.settings import About, Needs
from plants.anisotropic import Film, Guide, Levels, anisotropic_levels
from plants.equation import Scalar, equation, select
from plants.friction import Friction, LuGre, blended, helical_speed

RotationUse = Annotated[
    str, "measured", "ignored", About("whether friction is taken at the helical speed, from the measured rotation")
]
RotationTimeConstant = Annotated[
    float, "s", About("time constant of the measured rotation's low-pass", above=True), Needs("rotation", "measured")
]

ROTATION_SETTINGS = ("rotation", "rotation_time_constant")

FILTER_TIME = 10e-3
"""s. Default low-pass of the measured speed of rotation: rotation changes no faster than its servo, some 10 Hz."""


class Turning(NamedTuple):
    """What is believed of a rod that turns, beside the friction along it.

    `radius` is 0 where rotation does not count. `apart` is 1 for levels of its own around the rod, in `around`, and 0
    where friction is the same in both directions.
    """

    radius: Annotated[float, "m"]
    apart: Annotated[float, "1"]
    around: LuGre
    film: Film
    guide: Guide


def believed_turning(belief: HasFriction, rotation: str = "measured") -> Turning:
    """What a believed plant says of a rod that turns; nothing (radius 0) if it does not turn or that is ignored."""
    radius = belief.motor.piston_radius if isinstance(belief, HasMotor) and rotation == "measured" else 0.0
    if isinstance(belief, Anisotropic):
        return Turning(radius, 1.0, belief.rotary, belief.film, belief.guide)
    return Turning(radius, 0.0, belief.friction.positive, Film(), Guide())


def rotation_gain(rotation_time_constant: float, sample_time: float) -> float:
    """1 - exp(-h/T): the share of a new reading that the low-pass of the speed of rotation takes.

    Raises:
        ValueError: a time constant that is not above 0.
    """
    if rotation_time_constant <= 0.0:
        raise ValueError(f"rotation_time_constant is {rotation_time_constant:g}, expected a value above 0")
    return low_pass_gain(rotation_time_constant, sample_time)


def low_pass_gain(time_constant: float, sample_time: float) -> float:
    """1 - exp(-h/T): the share of a new reading that a first-order low-pass takes; all of it for T = 0."""
    return float(-np.expm1(-sample_time / time_constant)) if time_constant else 1.0


@equation
def measured_rotation(reading: Scalar) -> Scalar:
    """The measured speed of rotation (rad/s), 0 where it is not measured (NaN)."""
    return select(np.abs(reading) < np.inf, reading, 0.0)


@equation
def filtered_rotation(reading: Scalar, before: Scalar, gain: Scalar) -> Scalar:
    """w_f <- w_f + (1 - exp(-h/T)) (w - w_f): the speed of rotation (rad/s) through a first-order low-pass."""
    return before + gain * (measured_rotation(reading) - before)


@equation
def contact(
    velocity: Scalar, surface_speed: Scalar, bristle: Scalar, friction: Friction, turning: Turning
) -> tuple[LuGre, LuGre, Levels]:
    """The sets that apply along and around, and the levels of `anisotropic_levels`, at axial and surface speed (m/s).

    Without rotation the set is that of `directed`; with it the directions of motion are `blended`. Where friction is
    the same along and around, S_a = S_r = g(v_h), and S_a^2 v / w is g(v_h) v / v_h.
    """
    turned = velocity / helical_speed(velocity, surface_speed)
    motion = select(np.abs(surface_speed) > 0.0, turned, select(velocity >= 0.0, 1.0, -1.0))
    along = blended(motion, select(bristle >= 0.0, 1.0, -1.0), friction)
    own, other = turning.apart > 0.5, turning.around
    around = LuGre(
        select(own, other.coulomb, along.coulomb),
        select(own, other.stribeck, along.stribeck),
        select(own, other.viscous, along.viscous),
        select(own, other.stribeck_velocity, along.stribeck_velocity),
        select(own, other.bristle_stiffness, along.bristle_stiffness),
        select(own, other.bristle_damping, along.bristle_damping),
    )
    return along, around, anisotropic_levels(velocity, surface_speed, along, around, turning.film, turning.guide)


@equation
def saturated_sign(velocity: Scalar, reversal_speed: Scalar) -> Scalar:
    """sat(v / eps), eps = `reversal_speed` (m/s): the sign of the velocity with a steep line through rest."""
    return np.minimum(np.maximum(velocity / reversal_speed, -1.0), 1.0)


@equation
def turned_sign(velocity: Scalar, surface_speed: Scalar, reversal_speed: Scalar) -> Scalar:
    """v / max(v_h, eps): the share of friction that acts along a rod that turns; `saturated_sign` if it does not."""
    return velocity / np.maximum(helical_speed(velocity, surface_speed), reversal_speed)


@equation
def steady_along(velocity: Scalar, reversal_speed: Scalar, along: LuGre, levels: Levels) -> Scalar:
    """Believed steady axial friction (N) of a `contact`, its jump at rest a line within eps = `reversal_speed` (m/s).

        F = S_a^2 v / max(w, S_a eps) + g_g sat(v/eps) + a2 v

    `steady_anisotropic` but for the line; w is the power of sliding, g_g the level of a guide that does not turn.
    """
    sliding = np.maximum(levels.sliding, levels.axial * reversal_speed)
    guided = levels.guide * saturated_sign(velocity, reversal_speed)
    return levels.axial**2 * velocity / sliding + guided + along.viscous * velocity
