"""Effects that change the friction of a contact: along the stroke, with pressure, time, rest, and the velocity before.

Each takes the contact's LuGre set for both directions and gives another; whatever law the plant has, it takes that.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.effects.interface import FREE, Effect, Moment, Number, Scales
from plants.equation import Scalar, changed, equation, select, when
from plants.friction import Friction, LuGre, length, stribeck_level
from plants.laws.interface import Nothing

VISCOUS = LuGre._fields.index("viscous")

LEAST_FRICTION = 0.05
"""Share of its friction that a contact keeps along the stroke. With none at all LuGre's bristle would be renewed at
once, and no solver could follow it."""

SHORTEST_MEMORY = 1e-4
"""s. A memory that is shorter is simulated with this one: the bristle itself is no faster."""

LONGEST_STROKE, UNKNOWN_STROKE = 1e3, 2.0
"""m. A stroke beyond the first is not known; the second is taken in its place: friction then changes with the position
in metres."""


@equation
def with_levels(own: LuGre, coulomb: Scalar, stribeck: Scalar) -> LuGre:
    """The set with other levels (N)."""
    return LuGre(coulomb, stribeck, own.viscous, own.stribeck_velocity, own.bristle_stiffness, own.bristle_damping)


# --- by parameters that every contact has ---------------------------------------------------------------------

DIRECTION_ASYMMETRY = Effect(
    name="direction_asymmetry",
    balance="force",
    words="friction differs between the two directions",
    source="Owen 2001, tables 5.2 and 5.3",
    numbers={
        "coulomb_negative": Number(0.0, FREE, 0.0),
        "stribeck_negative": Number(0.0, FREE, 0.0),
        "viscous_negative": Number(0.0, FREE, 0.0),
    },
    apart=(
        ("coulomb_negative",),
        ("viscous_negative",),
        ("coulomb_negative", "stribeck_negative"),
        ("coulomb_negative", "viscous_negative"),
        ("coulomb_negative", "stribeck_negative", "viscous_negative"),
    ),
)


# --- along the stroke -----------------------------------------------------------------------------------------


class AlongStroke(NamedTuple):
    """Shares of the friction in mid-stroke that are added at the stroke's ends.

    The gradient's is added at the positive end and taken off at the negative one, the curvature's added at both.
    """

    friction_gradient: Annotated[float, "1"] = 0.0
    friction_curvature: Annotated[float, "1"] = 0.0


@equation
def along_stroke(friction: Friction, moment: Moment, memory: Nothing, p: Any, own: AlongStroke) -> Friction:
    """a0 <- a0 f, a1 <- a1 f with f = 1 + b1 xi + b2 xi^2, xi = 2 x / L, x (m) from mid-stroke.

    Wear and seal fit along the bore (Bonchis, Corke and Rye 1999). Looks like friction that is larger at one end or in
    the middle; a spring load is the same without changing sign with the velocity.
    """
    xi = 2.0 * moment.position / select(moment.stroke < LONGEST_STROKE, moment.stroke, UNKNOWN_STROKE)
    shape = np.maximum(1.0 + own.friction_gradient * xi + own.friction_curvature * xi**2, LEAST_FRICTION)
    a, b = friction.positive, friction.negative
    return Friction(
        with_levels(a, a.coulomb * shape, a.stribeck * shape), with_levels(b, b.coulomb * shape, b.stribeck * shape)
    )


POSITION_DEPENDENT_FRICTION = Effect(
    name="position_dependent_friction",
    balance="force",
    words="friction changes along the stroke",
    source="Bonchis, Corke and Rye 1999",
    numbers={"friction_gradient": Number(-0.9, 0.9, 0.05), "friction_curvature": Number(-0.9, 5.0, 0.05)},
    apart=(("friction_gradient",), ("friction_curvature",), ("friction_gradient", "friction_curvature")),
    needs=("position",),
    Own=AlongStroke,
    parameters={"friction": along_stroke},
)


# --- with pressure --------------------------------------------------------------------------------------------


class ByPressure(NamedTuple):
    """Friction a load pressure."""

    friction_per_pressure: Annotated[float, "N/Pa"] = 0.0


@equation
def pressed(friction: Friction, moment: Moment, memory: Nothing, p: Any, own: ByPressure) -> Friction:
    """a0 <- a0 + c |P1 - P2|.

    A seal that is pressed by what it seals (Bonchis et al. 1999). Looks like friction that grows with the load; a
    poorly fitted bristle leaves a residual that |P_L| sgn(v) explains as well.
    """
    rise = own.friction_per_pressure * np.abs(moment.pressure_1 - moment.pressure_2)
    a, b = friction.positive, friction.negative
    return Friction(with_levels(a, a.coulomb + rise, a.stribeck), with_levels(b, b.coulomb + rise, b.stribeck))


def force_by_pressure(scales: Scales) -> float:
    """N/Pa."""
    return scales.force / scales.pressure


PRESSURE_DEPENDENT_FRICTION = Effect(
    name="pressure_dependent_friction",
    balance="force",
    words="friction grows with the load pressure, as of a seal that is pressed by it",
    source="Bonchis, Corke and Rye 1999",
    numbers={"friction_per_pressure": Number(0.0, 50.0, 0.1, force_by_pressure)},
    needs=("pressure_1",),
    circular=True,
    requires=("pressure_1", "pressure_2"),
    Own=ByPressure,
    parameters={"friction": pressed},
)


# --- with time at rest ----------------------------------------------------------------------------------------


class Aging(NamedTuple):
    """How much break-away rises, in which time at rest, and over which distance of sliding that is forgotten."""

    static_rise: Annotated[float, "1"] = 0.0
    static_rise_time: Annotated[float, "s"] = 1.0
    static_rise_distance: Annotated[float, "m"] = 1e-4


class Rested(NamedTuple):
    """The share of its rise that static friction has made."""

    rested: Annotated[float, "1", 1.0] = 1.0


@equation
def aged(friction: Friction, moment: Moment, memory: Rested, p: Any, own: Aging) -> Friction:
    """a1 <- a1 (1 + s r).

    Break-away grows with the time at rest (Armstrong-Helouvry et al. 1994). Looks like a higher peak after long holds;
    noise of the velocity in holds looks alike.
    """
    rise = 1.0 + own.static_rise * memory.rested
    a, b = friction.positive, friction.negative
    return Friction(with_levels(a, a.coulomb, a.stribeck * rise), with_levels(b, b.coulomb, b.stribeck * rise))


@equation
def aging(slip: Scalar, command: Scalar, moment: Moment, memory: Rested, p: Any, own: Aging) -> Rested:
    """dr/dt = (1 - r)/T - |s| r/D: up at rest in the time T, forgotten within the distance D of sliding.

    The law of contacts that age (Dieterich 1979, Ruina 1983), here with an end. `slip` s = v - dz/dt (m/s): a bristle
    that bends is not renewed.
    """
    forgotten = np.abs(slip) * memory.rested / own.static_rise_distance
    return Rested((1.0 - memory.rested) / own.static_rise_time - forgotten)


RISING_STATIC_FRICTION = Effect(
    name="rising_static_friction",
    balance="force",
    words="break-away friction grows with the time at rest",
    source="Armstrong-Helouvry, Dupont and Canudas de Wit 1994; Dieterich 1979",
    numbers={
        "static_rise": Number(0.0, 10.0, 0.2),
        "static_rise_time": Number(0.0, FREE, 0.0),
        "static_rise_distance": Number(0.0, FREE, 0.0),
    },
    apart=(
        ("static_rise",),
        ("static_rise", "static_rise_time"),
        ("static_rise", "static_rise_distance"),
        ("static_rise", "static_rise_time", "static_rise_distance"),
    ),
    Own=Aging,
    Memory=Rested,
    parameters={"friction": aged},
    remember=aging,
)


# --- with time ------------------------------------------------------------------------------------------------


class Drift(NamedTuple):
    """Viscous friction's relative change a second."""

    viscous_drift: Annotated[float, "1/s"] = 0.0


@equation
def drifted(friction: Friction, moment: Moment, memory: Nothing, p: Any, own: Drift) -> Friction:
    """a2 <- a2 (1 + d t), t (s) since the record began.

    Oil warms up. Looks like a slope of friction that changes along the record.
    """
    share = np.maximum(1.0 + own.viscous_drift * moment.time, 0.0)
    return Friction(_thinner(friction.positive, share), _thinner(friction.negative, share))


@equation
def _thinner(own: LuGre, share: Scalar) -> LuGre:
    return changed(own, VISCOUS, own.viscous * share)


def per_duration(scales: Scales) -> float:
    """1/s: by 1 until the end of the record."""
    return 1.0 / scales.duration


VISCOUS_DRIFT = Effect(
    name="viscous_drift",
    balance="force",
    words="viscous friction changes along the record, as of oil that warms up",
    source="oil that warms up",
    numbers={"viscous_drift": Number(-1.0, 10.0, 0.05, per_duration)},
    Own=Drift,
    parameters={"friction": drifted},
)


# --- with the velocity before ---------------------------------------------------------------------------------


class Lag(NamedTuple):
    """The time in which friction follows the velocity."""

    memory_time: Annotated[float, "s"] = 0.0


class LaggedVelocity(NamedTuple):
    """The velocity at which the Stribeck curve is taken, along and around the rod."""

    lagged_velocity: Annotated[float, "m/s", 1e-1] = 0.0
    lagged_surface_speed: Annotated[float, "m/s", 1e-1] = 0.0


@equation
def late(friction: Friction, moment: Moment, memory: LaggedVelocity, p: Any, own: Lag) -> Friction:
    """a0 <- g(v_m), a1 <- 0: the level of the velocity v_m before.

    Friction follows velocity late (Hess and Soom 1990), here by a lag of first order. Looks like loops of friction over
    velocity while sliding; a command's delay or a velocity that is filtered more than the pressures looks alike.
    """
    speed = length(memory.lagged_velocity, memory.lagged_surface_speed)
    return Friction(_at(speed, friction.positive, own), _at(speed, friction.negative, own))


@equation
def _at(speed: Scalar, contact: LuGre, own: Lag) -> LuGre:
    """The set whose level is that at a speed (m/s); as it is without memory."""
    remembers = own.memory_time > 0.0
    level = when(remembers, stribeck_level, contact.coulomb, speed, contact)
    return with_levels(contact, level, select(remembers, 0.0, contact.stribeck))


@equation
def following(
    slip: Scalar, command: Scalar, moment: Moment, memory: LaggedVelocity, p: Any, own: Lag
) -> LaggedVelocity:
    """dv_m/dt = (v - v_m)/tau_m (m/s^2), 0 without memory."""
    rate = select(own.memory_time > 0.0, 1.0 / np.maximum(own.memory_time, SHORTEST_MEMORY), 0.0)
    return LaggedVelocity(
        (moment.velocity - memory.lagged_velocity) * rate,
        (moment.surface_speed - memory.lagged_surface_speed) * rate,
    )


FRICTIONAL_MEMORY = Effect(
    name="frictional_memory",
    balance="force",
    words="friction follows the velocity late",
    source="Hess and Soom 1990",
    numbers={"memory_time": Number(0.0, 0.5, 0.005)},
    acts_on=("acceleration",),
    Own=Lag,
    Memory=LaggedVelocity,
    parameters={"friction": late},
    remember=following,
)
