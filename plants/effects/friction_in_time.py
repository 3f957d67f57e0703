"""Effects on friction that have a time: of rest, of the velocity before, of a record while its oil warms up."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.effects.friction_levels import with_levels
from plants.effects.interface import Effect, Moment, Number
from plants.effects.lags import followed_rate, lagged
from plants.effects.scales import duration, per_duration, travel
from plants.equation import Scalar, changed, equation, select, when
from plants.friction import Friction, LuGre, length, stribeck_level
from plants.laws.interface import Nothing

VISCOUS = LuGre._fields.index("viscous")


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
    that bends is not renewed. r stays where nothing rises: a step of the solver would have to be as short as D / s.
    """
    return Rested(when(own.static_rise != 0.0, _aging, 0.0, slip, memory, own))


@equation
def _aging(slip: Scalar, memory: Rested, own: Aging) -> Scalar:
    forgotten = np.abs(slip) * memory.rested / own.static_rise_distance
    return (1.0 - memory.rested) / own.static_rise_time - forgotten


RISING_STATIC_FRICTION = Effect(
    name="rising_static_friction",
    balance="force",
    words="break-away friction grows with the time at rest",
    source="Armstrong-Helouvry, Dupont and Canudas de Wit 1994; Dieterich 1979",
    numbers={
        "static_rise": Number(0.0, 10.0, 0.2),
        "static_rise_time": Number(0.01, 100.0, 0.0, grid=(0.1, 0.3, 1.0, 3.0, 10.0)),
        "static_rise_distance": Number(1e-6, 1.0, 0.0, travel, grid=(1e-4, 1e-3, 1e-2, 1e-1)),
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

    Oil warms up. Looks like a slope of friction that changes along the record. Where it comes to an end within the
    record it is `warmed`.
    """
    share = np.maximum(1.0 + own.viscous_drift * moment.time, 0.0)
    return Friction(_thinner(friction.positive, share), _thinner(friction.negative, share))


@equation
def _thinner(own: LuGre, share: Scalar) -> LuGre:
    return changed(own, VISCOUS, own.viscous * share)


VISCOUS_DRIFT = Effect(
    name="viscous_drift",
    balance="force",
    words="viscous friction changes along the record, as of oil that warms up",
    source="oil that warms up",
    numbers={"viscous_drift": Number(-1.0, 5.0, 0.05, per_duration)},
    Own=Drift,
    parameters={"friction": drifted},
)


class Warming(NamedTuple):
    """Viscous friction's relative change when the oil has warmed up, and the time constant of that."""

    warming_share: Annotated[float, "1"] = 0.0
    warming_time: Annotated[float, "s"] = 10.0


@equation
def warmed(friction: Friction, moment: Moment, memory: Nothing, p: Any, own: Warming) -> Friction:
    """a2 <- a2 (1 + w (1 - exp(-t/T))), t (s) since the record began.

    Oil that comes to a temperature by Newton's law of cooling. Looks like viscous friction that changes along the
    record; a change that goes on is a drift, friction along the stroke comes back with the position.
    """
    change = when(own.warming_share != 0.0, _warmth, 0.0, moment.time, own)
    share = np.maximum(1.0 + change, 0.0)
    return Friction(_thinner(friction.positive, share), _thinner(friction.negative, share))


@equation
def _warmth(time: Scalar, own: Warming) -> Scalar:
    return own.warming_share * (1.0 - np.exp(-time / own.warming_time))


VISCOUS_WARMING = Effect(
    name="viscous_warming",
    balance="force",
    words="viscous friction changes until the oil has its temperature",
    source="Newton's law of cooling",
    numbers={
        "warming_share": Number(-0.95, 5.0, 0.05),
        "warming_time": Number(0.01, 3.0, 0.0, duration, grid=(0.03, 0.1, 0.3, 1.0)),
    },
    Own=Warming,
    parameters={"friction": warmed},
)
"""Mineral oil becomes about six times as thin between 20 and 60 degrees Celsius."""


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
    speed = when(own.memory_time > 0.0, _lagged_speed, 0.0, moment, memory, own)
    return Friction(_at(speed, friction.positive, own), _at(speed, friction.negative, own))


@equation
def _lagged_speed(moment: Moment, memory: LaggedVelocity, own: Lag) -> Scalar:
    along = lagged(moment.velocity, memory.lagged_velocity, own.memory_time)
    return length(along, lagged(moment.surface_speed, memory.lagged_surface_speed, own.memory_time))


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
    remembers = own.memory_time > 0.0
    along = followed_rate(moment.velocity, memory.lagged_velocity, own.memory_time)
    around = followed_rate(moment.surface_speed, memory.lagged_surface_speed, own.memory_time)
    return LaggedVelocity(select(remembers, along, 0.0), select(remembers, around, 0.0))


FRICTIONAL_MEMORY = Effect(
    name="frictional_memory",
    balance="force",
    words="friction follows the velocity late",
    source="Hess and Soom 1990",
    numbers={"memory_time": Number(0.0, 0.1, 0.005)},
    acts_on=("acceleration",),
    Own=Lag,
    Memory=LaggedVelocity,
    parameters={"friction": late},
    remember=following,
)
"""Hess and Soom measured 3 to 9 ms in a lubricated line contact."""
