"""How the friction of a rod that slides and turns depends on both motions: three bristle laws, one interface."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from plants.anisotropic import Film, Guide, lugre_anisotropic, steady_anisotropic
from plants.equation import Scalar, equation
from plants.friction import Friction, LuGre, lugre_helical, lugre_isotropic, stribeck_level
from plants.laws.steady import steady_in_plane
from plants.motor import Motor


class Parameters(NamedTuple):
    """Of a rod whose friction is the same along and around it, and what turns it."""

    friction: Friction
    motor: Motor


class AnisotropicParameters(NamedTuple):
    """Of one whose friction differs along and around; a `rotary` value that is not given is the axial one."""

    friction: Friction
    rotary: LuGre
    film: Film
    guide: Guide
    motor: Motor


class HelicalBristle(NamedTuple):
    bristle_deflection: Annotated[float, "m", 1e-4]


class PlaneBristle(NamedTuple):
    bristle_axial: Annotated[float, "m", 1e-4]
    bristle_rotary: Annotated[float, "m", 1e-4]


class GuidedBristle(NamedTuple):
    """A plane bristle, and that of the guide, which slides but does not turn."""

    bristle_axial: Annotated[float, "m", 1e-4]
    bristle_rotary: Annotated[float, "m", 1e-3]
    bristle_guide: Annotated[float, "m", 1e-4]


@dataclass(frozen=True, eq=False)
class BristleLaw:
    """A law by name, with the classes of its bristles and of those parameters of a machine that it is about.

    friction(axial, rotary, bristles, held, parameters) -> (axial friction, rotary friction, rates of the bristles)
    steady(axial, rotary, parameters) -> (axial friction, rotary friction)     after a long time at constant speeds
    turning                                            the bristle that rotation alone bends; "" where there is none

    Speeds in m/s, at the surface; friction in N; rates in m/s. `held` (N, along and around) is what
    `plants.laws.interface` says of it; a law with bristles ignores it.
    """

    name: str
    Bristles: type[NamedTuple]
    Parameters: type[NamedTuple]
    friction: Callable[..., tuple[Scalar, Scalar, Any]]
    steady: Callable[..., tuple[Scalar, Scalar]]
    turning: str

    @property
    def at_rest(self) -> NamedTuple:
        """Bristles that are not bent."""
        return self.Bristles._make(0.0 for _ in self.Bristles._fields)

    def around(self, deflection: float) -> NamedTuple:
        """Bristles that are bent (m) around the rod only."""
        return self.at_rest._replace(**{self.turning: deflection})

    def steady_rotation(self, parameters: NamedTuple, surface_speed: float) -> tuple[NamedTuple, float]:
        """Bristles and rotary friction (N) of a rod that turns at `surface_speed` (m/s) without moving along.

        The rate of a bristle is linear in its deflection: 0 at rate(0) / (rate(0) - rate(1)).
        """
        if surface_speed == 0.0 or not self.turning:
            return self.at_rest, float(self.steady(0.0, surface_speed, parameters)[1]) if surface_speed else 0.0
        unbent, bent = (
            getattr(self.friction(0.0, surface_speed, self.around(bend), (0.0, 0.0), parameters)[2], self.turning)
            for bend in (0.0, 1.0)
        )
        _, friction = self.steady(0.0, surface_speed, parameters)
        return self.around(float(unbent / (unbent - bent))), float(friction)


# --- one bristle along the helix -----------------------------------------------------------------------------


@equation
def helical_friction(
    axial: Scalar, rotary: Scalar, bristles: HelicalBristle, held: tuple[Scalar, Scalar], p: Parameters
) -> tuple[Scalar, Scalar, HelicalBristle]:
    """See `lugre_helical`."""
    along, around, rate = lugre_helical(axial, rotary, bristles.bristle_deflection, p.friction)
    return along, around, HelicalBristle(rate)


STEADY = steady_in_plane(stribeck_level)
"""Of both laws with one level."""

HELICAL = BristleLaw("helical", HelicalBristle, Parameters, helical_friction, STEADY, "bristle_deflection")


# --- a bristle with a component along and one around ---------------------------------------------------------


@equation
def isotropic_friction(
    axial: Scalar, rotary: Scalar, bristles: PlaneBristle, held: tuple[Scalar, Scalar], p: Parameters
) -> tuple[Scalar, Scalar, PlaneBristle]:
    """See `lugre_isotropic`."""
    along, around, rate_axial, rate_rotary = lugre_isotropic(
        axial, rotary, bristles.bristle_axial, bristles.bristle_rotary, p.friction
    )
    return along, around, PlaneBristle(rate_axial, rate_rotary)


ISOTROPIC = BristleLaw("isotropic", PlaneBristle, Parameters, isotropic_friction, STEADY, "bristle_rotary")


# --- levels of their own along and around --------------------------------------------------------------------


@equation
def anisotropic_friction(
    axial: Scalar, rotary: Scalar, bristles: GuidedBristle, held: tuple[Scalar, Scalar], p: AnisotropicParameters
) -> tuple[Scalar, Scalar, GuidedBristle]:
    """See `lugre_anisotropic`."""
    along, around, rate_axial, rate_rotary, rate_guide = lugre_anisotropic(
        axial, rotary, bristles, p.friction, p.rotary, p.film, p.guide
    )
    return along, around, GuidedBristle(rate_axial, rate_rotary, rate_guide)


@equation
def steady_of_both(axial: Scalar, rotary: Scalar, p: AnisotropicParameters) -> tuple[Scalar, Scalar]:
    """See `steady_anisotropic`."""
    return steady_anisotropic(axial, rotary, p.friction, p.rotary, p.film, p.guide)


ANISOTROPIC = BristleLaw(
    "anisotropic",
    GuidedBristle,
    AnisotropicParameters,
    anisotropic_friction,
    steady_of_both,
    "bristle_rotary",
)
