"""The LuGre law: bristles that bend, and slip at the level of the Stribeck curve."""

from typing import Annotated, Any, NamedTuple

from plants import bristles
from plants.equation import Scalar, equation
from plants.friction import directed, lugre, steady_friction
from plants.laws.interface import FrictionLaw


class Bristle(NamedTuple):
    """The mean deflection of the bristles."""

    bristle_deflection: Annotated[float, "m", 1e-4]


@equation
def friction(velocity: Scalar, contact: Bristle, held: Scalar, p: Any) -> tuple[Scalar, Bristle]:
    """See `plants.friction.lugre`."""
    force, rate = lugre(velocity, contact.bristle_deflection, p.friction)
    return force, Bristle(rate)


@equation
def steady(velocity: Scalar, p: Any) -> Scalar:
    """See `plants.friction.steady_friction`."""
    return steady_friction(velocity, directed(velocity, velocity, p.friction))


LUGRE = FrictionLaw(
    name="lugre",
    summary="bristles that bend, and slip at the level of the Stribeck curve",
    source="Canudas de Wit, Olsson, Astrom and Lischinsky 1995; thesis (3.31) to (3.33)",
    friction=friction,
    steady=steady,
    Contact=Bristle,
    plane={law.name: law for law in (bristles.HELICAL, bristles.ISOTROPIC, bristles.ANISOTROPIC)},
)
