"""Pneumatic cylinder on a proportional directional valve of four edges.

    m'_1 = m'(P_s -> P_1) - m'(P_1 -> atmosphere) - m'(P_1 -> P_2)      mass flows of `plants.pneumatics`, and leaks
    dP_1/dt = n / V_1 (R T m'_1 - P_1 A_1 v)                            the same of chamber 2, which v makes smaller

Beater 2007; Carneiro and de Almeida 2006.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants import pneumatics as pneu
from plants.actuators.cylinder import State, pressures
from plants.actuators.interface import Actuator
from plants.actuators.load_pressure import Inputs
from plants.actuators.resting import Resting, at_rest
from plants.equation import Scalar, equation
from plants.hydraulics import FORCE, opening, spool_rate
from plants.interface import Balance
from plants.pneumatics import Pneumatic, Pneumatics, mass_flow
from plants.rising import rising


class Parameters(NamedTuple):
    pneumatics: Pneumatics


class Signals(NamedTuple):
    """`air_flow` is what the supply gives."""

    load_pressure: Annotated[float, "Pa"]
    pressure_1: Annotated[float, "Pa"]
    pressure_2: Annotated[float, "Pa"]
    spool_position: Annotated[float, "m"]
    air_flow: Annotated[float, "kg/s"]
    supply_power: Annotated[float, "W"]


@equation
def edge_flows(
    spool: Scalar, pressure_1: Scalar, pressure_2: Scalar, p: Pneumatics
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Mass flows (kg/s) from supply to 1, from 1 to the atmosphere, from supply to 2, from 2 to the atmosphere."""
    forward = p.sonic_conductance * opening(spool, p.valve_overlap, 0.0) / p.spool_limit
    backward = p.sonic_conductance * opening(-spool, p.valve_overlap_negative, 0.0) / p.spool_limit
    return (
        mass_flow(forward, p.supply_pressure, pressure_1, p),
        mass_flow(p.exhaust_gain * backward, pressure_1, 0.0, p),
        mass_flow(backward, p.supply_pressure, pressure_2, p),
        mass_flow(p.exhaust_gain * forward, pressure_2, 0.0, p),
    )


@equation
def net_flows(spool: Scalar, pressure_1: Scalar, pressure_2: Scalar, p: Any) -> tuple[Scalar, Scalar]:
    """Mass flows (kg/s) into chamber 1 and out of chamber 2, less what leaks past the piston and outside."""
    air = p.pneumatics
    from_supply_1, exhausted_1, from_supply_2, exhausted_2 = edge_flows(spool, pressure_1, pressure_2, air)
    leakage = mass_flow(air.leakage_conductance, pressure_1, pressure_2, air)
    lost_1 = mass_flow(air.external_leakage_1, pressure_1, 0.0, air)
    lost_2 = mass_flow(air.external_leakage_2, pressure_2, 0.0, air)
    return from_supply_1 - exhausted_1 - leakage - lost_1, exhausted_2 - from_supply_2 - leakage + lost_2


@equation
def force(state: Any, inputs: Any, p: Any) -> Scalar:
    """P1 A1 - P2 A2 (N); the atmosphere on the rod is in it, pressures being relative to it."""
    return state.pressure_1 * p.pneumatics.piston_area_1 - state.pressure_2 * p.pneumatics.piston_area_2


@equation
def rates(state: Any, inputs: Any, p: Any) -> tuple[Scalar, Scalar, Scalar]:
    """Of both pressures, and of the spool."""
    air = p.pneumatics
    into, out = net_flows(state.spool_position, state.pressure_1, state.pressure_2, p)
    volume_1, volume_2 = pneu.air_volumes(state.position, air)
    return (
        pneu.pressure_rate(state.pressure_1, volume_1, into, air.piston_area_1 * state.velocity, air),
        pneu.pressure_rate(state.pressure_2, volume_2, -out, -air.piston_area_2 * state.velocity, air),
        spool_rate(state.spool_position, inputs.valve_voltage, air),
    )


@equation
def signals(state: Any, inputs: Any, p: Any) -> tuple[Scalar, ...]:
    """Power of the supplied air: what compressing it at one temperature takes, m' R T ln(P_s / P_atm)."""
    air = p.pneumatics
    flows = edge_flows(state.spool_position, state.pressure_1, state.pressure_2, air)
    supplied = flows[0] + flows[2]
    compressed = np.log((air.supply_pressure + air.ambient_pressure) / air.ambient_pressure)
    return (
        state.pressure_1 - state.pressure_2,
        state.pressure_1,
        state.pressure_2,
        state.spool_position,
        supplied,
        supplied * pneu.specific_energy(air) * compressed,
    )


@equation
def stroke(p: Any) -> Scalar:
    """Distance (m) between the end stops."""
    return p.pneumatics.stroke


def voltage_limit(p: Pneumatic) -> float:
    """Limit of the valve amplifier (V)."""
    return p.pneumatics.voltage_limit


def capacities(p: Pneumatic) -> tuple[float, float]:
    """V / (n R T) (kg/Pa) of each chamber at mid-stroke: the mass that a rate of its pressure takes."""
    air = p.pneumatics
    energy = air.polytropic_exponent * float(pneu.specific_energy(air))
    volume_1, volume_2 = pneu.air_volumes(0.0, air)
    return float(volume_1) / energy, float(volume_2) / energy


def valve_time(p: Pneumatic) -> tuple[float]:
    """tau_sv (s): the way of the spool's target that a rate of the spool takes."""
    return (p.pneumatics.valve_time_constant,)


def resting_pressure(p: Pneumatics) -> float:
    """The pressure (Pa) of a chamber whose edges to supply and atmosphere are open alike: what a spool's lands leak."""
    return rising(
        lambda pressure: float(
            mass_flow(p.exhaust_gain, pressure, 0.0, p) - mass_flow(1.0, p.supply_pressure, pressure, p)
        ),
        0.0,
        p.supply_pressure,
    )


def equilibrium(p: Any) -> tuple[tuple[float, float, float], tuple[float]]:
    """At rest, the load held by the air; the mean pressure is what the lands of a closed valve leak it to."""
    air = p.pneumatics
    cylinder = Resting(air.piston_area_1, air.piston_area_2, 0.0, air.supply_pressure, air.spool_limit)
    pressure_1, pressure_2, spool = at_rest(net_flows, p, cylinder, 2.0 * resting_pressure(air))
    return (pressure_1, pressure_2, spool), (spool / air.valve_position_gain,)


PNEUMATIC = Actuator(
    name="pneumatic_cylinder",
    summary="pneumatic cylinder with proportional valve",
    State=State,
    Inputs=Inputs,
    Parameters=Parameters,
    Signals=Signals,
    force=force,
    rates=rates,
    signals=signals,
    pressures=pressures,
    stroke=stroke,
    equilibrium=equilibrium,
    command_limit=voltage_limit,
    balances={
        "force": FORCE,
        "flow": Balance(("pressure_1", "pressure_2"), "kg/s", capacities),
        "valve": Balance(("spool_position",), "m", valve_time),
    },
)
