"""Generalised Maxwell slip: elements in parallel, each of which sticks elastically or slips at its share of the level.

Before sliding it remembers where it turned round, as real contacts do (hysteresis with non-local memory); while it
slides friction follows the Stribeck curve late.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.equation import Scalar, equation, select
from plants.friction import directed, stribeck_level
from plants.laws import lugre
from plants.laws.interface import FrictionLaw

LEVEL_SHARE = 0.25
"""Of each of the four elements."""

STIFFNESS_SHARES = (8.0 / 15.0, 4.0 / 15.0, 2.0 / 15.0, 1.0 / 15.0)
"""Of the contact's stiffness: the elements give way one after the other, each at twice the deflection of the one
before. Four elements in this proportion are this program's own choice."""

ONSET = 2e-3
"""Share of its deflection within which an element begins to slip beyond its level, or sticks after a reversal: the
sharp change of the law, as a solver can take it."""


class Elements(NamedTuple):
    """Force of each element, and whether it slips: 1, or 0 where it sticks.

    How exactly a solver follows the latter matters to the forces alone: hence its large typical magnitude.
    """

    element_force_1: Annotated[float, "N", 10.0]
    element_force_2: Annotated[float, "N", 10.0]
    element_force_3: Annotated[float, "N", 10.0]
    element_force_4: Annotated[float, "N", 10.0]
    element_slips_1: Annotated[float, "1", 100.0]
    element_slips_2: Annotated[float, "1", 100.0]
    element_slips_3: Annotated[float, "1", 100.0]
    element_slips_4: Annotated[float, "1", 100.0]


class Lag(NamedTuple):
    """Time in which friction follows the Stribeck curve while it slides. Default: of the 3 to 9 ms that Hess and Soom
    (1990) measured in a lubricated line contact.
    """

    lag_time: Annotated[float, "s"] = 5e-3


@equation
def element(velocity: Scalar, force: Scalar, slips: Scalar, share: Scalar, p: Any) -> tuple[Scalar, Scalar, Scalar]:
    """Rates of an element's force (N/s) and of whether it slips (1/s), and the share of it that sticks.

        sticks:  dF_i/dt = k_i v                                 until |F_i| = alpha_i g(v)
        slips:   dF_i/dt = sgn(v) C (alpha_i - |F_i| / g(v))     until v reverses,   C = (a0 + a1) / T

    `share` is k_i / sigma0; alpha_i is `LEVEL_SHARE`. Al-Bender, Lampaert and Swevers 2005, whose C is the same for all
    elements. To change from one to the other takes a few times `ONSET` of the deflection; the power of 3/4 makes the
    change end after a finite way, and smoothly enough for an error-controlled solver.
    """
    own = directed(velocity, force, p.friction)
    limit = LEVEL_SHARE * stribeck_level(velocity, own)
    stiffness = share * own.bristle_stiffness
    slipping = np.minimum(np.maximum(slips, 0.0), 1.0)
    way = np.abs(velocity) * stiffness / (ONSET * limit)
    beyond = np.minimum(np.maximum((np.abs(force) - limit) / (ONSET * limit), 0.0), 1.0)
    turned = force * velocity < 0.0
    change = way * select(turned, -(slipping**0.75), beyond * (1.0 - slipping) ** 0.75)
    attraction = (own.coulomb + own.stribeck) / p.law.lag_time
    slip = select(turned, 0.0, np.sign(velocity) * attraction * LEVEL_SHARE * (1.0 - np.abs(force) / limit))
    return (1.0 - slipping) * stiffness * velocity + slipping * slip, change, 1.0 - slipping


@equation
def friction(velocity: Scalar, contact: Elements, held: Scalar, p: Any) -> tuple[Scalar, Elements]:
    """F = sum of F_i + sigma1 v (what of the contact sticks) + a2 v (N), and the rates of the elements."""
    own, share = directed(velocity, velocity, p.friction), STIFFNESS_SHARES
    rate_1, slip_1, stuck_1 = element(velocity, contact.element_force_1, contact.element_slips_1, share[0], p)
    rate_2, slip_2, stuck_2 = element(velocity, contact.element_force_2, contact.element_slips_2, share[1], p)
    rate_3, slip_3, stuck_3 = element(velocity, contact.element_force_3, contact.element_slips_3, share[2], p)
    rate_4, slip_4, stuck_4 = element(velocity, contact.element_force_4, contact.element_slips_4, share[3], p)
    elastic = contact.element_force_1 + contact.element_force_2 + contact.element_force_3 + contact.element_force_4
    stuck = share[0] * stuck_1 + share[1] * stuck_2 + share[2] * stuck_3 + share[3] * stuck_4
    force = elastic + own.bristle_damping * stuck * velocity + own.viscous * velocity
    return force, Elements(rate_1, rate_2, rate_3, rate_4, slip_1, slip_2, slip_3, slip_4)


GMS = FrictionLaw(
    name="gms",
    summary="generalised Maxwell slip: four elements in parallel; remembers reversals, follows the level late",
    source="Al-Bender, Lampaert and Swevers 2005",
    friction=friction,
    steady=lugre.steady,
    Contact=Elements,
    Extra=Lag,
)
