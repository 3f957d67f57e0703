"""A cylinder that a pump drives: no valve, the pump's speed is the flow (electro-hydraulic actuators).

The pump feeds the chamber towards which it turns; the other one drains to the tank. One pressure state, P_L = P1 - P2,
the fed chamber's pressure above the tank's. Areas may differ by `area_ratio`, A2 over its declared value.
"""

from typing import Annotated, NamedTuple

import numpy as np

from plants.drive import travel
from plants.equation import Scalar, equation, select
from plants.friction import Friction, lugre
from plants.hydraulics import Mass, end_stop_force
from plants.interface import Measurement, Plant


class State(NamedTuple):
    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    load_pressure: Annotated[float, "Pa", 1e6]
    bristle_deflection: Annotated[float, "m", 1e-4]


class Inputs(NamedTuple):
    pump_speed: Annotated[float, "rad/s"]
    disturbance_force: Annotated[float, "N"]


class Parameters(NamedTuple):
    body: Mass
    friction: Friction
    piston_area_1: Annotated[float, "m^2"]
    piston_area_2: Annotated[float, "m^2"]
    stroke: Annotated[float, "m"]
    hose_volume: Annotated[float, "m^3"]
    bulk_modulus: Annotated[float, "Pa"]
    pump_displacement: Annotated[float, "m^3/rad"]
    tank_pressure: Annotated[float, "Pa"] = 0.0
    leakage_coefficient: Annotated[float, "m^3/(s Pa)"] = 0.0
    area_ratio: Annotated[float, "1"] = 1.0
    pump_speed_limit: Annotated[float, "rad/s"] = np.inf


class Signals(NamedTuple):
    position: Annotated[float, "m"]
    velocity: Annotated[float, "m/s"]
    acceleration: Annotated[float, "m/s^2"]
    load_pressure: Annotated[float, "Pa"]
    pressure_1: Annotated[float, "Pa"]
    pressure_2: Annotated[float, "Pa"]
    bristle_deflection: Annotated[float, "m"]
    load_flow: Annotated[float, "m^3/s"]
    axial_friction: Annotated[float, "N"]
    hydraulic_power: Annotated[float, "W"]


@equation
def filling_area(velocity: Scalar, piston_area_1: Scalar, piston_area_2: Scalar, area_ratio: Scalar) -> Scalar:
    """Area (m^2) of the chamber that fills at `velocity` (m/s)."""
    return select(velocity >= 0.0, piston_area_1, area_ratio * piston_area_2)


@equation
def chamber_pressures(load_pressure: Scalar, p: Parameters) -> tuple[Scalar, Scalar]:
    """P1 and P2 (Pa): the one fed stands above the tank's pressure, the other at it."""
    return p.tank_pressure + np.maximum(load_pressure, 0.0), p.tank_pressure + np.maximum(-load_pressure, 0.0)


@equation
def derivatives(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> State:
    """Rates of the states.

    M dv/dt = P1 A1 - P2 A2 - F_friction - F_load - disturbance + end stops
    (V/beta) dP_L/dt = D n - A v - C P_L,   V = V_h + A1 L / 2, A that of the chamber which fills
    """
    friction, bristle_rate = lugre(state.velocity, state.bristle_deflection, p.friction)
    pressure_1, pressure_2 = chamber_pressures(state.load_pressure, p)
    stop = end_stop_force(state.position, state.velocity, p.stroke, p.body)
    force = pressure_1 * p.piston_area_1 - pressure_2 * p.area_ratio * p.piston_area_2
    total = force + stop - friction - p.body.load_force - inputs.disturbance_force
    area = filling_area(state.velocity, p.piston_area_1, p.piston_area_2, p.area_ratio)
    taken = area * state.velocity + p.leakage_coefficient * state.load_pressure
    flow = p.pump_displacement * inputs.pump_speed - taken
    volume = p.hose_volume + 0.5 * p.piston_area_1 * p.stroke
    return State(
        state.velocity,
        total / p.body.mass,
        flow * p.bulk_modulus / volume,
        bristle_rate,
    )


@equation
def signals(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> Signals:
    """What is worth plotting; power is the pump's, P_L D n."""
    friction, _ = lugre(state.velocity, state.bristle_deflection, p.friction)
    pressure_1, pressure_2 = chamber_pressures(state.load_pressure, p)
    flow = p.pump_displacement * inputs.pump_speed
    return Signals(
        state.position,
        state.velocity,
        derivatives(time, state, inputs, p).velocity,
        state.load_pressure,
        pressure_1,
        pressure_2,
        state.bristle_deflection,
        flow,
        friction,
        state.load_pressure * flow,
    )


@equation
def measure(state: State, p: Parameters) -> Measurement:
    """Position and both pressures."""
    pressure_1, pressure_2 = chamber_pressures(state.load_pressure, p)
    return Measurement(state.position, pressure_1, pressure_2, 0.0, 0.0)


def equilibrium(p: Parameters, surface_speed: float) -> tuple[State, Inputs]:
    """At rest in mid-stroke, the load held by the oil and the leakage by the pump."""
    tank = p.tank_pressure * (p.piston_area_1 - p.area_ratio * p.piston_area_2)
    load = p.body.load_force - tank
    pressure = load / (p.piston_area_1 if load >= 0.0 else p.area_ratio * p.piston_area_2)
    leaking = p.leakage_coefficient * pressure / p.pump_displacement
    return State(0.0, 0.0, pressure, 0.0), Inputs(leaking, 0.0)


def pump_speed_limit(p: Parameters) -> float:
    """Limit of the pump's speed (rad/s)."""
    return p.pump_speed_limit


PUMP_CYLINDER = Plant(
    name="pump_cylinder",
    summary="hydraulic cylinder with LuGre friction, fed by a pump without a valve",
    State=State,
    Inputs=Inputs,
    Parameters=Parameters,
    Signals=Signals,
    derivatives=derivatives,
    signals=signals,
    measure=measure,
    equilibrium=equilibrium,
    command_limit=pump_speed_limit,
    travel=travel,
    command="pump_speed",
    balances={"force": "velocity", "flow": "load_pressure"},
)
