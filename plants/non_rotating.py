"""The hydraulic actuator of thesis 3.2: four states and the valve's spool."""

from typing import Annotated, NamedTuple

import numpy as np

from plants import hydraulics as hyd
from plants.equation import Scalar, equation
from plants.friction import Friction, lugre
from plants.hydraulics import Hydraulics, Mass
from plants.interface import Measurement, Plant


class State(NamedTuple):
    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    load_pressure: Annotated[float, "Pa", 1e6]
    bristle_deflection: Annotated[float, "m", 1e-4]
    spool_position: Annotated[float, "m", 1e-4]


class Inputs(NamedTuple):
    valve_voltage: Annotated[float, "V"]
    disturbance_force: Annotated[float, "N"]


class Parameters(NamedTuple):
    hydraulics: Hydraulics
    body: Mass
    friction: Friction


class Signals(NamedTuple):
    position: Annotated[float, "m"]
    velocity: Annotated[float, "m/s"]
    acceleration: Annotated[float, "m/s^2"]
    load_pressure: Annotated[float, "Pa"]
    pressure_1: Annotated[float, "Pa"]
    pressure_2: Annotated[float, "Pa"]
    spool_position: Annotated[float, "m"]
    bristle_deflection: Annotated[float, "m"]
    load_flow: Annotated[float, "m^3/s"]
    axial_friction: Annotated[float, "N"]
    hydraulic_power: Annotated[float, "W"]
    supply_power: Annotated[float, "W"]
    total_power: Annotated[float, "W"]


@equation
def derivatives(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> State:
    """Rates of the states. Thesis (3.35) to (3.38) with the valve of 3.2.1."""
    h = p.hydraulics
    friction, bristle_rate = lugre(state.velocity, state.bristle_deflection, p.friction)
    flow = hyd.load_flow(state.spool_position, state.load_pressure, h)
    return State(
        state.velocity,
        hyd.piston_acceleration(
            state.position, state.velocity, state.load_pressure, friction, inputs.disturbance_force, h, p.body
        ),
        hyd.load_pressure_rate(flow, state.velocity, state.load_pressure, h),
        bristle_rate,
        hyd.spool_rate(state.spool_position, inputs.valve_voltage, h),
    )


@equation
def signals(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> Signals:
    """What is worth plotting. Power: P_L Q_L (thesis 4.16, without the oil's compression) and P_s |Q_L|;
    total: hydraulic alone.
    """
    h = p.hydraulics
    friction, _ = lugre(state.velocity, state.bristle_deflection, p.friction)
    flow = hyd.load_flow(state.spool_position, state.load_pressure, h)
    pressure_1, pressure_2 = hyd.chamber_pressures(state.load_pressure, h)
    return Signals(
        state.position,
        state.velocity,
        derivatives(time, state, inputs, p).velocity,
        state.load_pressure,
        pressure_1,
        pressure_2,
        state.spool_position,
        state.bristle_deflection,
        flow,
        friction,
        state.load_pressure * flow,
        h.supply_pressure * np.abs(flow),
        state.load_pressure * flow,
    )


@equation
def measure(state: State, p: Parameters) -> Measurement:
    """Position and both pressures; the rod does not rotate."""
    pressure_1, pressure_2 = hyd.chamber_pressures(state.load_pressure, p.hydraulics)
    return Measurement(state.position, pressure_1, pressure_2, 0.0, 0.0)


def holding_load_pressure(h: Hydraulics, body: Mass) -> float:
    """P_L (Pa) that balances the constant load, for equal areas; held by a closed valve if no oil leaks."""
    return float(body.load_force / hyd.piston_area(h))


def equilibrium(p: Parameters, surface_speed: float) -> tuple[State, Inputs]:
    """At rest in mid-stroke with the valve closed; this plant does not rotate."""
    return State(0.0, 0.0, holding_load_pressure(p.hydraulics, p.body), 0.0, 0.0), Inputs(0.0, 0.0)


def voltage_limit(p: Parameters) -> float:
    """Limit of the valve amplifier (V)."""
    return p.hydraulics.voltage_limit


def travel(p: Parameters) -> float:
    """Distance (m) between the end stops, if they are modelled."""
    return p.hydraulics.stroke if p.body.end_stop_stiffness else np.inf


NON_ROTATING = Plant(
    name="non_rotating",
    summary="hydraulic cylinder with servo valve and LuGre friction (thesis 3.2)",
    State=State,
    Inputs=Inputs,
    Parameters=Parameters,
    Signals=Signals,
    derivatives=derivatives,
    signals=signals,
    measure=measure,
    equilibrium=equilibrium,
    command_limit=voltage_limit,
    travel=travel,
    command="valve_voltage",
    balances={"force": "velocity", "flow": "load_pressure", "valve": "spool_position"},
)
