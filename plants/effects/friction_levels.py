"""Effects on the levels of a contact's friction: of either direction, along the stroke, with pressure.

Each takes the contact's LuGre set for both directions and gives another; whatever law the plant has, it takes that.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.effects.interface import FREE, Effect, Moment, Number, stroke_share
from plants.effects.scales import drive_by_pressure
from plants.equation import Scalar, equation
from plants.friction import Friction, LuGre
from plants.laws.interface import Nothing

LEAST_FRICTION = 0.05
"""Share of its friction that a contact keeps along the stroke. With none at all LuGre's bristle would be renewed at
once, and no solver could follow it."""


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
    xi = stroke_share(moment)
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


PRESSURE_DEPENDENT_FRICTION = Effect(
    name="pressure_dependent_friction",
    balance="force",
    words="friction grows with the load pressure, as of a seal that is pressed by it",
    source="Bonchis, Corke and Rye 1999",
    numbers={"friction_per_pressure": Number(0.0, 0.5, 0.02, drive_by_pressure)},
    needs=("pressure_1",),
    circular=True,
    requires=("pressure_1", "pressure_2"),
    Own=ByPressure,
    parameters={"friction": pressed},
)
"""Seals take some per cent of what drives a cylinder, at worst some tens [assumed]."""
