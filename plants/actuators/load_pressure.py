"""The thesis's servo valve and cylinder in the load-pressure form: one pressure state, P_L = P1 - P2, equal areas."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants import hydraulics as hyd
from plants.actuators.interface import Actuator
from plants.equation import Scalar, equation
from plants.hydraulics import Hydraulic, Hydraulics
from plants.interface import Balance


class State(NamedTuple):
    load_pressure: Annotated[float, "Pa", 1e6]
    spool_position: Annotated[float, "m", 1e-4]


class Inputs(NamedTuple):
    valve_voltage: Annotated[float, "V"]


class Parameters(NamedTuple):
    hydraulics: Hydraulics


class Signals(NamedTuple):
    load_pressure: Annotated[float, "Pa"]
    pressure_1: Annotated[float, "Pa"]
    pressure_2: Annotated[float, "Pa"]
    spool_position: Annotated[float, "m"]
    load_flow: Annotated[float, "m^3/s"]
    hydraulic_power: Annotated[float, "W"]
    supply_power: Annotated[float, "W"]


@equation
def force(state: Any, inputs: Any, p: Any) -> Scalar:
    """P1 A1 - P2 A2 (N). Thesis (3.29)."""
    return hyd.pressure_force(state.load_pressure, p.hydraulics)


@equation
def rates(state: Any, inputs: Any, p: Any) -> tuple[Scalar, Scalar]:
    """Of load pressure and spool: thesis (3.37) and the valve of 3.2.1."""
    h = p.hydraulics
    flow = hyd.load_flow(state.spool_position, state.load_pressure, h)
    return (
        hyd.load_pressure_rate(flow, state.velocity, state.load_pressure, h),
        hyd.spool_rate(state.spool_position, inputs.valve_voltage, h),
    )


@equation
def signals(state: Any, inputs: Any, p: Any) -> tuple[Scalar, ...]:
    """Power: P_L Q_L (thesis 4.16, without the oil's compression), and P_s |Q_L| from the pump."""
    h = p.hydraulics
    flow = hyd.load_flow(state.spool_position, state.load_pressure, h)
    pressure_1, pressure_2 = hyd.chamber_pressures(state.load_pressure, h)
    return (
        state.load_pressure,
        pressure_1,
        pressure_2,
        state.spool_position,
        flow,
        state.load_pressure * flow,
        h.supply_pressure * np.abs(flow),
    )


@equation
def pressures(state: Any, p: Any) -> tuple[Scalar, Scalar]:
    """P1 and P2 (Pa)."""
    return hyd.chamber_pressures(state.load_pressure, p.hydraulics)


@equation
def stroke(p: Any) -> Scalar:
    """Distance (m) between the end stops."""
    return p.hydraulics.stroke


def equilibrium(p: Any) -> tuple[tuple[float, float], tuple[float]]:
    """P_L (Pa) that balances the load, P1 A1 - P2 A2 = F_load; the spool makes good what leaks, Q_L = C P_L.

    A load beyond what the supply holds gets all of it.
    """
    h = p.hydraulics
    by_areas = 0.5 * (h.supply_pressure + h.tank_pressure) * (h.piston_area_1 - h.piston_area_2)
    most = h.supply_pressure - h.tank_pressure
    pressure = min(max(float((p.body.load_force - by_areas) / hyd.piston_area(h)), -most), most)
    leaking = float(hyd.load_leakage(pressure, h))
    if leaking == 0.0:
        return (pressure, 0.0), (0.0,)
    way, overlap = (1.0, h.valve_overlap) if leaking > 0.0 else (-1.0, h.valve_overlap_negative)
    flow = float(hyd.load_flow(way * (overlap + 1.0), pressure, h))  # of an opening of 1 m
    opening = abs(leaking / flow) if flow else h.spool_limit
    spool = min(max(way * (overlap + opening), -h.spool_limit), h.spool_limit)
    return (pressure, spool), (spool / h.valve_position_gain,)


def voltage_limit(p: Hydraulic) -> float:
    """Limit of the valve amplifier (V)."""
    return p.hydraulics.voltage_limit


def capacity(p: Hydraulic) -> tuple[float]:
    """V_t / (4 beta) (m^3/Pa): the flow that a rate of the load pressure takes."""
    return (hyd.oil_volume(p.hydraulics) / (4.0 * p.hydraulics.bulk_modulus),)


LOAD_PRESSURE = Actuator(
    name="non_rotating",
    summary="hydraulic cylinder with servo valve (thesis 3.2)",
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
    frozen_volumes=True,
    balances={"force": hyd.FORCE, "flow": Balance(("load_pressure",), "m^3/s", capacity), "valve": hyd.VALVE},
)
