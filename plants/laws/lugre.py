"""The LuGre law: bristles that bend, and slip at the level of the Stribeck curve."""

from typing import Annotated, Any, NamedTuple

from plants import bristles
from plants.equation import Scalar, equation
from plants.friction import lugre, stribeck_level
from plants.laws.interface import FrictionLaw
from plants.laws.steady import steady_along


class Bristle(NamedTuple):
    """The mean deflection of the bristles."""

    bristle_deflection: Annotated[float, "m", 1e-4]


@equation
def friction(velocity: Scalar, contact: Bristle, held: Scalar, p: Any) -> tuple[Scalar, Bristle]:
    """See `plants.friction.lugre`."""
    force, rate = lugre(velocity, contact.bristle_deflection, p.friction)
    return force, Bristle(rate)


steady = steady_along(stribeck_level)


LUGRE = FrictionLaw(
    name="lugre",
    summary="bristles that bend, and slip at the level of the Stribeck curve",
    source="Canudas de Wit, Olsson, Astrom and Lischinsky 1995; thesis (3.31) to (3.33)",
    friction=friction,
    steady=steady,
    Contact=Bristle,
    plane={law.name: law for law in (bristles.HELICAL, bristles.ISOTROPIC, bristles.ANISOTROPIC)},
)


def named(plant: str, law: FrictionLaw) -> str:
    """The name of a plant with a law: of that with LuGre's, the thesis's, it says nothing."""
    return plant if law is LUGRE else f"{plant}_{law.name}"
