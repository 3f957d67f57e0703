"""Effects on what the chambers hold, and on what pushes at their fluid: air, volumes, areas."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.effects.interface import FROZEN_VOLUMES, Effect, Moment, Number, stroke_share
from plants.equation import Scalar, changed, equation, when
from plants.hydraulics import Cylinder, Hydraulics, chamber_volumes, oil_volumes
from plants.laws.interface import Nothing
from plants.pneumatics import Pneumatics

ATMOSPHERE = 101325.0
"""Pa. Pressures of a record are relative to it."""

AREA_1, AREA_2 = map(Hydraulics._fields.index, ("piston_area_1", "piston_area_2"))
AREA_1_OF_AIR, AREA_2_OF_AIR = map(Pneumatics._fields.index, ("piston_area_1", "piston_area_2"))


class Air(NamedTuple):
    """Volume of air at atmospheric pressure, as a share of the oil's."""

    air_fraction: Annotated[float, "1"] = 0.0


@equation
def stiffness(pressure: Scalar, bulk_modulus: Scalar, air_fraction: Scalar) -> Scalar:
    """beta_eff / beta of oil with air: 1/beta_eff = 1/beta + alpha P_atm / P_abs^2 (isothermal).

    Entrained air (Merritt 1967). Looks like oil that is soft at low pressure and stiff at high.
    """
    return when(air_fraction != 0.0, _stiffness, 1.0, pressure, bulk_modulus, air_fraction)


@equation
def _stiffness(pressure: Scalar, bulk_modulus: Scalar, air_fraction: Scalar) -> Scalar:
    absolute = np.maximum(pressure, 0.0) + ATMOSPHERE
    return 1.0 / (1.0 + bulk_modulus * air_fraction * ATMOSPHERE / absolute**2)


@equation
def softer_1(rate: Scalar, moment: Moment, memory: Nothing, p: Any, own: Air) -> Scalar:
    """dP_1/dt (Pa/s) in softer oil."""
    return rate * stiffness(moment.pressure_1, p.hydraulics.bulk_modulus, own.air_fraction)


@equation
def softer_2(rate: Scalar, moment: Moment, memory: Nothing, p: Any, own: Air) -> Scalar:
    """dP_2/dt (Pa/s) in softer oil."""
    return rate * stiffness(moment.pressure_2, p.hydraulics.bulk_modulus, own.air_fraction)


@equation
def softer(rate: Scalar, moment: Moment, memory: Nothing, p: Any, own: Air) -> Scalar:
    """dP_L/dt (Pa/s): the mean of both chambers, which take up the same flow."""
    beta, air = p.hydraulics.bulk_modulus, own.air_fraction
    return rate * 0.5 * (stiffness(moment.pressure_1, beta, air) + stiffness(moment.pressure_2, beta, air))


ENTRAINED_AIR = Effect(
    name="entrained_air",
    balance="flow",
    words="air makes the oil soft at low pressure",
    source="Merritt 1967",
    numbers={"air_fraction": Number(0.0, 0.2, 0.001)},
    needs=("pressure_1", "pressure_2"),
    acts_on=("pressure_1", "pressure_2"),
    requires=("hydraulics", "pressure_1", "pressure_2"),
    Own=Air,
    rates={"pressure_1": softer_1, "pressure_2": softer_2, "load_pressure": softer},
)


# --- volumes --------------------------------------------------------------------------------------------------


class Volumes(NamedTuple):
    """How much the chambers' volumes change with the position: 0 not at all, as declared, 1 by what is swept."""

    volume_share: Annotated[float, "1"] = 0.0


@equation
def followed_1(rate: Scalar, moment: Moment, memory: Nothing, p: Any, own: Volumes) -> Scalar:
    """dP_1/dt <- dP_1/dt V_1(0) / V_1(s x): the volume follows a share s of the position x (m) from mid-stroke.

    Merritt 1967. Looks like oil that is stiff at one end and soft at the other; air makes it soft at low pressure.
    """
    way = own.volume_share * moment.position
    return rate * when(own.volume_share != 0.0, _stiffer_1, 1.0, way, p.hydraulics, p.cylinder)


@equation
def _stiffer_1(way: Scalar, h: Hydraulics, c: Cylinder) -> Scalar:
    return oil_volumes(0.0, h, c)[0] / oil_volumes(way, h, c)[0]


@equation
def followed_2(rate: Scalar, moment: Moment, memory: Nothing, p: Any, own: Volumes) -> Scalar:
    """The same of chamber 2."""
    way = own.volume_share * moment.position
    return rate * when(own.volume_share != 0.0, _stiffer_2, 1.0, way, p.hydraulics, p.cylinder)


@equation
def _stiffer_2(way: Scalar, h: Hydraulics, c: Cylinder) -> Scalar:
    return oil_volumes(0.0, h, c)[1] / oil_volumes(way, h, c)[1]


@equation
def followed(rate: Scalar, moment: Moment, memory: Nothing, p: Any, own: Volumes) -> Scalar:
    """dP_L/dt <- dP_L/dt (V_1(0)/V_1 + V_2(0)/V_2) / 2: both chambers take up the same flow."""
    way = own.volume_share * moment.position
    return rate * when(own.volume_share != 0.0, _stiffer, 1.0, way, p.hydraulics)


@equation
def _stiffer(way: Scalar, h: Hydraulics) -> Scalar:
    still_1, still_2 = chamber_volumes(0.0, h.hose_volume, h.hose_volume, h)
    moved_1, moved_2 = chamber_volumes(way, h.hose_volume, h.hose_volume, h)
    return 0.5 * (still_1 / moved_1 + still_2 / moved_2)


POSITION_DEPENDENT_VOLUME = Effect(
    name="position_dependent_volume",
    balance="flow",
    words="the chambers' volumes change with the position",
    source="Merritt 1967",
    numbers={"volume_share": Number(0.0, 2.0, 0.2)},
    needs=("position", "pressure_1", "pressure_2"),
    requires=("hydraulics", FROZEN_VOLUMES),
    Own=Volumes,
    rates={"pressure_1": followed_1, "pressure_2": followed_2, "load_pressure": followed},
)


# --- areas ----------------------------------------------------------------------------------------------------


class Areas(NamedTuple):
    """The second chamber's piston area over its declared value."""

    area_ratio: Annotated[float, "1"] = 1.0


@equation
def unequal(h: Hydraulics, moment: Moment, memory: Nothing, p: Any, own: Areas) -> Hydraulics:
    """A_2 <- r A_2: conservation of volume, and of force."""
    return changed(h, AREA_2, h.piston_area_2 * own.area_ratio)


UNEQUAL_AREAS = Effect(
    name="unequal_areas",
    balance="flow",
    words="the second chamber's piston area is not the declared one",
    source="conservation of volume",
    numbers={"area_ratio": Number(0.2, 2.0, 0.05)},
    Own=Areas,
    parameters={"hydraulics": unequal},
)


class Leverage(NamedTuple):
    """By which share of themselves both areas are larger at the positive end of the stroke, smaller at the other."""

    area_gradient: Annotated[float, "1"] = 0.0


@equation
def levered_oil(h: Hydraulics, moment: Moment, memory: Nothing, p: Any, own: Leverage) -> Hydraulics:
    """A <- A (1 + g xi), xi = 2 x / L, of both chambers, in flow and force: power is conserved.

    A linkage between piston and load, whose leverage changes along the stroke. Looks like a flow gain that changes
    along the stroke; friction along the stroke shows in the force alone.
    """
    share = 1.0 + own.area_gradient * stroke_share(moment)
    return changed(changed(h, AREA_1, h.piston_area_1 * share), AREA_2, h.piston_area_2 * share)


@equation
def levered_air(air: Pneumatics, moment: Moment, memory: Nothing, p: Any, own: Leverage) -> Pneumatics:
    """The same of a cylinder that air drives."""
    share = 1.0 + own.area_gradient * stroke_share(moment)
    return changed(changed(air, AREA_1_OF_AIR, air.piston_area_1 * share), AREA_2_OF_AIR, air.piston_area_2 * share)


POSITION_DEPENDENT_AREA = Effect(
    name="position_dependent_area",
    balance="flow",
    words="the piston's effective area changes along the stroke, as of a linkage",
    source="leverage of a linkage",
    numbers={"area_gradient": Number(-0.5, 0.5, 0.01)},
    needs=("position", "pressure_1"),
    Own=Leverage,
    parameters={"hydraulics": levered_oil, "pneumatics": levered_air},
)
