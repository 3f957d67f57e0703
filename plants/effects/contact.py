"""Effects on a contact before it slides: another curve of its bristle, and a second element beside it."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.effects.friction_levels import with_levels
from plants.effects.interface import BRISTLE, DISTURBANCE, Effect, Moment, Number
from plants.effects.scales import force, force_by_travel
from plants.equation import Scalar, equation, select, when
from plants.friction import Friction, blended, helical_speed, length, stribeck_level
from plants.laws.interface import Nothing

ROUNDED = 0.01
"""Share of the level about which the rate of a bristle is rounded off: with an exponent below 1 its slope is infinite
there [assumed]."""

UNBENT = 1e-6
"""Share of the level below which a deflection counts as none: the ratio that changes the level is 0/0 there."""


class Exponent(NamedTuple):
    """Of the rate at which a bristle bends less as it comes to its level: 1 is LuGre's."""

    dahl_exponent: Annotated[float, "1"] = 1.0


@equation
def rate_share(distance: Scalar, exponent: Scalar) -> Scalar:
    """w(s) = s ((s^2 + e^2) / (1 + e^2))^((n-1)/2), s |s|^(n-1) rounded off about 0; 1 at s = 1, s for n = 1."""
    rounded = (distance**2 + ROUNDED**2) / (1.0 + ROUNDED**2)
    return distance * rounded ** (0.5 * (exponent - 1.0))


@equation
def level_ratio(exponent: Scalar, bent: Scalar) -> Scalar:
    """f = u / (1 - w(1 - u)) (1), u the deflection in the direction of motion over that of sliding; 1 for u = 1.

    LuGre's rate with the level f g is v (1 - u/f) = v w(1 - u): Dahl's with the exponent n. At u = 0 it is dw/ds(1)^-1.
    """
    still = np.abs(bent) < UNBENT
    ratio = bent / select(still, 1.0, 1.0 - rate_share(1.0 - bent, exponent))
    return select(still, 1.0 / (1.0 + (exponent - 1.0) / (1.0 + ROUNDED**2)), ratio)


@equation
def curved(friction: Friction, moment: Moment, memory: Nothing, p: Any, own: Exponent) -> Friction:
    """dz/dt = v s |s|^(n-1),  s = 1 - u,  u = sigma0 z sgn(v) / g(v): for n = 1 LuGre's dz/dt = v - sigma0 |v| z / g.

    Dahl 1968; Bliman 1992. The levels a0 and a1 are changed so that LuGre's law has that rate. Looks like a contact
    whose stiffness differs between small and large deflections; a second element beside it looks alike before sliding.
    """
    ratio = when(own.dahl_exponent != 1.0, _changed_level, 1.0, own.dahl_exponent, moment, friction)
    a, b = friction.positive, friction.negative
    return Friction(
        with_levels(a, a.coulomb * ratio, a.stribeck * ratio), with_levels(b, b.coulomb * ratio, b.stribeck * ratio)
    )


@equation
def _changed_level(exponent: Scalar, moment: Moment, friction: Friction) -> Scalar:
    speed = helical_speed(moment.velocity, moment.surface_speed)
    along = moment.velocity / speed
    contact = blended(along, along * np.sign(moment.bend), friction)
    return level_ratio(exponent, contact.bristle_stiffness * moment.bend / stribeck_level(speed, contact))


PRESLIDING_CURVE = Effect(
    name="presliding_curve",
    balance="force",
    words="friction before sliding rises along another curve than the declared one",
    source="Dahl 1968; Bliman 1992",
    numbers={"dahl_exponent": Number(0.5, 4.0, 0.1)},
    needs=("position",),
    requires=(BRISTLE,),
    Own=Exponent,
    parameters={"friction": curved},
)
"""Dahl took exponents from 1/2 to 3/2 for solids; 4 is nearly straight at first, and slides after a long way."""


# --- a second element -----------------------------------------------------------------------------------------

SHORTEST_SLIP = 1e-7
"""m. Deflection of sliding below which an element is no faster: no solver could follow it."""


SOONEST = 1e-4
"""s. An element that slips within less is as one that slips at once, and would make equations stiff [assumed]."""


class Element(NamedTuple):
    """Level at which an element beside the contact slips, and its stiffness before."""

    slip_level: Annotated[float, "N"] = 0.0
    slip_stiffness: Annotated[float, "N/m"] = 1e6


class Bent(NamedTuple):
    """The element's deflection."""

    slip_deflection: Annotated[float, "m", 1e-4] = 0.0


@equation
def slip_length(own: Element) -> Scalar:
    """level / k (m): the deflection of an element that slips."""
    return np.maximum(own.slip_level / own.slip_stiffness, SHORTEST_SLIP)


@equation
def carried(disturbance: Scalar, moment: Moment, memory: Bent, p: Any, own: Element) -> Scalar:
    """F = k z (N), |F| at most the level."""
    return disturbance + when(own.slip_level != 0.0, _bent_force, 0.0, memory, own)


@equation
def _bent_force(memory: Bent, own: Element) -> Scalar:
    return own.slip_level * np.minimum(np.maximum(memory.slip_deflection / slip_length(own), -1.0), 1.0)


@equation
def bending(slip: Scalar, command: Scalar, moment: Moment, memory: Bent, p: Any, own: Element) -> Bent:
    """dz/dt = v - |v| k z / level (m/s), |v| over the helix where the rod turns; it slips after `SOONEST` at least.

    One element of Iwan's (1966) and of the generalised Maxwell slip law (Al-Bender, Lampaert and Swevers 2005), beside
    the contact: with it the force before sliding depends on where the motion turned before. Looks like a spring that
    lets go; a bristle that is fitted badly looks alike where all motion slides.
    """
    return Bent(when(own.slip_level > 0.0, _bending, 0.0, moment, memory, own))


@equation
def _bending(moment: Moment, memory: Bent, own: Element) -> Scalar:
    speed = length(moment.velocity, moment.surface_speed)
    return moment.velocity - speed * memory.slip_deflection / np.maximum(slip_length(own), SOONEST * speed)


MAXWELL_SLIP = Effect(
    name="maxwell_slip",
    balance="force",
    words="a second contact slips beside the declared one, at another deflection",
    source="Iwan 1966; Al-Bender, Lampaert and Swevers 2005",
    numbers={
        "slip_level": Number(0.0, 2.0, 0.05, force),
        "slip_stiffness": Number(1.0, 1e6, 0.0, force_by_travel, grid=(10.0, 100.0, 1000.0, 10000.0)),
    },
    needs=("position",),
    Own=Element,
    Memory=Bent,
    inputs={DISTURBANCE: carried},
    remember=bending,
)
