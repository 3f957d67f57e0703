"""Valve and cylinder that air drives: ISO 6358's flow through an opening, and chambers that compress polytropically.

Pressures are relative to the atmosphere, as for oil and as a rig's sensors give them; the gas laws take
P + P_atm. The air has one temperature: what an exponent between 1 and 1.4 says of the heat that it exchanges.
"""

from typing import Annotated, NamedTuple, Protocol, runtime_checkable

import numpy as np

from plants.equation import Scalar, equation, select
from plants.hydraulics import chamber_volumes

GAS_CONSTANT = 287.05
"""J/(kg K), of dry air."""

NORMAL_DENSITY, NORMAL_TEMPERATURE = 1.185, 293.15
"""kg/m^3 and K: the reference of ISO 6358, at which a sonic conductance counts volume."""

LAMINAR_RATIO = 0.999
"""Ratio of the pressures beyond which flow is laminar: the ellipse has an infinite slope at 1 (Beater 2007)."""


class Pneumatics(NamedTuple):
    """Supply, valve and cylinder.

    `sonic_conductance` is that of an edge of the valve at full travel, in proportion to its opening below; an edge to
    the atmosphere has `exhaust_gain` times as much. `leakage_conductance` is that of the piston's seal, an
    `external_leakage` that of a leak to the atmosphere.
    """

    piston_area_1: Annotated[float, "m^2"]
    piston_area_2: Annotated[float, "m^2"]
    stroke: Annotated[float, "m"]
    dead_volume_1: Annotated[float, "m^3"]
    dead_volume_2: Annotated[float, "m^3"]
    supply_pressure: Annotated[float, "Pa"]
    sonic_conductance: Annotated[float, "m^3/(s Pa)"]
    critical_pressure_ratio: Annotated[float, "1"]
    valve_position_gain: Annotated[float, "m/V"]
    valve_time_constant: Annotated[float, "s"]
    spool_limit: Annotated[float, "m"]
    voltage_limit: Annotated[float, "V"]
    polytropic_exponent: Annotated[float, "1"]
    ambient_pressure: Annotated[float, "Pa"] = 101325.0
    air_temperature: Annotated[float, "K"] = NORMAL_TEMPERATURE
    exhaust_gain: Annotated[float, "1"] = 1.0
    valve_overlap: Annotated[float, "m"] = 0.0
    leakage_conductance: Annotated[float, "m^3/(s Pa)"] = 0.0
    valve_overlap_negative: Annotated[float, "m"] = 0.0
    external_leakage_1: Annotated[float, "m^3/(s Pa)"] = 0.0
    external_leakage_2: Annotated[float, "m^3/(s Pa)"] = 0.0


@runtime_checkable
class Pneumatic(Protocol):
    """Parameters of a cylinder that air drives through a valve."""

    @property
    def pneumatics(self) -> Pneumatics: ...


@equation
def flow_share(ratio: Scalar, critical: Scalar) -> Scalar:
    """psi (1): flow over that at sonic speed, at a `ratio` r <= 1 of the pressures behind and before an opening.

        psi = 1 for r <= b,  sqrt(1 - ((r - b) / (1 - b))^2) above     ISO 6358, b = `critical`

    Above `LAMINAR_RATIO` it is a line to 0 at r = 1.
    """
    beyond = np.maximum(np.minimum(ratio, LAMINAR_RATIO) - critical, 0.0) / (1.0 - critical)
    return np.sqrt(1.0 - beyond**2) * np.minimum((1.0 - ratio) / (1.0 - LAMINAR_RATIO), 1.0)


@equation
def mass_flow(conductance: Scalar, before: Scalar, behind: Scalar, p: Pneumatics) -> Scalar:
    """Mass flow (kg/s) through an opening, backwards where the pressure `behind` (Pa) is the higher. ISO 6358.

    C rho_0 sqrt(T_0 / T) P_up psi(P_down / P_up)      pressures absolute
    """
    higher = np.maximum(before, behind) + p.ambient_pressure
    lower = np.minimum(before, behind) + p.ambient_pressure
    size = conductance * normal_flow(p) * higher * flow_share(lower / higher, p.critical_pressure_ratio)
    return select(before >= behind, size, -size)


@equation
def normal_flow(p: Pneumatics) -> Scalar:
    """rho_0 sqrt(T_0 / T) (kg/m^3): the mass that a sonic conductance lets through, a volume of upstream pressure."""
    return NORMAL_DENSITY * np.sqrt(NORMAL_TEMPERATURE / p.air_temperature)


@equation
def specific_energy(p: Pneumatics) -> Scalar:
    """R T (J/kg)."""
    return GAS_CONSTANT * p.air_temperature


@equation
def air_volumes(position: Scalar, p: Pneumatics) -> tuple[Scalar, Scalar]:
    """Air (m^3) in each chamber, the rod at `position` (m) from mid-stroke."""
    return chamber_volumes(position, p.dead_volume_1, p.dead_volume_2, p)


@equation
def pressure_rate(pressure: Scalar, volume: Scalar, filling: Scalar, swept: Scalar, p: Pneumatics) -> Scalar:
    """dP/dt (Pa/s) = n / V (R T m' - P dV/dt): a chamber that `filling` (kg/s) enters and a piston sweeps (m^3/s)."""
    absolute = pressure + p.ambient_pressure
    return p.polytropic_exponent / volume * (specific_energy(p) * filling - absolute * swept)
