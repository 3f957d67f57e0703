"""Effects on the flow of oil: valve, supply, leakage, the oil itself, areas; and the command that comes late."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.effects.interface import COMMAND, Effect, Moment, Number, Scales
from plants.equation import Scalar, changed, equation, select
from plants.hydraulics import Hydraulics, edge_flow, valve_opening
from plants.laws.interface import Nothing

ATMOSPHERE = 101325.0
"""Pa. Pressures of a record are relative to it."""

SHORTEST_DELAY = 1e-6
"""s. Keeps 0/0 out of a command that does not come late."""

SUPPLY_PRESSURE, PISTON_AREA_2 = map(Hydraulics._fields.index, ("supply_pressure", "piston_area_2"))


def spool(scales: Scales) -> float:
    """m."""
    return scales.spool


VALVE_DEADBAND = Effect(
    name="valve_deadband",
    balance="flow",
    words="the spool has to move by its overlap before oil flows",
    source="Merritt 1967",
    numbers={"valve_overlap": Number(0.0, 0.33, 0.0033, spool)},
    needs=(COMMAND,),
)


def flow_by_pressure(scales: Scales) -> float:
    """m^3/(s Pa)."""
    return scales.flow / scales.pressure


INTERNAL_LEAKAGE = Effect(
    name="internal_leakage",
    balance="flow",
    words="oil leaks from one chamber into the other",
    source="Merritt 1967",
    numbers={"leakage_coefficient": Number(0.0, 50.0, 0.005, flow_by_pressure)},
    needs=("pressure_1",),
)


# --- supply ---------------------------------------------------------------------------------------------------


class Droop(NamedTuple):
    """Fall of the supply pressure a flow."""

    droop_resistance: Annotated[float, "Pa s/m^3"] = 0.0


@equation
def drooped(h: Hydraulics, moment: Moment, memory: Nothing, p: Any, own: Droop) -> Hydraulics:
    """P_s <- P_s - R |Q|, Q (m^3/s) the pump's flow at the declared supply pressure.

    A supply line, or a pump at its limit. Looks like flow that saturates with speed; a smaller gain of the valve looks
    alike where speeds vary little.
    """
    opening = valve_opening(moment.spool_position, h)
    fed = select(opening >= 0.0, moment.pressure_1, moment.pressure_2)
    flow = edge_flow(np.abs(opening), h.supply_pressure - fed, h)
    return changed(h, SUPPLY_PRESSURE, h.supply_pressure - own.droop_resistance * flow)


def pressure_by_flow(scales: Scales) -> float:
    """Pa s/m^3."""
    return scales.pressure / scales.flow


SUPPLY_DROOP = Effect(
    name="supply_droop",
    balance="flow",
    words="the supply pressure falls when much oil is taken",
    source="Merritt 1967",
    numbers={"droop_resistance": Number(0.0, 2.0, 0.002, pressure_by_flow)},
    needs=(COMMAND,),
    Own=Droop,
    parameters={"hydraulics": drooped},
)


# --- oil ------------------------------------------------------------------------------------------------------


class Air(NamedTuple):
    """Volume of air at atmospheric pressure, as a share of the oil's."""

    air_fraction: Annotated[float, "1"] = 0.0


@equation
def stiffness(pressure: Scalar, bulk_modulus: Scalar, air_fraction: Scalar) -> Scalar:
    """beta_eff / beta of oil with air: 1/beta_eff = 1/beta + alpha P_atm / P_abs^2 (isothermal).

    Entrained air (Merritt 1967). Looks like oil that is soft at low pressure and stiff at high.
    """
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


# --- areas ----------------------------------------------------------------------------------------------------


class Areas(NamedTuple):
    """The second chamber's piston area over its declared value."""

    area_ratio: Annotated[float, "1"] = 1.0


@equation
def unequal(h: Hydraulics, moment: Moment, memory: Nothing, p: Any, own: Areas) -> Hydraulics:
    """A_2 <- r A_2: conservation of volume, and of force."""
    return changed(h, PISTON_AREA_2, h.piston_area_2 * own.area_ratio)


UNEQUAL_AREAS = Effect(
    name="unequal_areas",
    balance="flow",
    words="the second chamber's piston area is not the declared one",
    source="conservation of volume",
    numbers={"area_ratio": Number(0.2, 2.0, 0.05)},
    Own=Areas,
    parameters={"hydraulics": unequal},
)


# --- command --------------------------------------------------------------------------------------------------


class Delay(NamedTuple):
    """By how much the command comes late."""

    command_delay: Annotated[float, "s"] = 0.0


class Delayed(NamedTuple):
    """The command as it arrives, in its unit."""

    delayed_command: Annotated[float, "1", 1.0] = 0.0


@equation
def late(command: Scalar, moment: Moment, memory: Delayed, p: Any, own: Delay) -> Scalar:
    """The command as it arrives."""
    return select(own.command_delay > 0.0, memory.delayed_command, command)


@equation
def arriving(slip: Scalar, command: Scalar, moment: Moment, memory: Delayed, p: Any, own: Delay) -> Delayed:
    """d u_d/dt = (u - u_d)/T: a lag of first order in the place of the delay T."""
    rate = (command - memory.delayed_command) / np.maximum(own.command_delay, SHORTEST_DELAY)
    return Delayed(select(own.command_delay > 0.0, rate, 0.0))


COMMAND_DELAY = Effect(
    name="command_delay",
    balance="valve",
    words="the valve gets its command late",
    source="converters and networks",
    numbers={"command_delay": Number(0.0, 0.1, 0.001)},
    needs=(COMMAND,),
    Own=Delay,
    Memory=Delayed,
    inputs={COMMAND: late},
    remember=arriving,
    at_rest=Delayed,
)
