"""Laws that remember nothing: Coulomb's and Stribeck's friction. What sticks is held by a balance of forces.

    F = the force within +-g(v) that is nearest to `held`, and a2 v

Where the mass slides, `held` is beyond the level and friction is g(v) against the motion, exactly, however slow. Where
it is about to stop, `held` is within, and brings it to rest within `STICK_TIME`; there it stays until what drives it
exceeds the level at rest. A switch at a speed, as Karnopp has it (1985), would creep below that speed.
"""

from typing import Any

import numpy as np

from plants.bristles import BristleLaw, Parameters
from plants.equation import Scalar, equation, select
from plants.friction import Friction, blended, coulomb_level, helical_speed, length, stribeck_level
from plants.laws.interface import FrictionLaw, Nothing
from plants.laws.steady import Level, steady_along, steady_in_plane


def _law(name: str, summary: str, source: str, level: Level, uses: tuple[str, ...]) -> FrictionLaw:
    """The law of a level (N) over the speed (m/s), along a line and in the plane."""

    @equation
    def friction(velocity: Scalar, contact: Nothing, held: Scalar, p: Any) -> tuple[Scalar, Nothing]:
        """Friction (N): `held` within the levels of both directions, and the viscous part."""
        both: Friction = p.friction
        most, least = level(velocity, both.positive), -level(velocity, both.negative)
        viscous = select(velocity >= 0.0, both.positive.viscous, both.negative.viscous)
        return np.minimum(np.maximum(held, least), most) + viscous * velocity, Nothing()

    @equation
    def isotropic(
        axial: Scalar, rotary: Scalar, contact: Nothing, held: tuple[Scalar, Scalar], p: Parameters
    ) -> tuple[Scalar, Scalar, Nothing]:
        """The same with vectors: `held` shortened to the level, which turns against the motion where it slides."""
        speed = helical_speed(axial, rotary)
        size = length(held[0], held[1])
        own = blended(held[0] / size, held[0] / size, p.friction)
        share = np.minimum(level(speed, own) / size, 1.0)
        return share * held[0] + own.viscous * axial, share * held[1] + own.viscous * rotary, Nothing()

    return FrictionLaw(
        name=name,
        summary=summary,
        source=source,
        friction=friction,
        steady=steady_along(level),
        uses=uses,
        plane={"isotropic": BristleLaw("isotropic", Nothing, Parameters, isotropic, steady_in_plane(level), "")},
    )


COULOMB = _law(
    "coulomb",
    "one level whatever the speed, and a viscous part; what sticks is held by a balance of forces",
    "Coulomb 1785",
    coulomb_level,
    ("coulomb", "viscous"),
)
STRIBECK = _law(
    "stribeck",
    "a level that falls with speed, and a viscous part; what sticks is held by a balance of forces",
    "Stribeck 1902; thesis (4.7)",
    stribeck_level,
    ("coulomb", "stribeck", "viscous", "stribeck_velocity"),
)
