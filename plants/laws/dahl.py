"""Dahl's law: a contact that is elastic before it slides, and slides at one level whatever the speed."""

from typing import Any

import numpy as np

from plants.bristles import BristleLaw, Parameters, PlaneBristle
from plants.equation import Scalar, equation
from plants.friction import Friction, LuGre, blended, directed, helical_speed, lugre_isotropic
from plants.friction import dahl as dahl_contact
from plants.laws.interface import FrictionLaw
from plants.laws.lugre import Bristle


@equation
def friction(velocity: Scalar, contact: Bristle, held: Scalar, p: Any) -> tuple[Scalar, Bristle]:
    """F = sigma0 z + a2 v,  dz/dt = v - sigma0 |v| z / a0. Dahl 1968, exponent 1, with viscous friction."""
    own = directed(velocity, contact.bristle_deflection, p.friction)
    force, rate = dahl_contact(velocity, contact.bristle_deflection, own.coulomb, own.bristle_stiffness)
    return force + own.viscous * velocity, Bristle(rate)


@equation
def steady(velocity: Scalar, p: Any) -> Scalar:
    """a0 sgn(v) + a2 v (N)."""
    own = directed(velocity, velocity, p.friction)
    return own.coulomb * np.sign(velocity) + own.viscous * velocity


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


@equation
def isotropic_steady(axial: Scalar, rotary: Scalar, p: Parameters) -> tuple[Scalar, Scalar]:
    """(a0 / v_h + a2) times each speed (N)."""
    speed = helical_speed(axial, rotary)
    own = blended(axial / speed, axial / speed, p.friction)
    slope = own.coulomb / speed + own.viscous
    return slope * axial, slope * rotary


DAHL = FrictionLaw(
    name="dahl",
    summary="elastic before it slides, at one level whatever the speed",
    source="Dahl 1968",
    friction=friction,
    steady=steady,
    uses=("coulomb", "viscous", "bristle_stiffness"),
    Contact=Bristle,
    plane={
        "isotropic": BristleLaw(
            "isotropic", PlaneBristle, Parameters, isotropic_friction, isotropic_steady, "bristle_rotary"
        )
    },
)
