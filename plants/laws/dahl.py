"""Dahl's law: a contact that is elastic before it slides, and slides at one level whatever the speed."""

from typing import Any

from plants.bristles import BristleLaw, Parameters, PlaneBristle
from plants.equation import Scalar, equation
from plants.friction import Friction, LuGre, coulomb_level, directed, lugre_isotropic
from plants.friction import dahl as dahl_contact
from plants.laws.interface import FrictionLaw
from plants.laws.lugre import Bristle
from plants.laws.steady import steady_along, steady_in_plane


@equation
def friction(velocity: Scalar, contact: Bristle, held: Scalar, p: Any) -> tuple[Scalar, Bristle]:
    """F = sigma0 z + a2 v,  dz/dt = v - sigma0 |v| z / a0. Dahl 1968, exponent 1, with viscous friction."""
    own = directed(velocity, contact.bristle_deflection, p.friction)
    force, rate = dahl_contact(velocity, contact.bristle_deflection, own.coulomb, own.bristle_stiffness)
    return force + own.viscous * velocity, Bristle(rate)


@equation
def _as_lugre(own: LuGre) -> LuGre:
    """The LuGre set that is Dahl's law: no Stribeck friction, no damping of the bristle."""
    return LuGre(own.coulomb, 0.0, own.viscous, own.stribeck_velocity, own.bristle_stiffness, 0.0)


@equation
def isotropic_friction(
    axial: Scalar, rotary: Scalar, bristles: PlaneBristle, held: tuple[Scalar, Scalar], p: Parameters
) -> tuple[Scalar, Scalar, PlaneBristle]:
    """F = sigma0 z + a2 v,  dz/dt = v - sigma0 |v| z / a0, with vectors in place of signed numbers."""
    plain = Friction(_as_lugre(p.friction.positive), _as_lugre(p.friction.negative))
    along, around, rate_axial, rate_rotary = lugre_isotropic(
        axial, rotary, bristles.bristle_axial, bristles.bristle_rotary, plain
    )
    return along, around, PlaneBristle(rate_axial, rate_rotary)


DAHL = FrictionLaw(
    name="dahl",
    summary="elastic before it slides, at one level whatever the speed",
    source="Dahl 1968",
    friction=friction,
    steady=steady_along(coulomb_level),
    uses=("coulomb", "viscous", "bristle_stiffness"),
    Contact=Bristle,
    plane={
        "isotropic": BristleLaw(
            "isotropic", PlaneBristle, Parameters, isotropic_friction, steady_in_plane(coulomb_level), "bristle_rotary"
        )
    },
)
