"""A cylinder that a pump drives: no valve, the pump's speed is the flow (electro-hydraulic actuators).

The pump feeds the chamber towards which it turns; the other one drains to the tank. One pressure state, P_L = P1 - P2,
the fed chamber's pressure above the tank's. Areas may differ, and by `area_ratio`, A2 over its declared value.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.actuators.interface import Actuator, own_stroke
from plants.equation import Scalar, equation, select
from plants.hydraulics import FORCE
from plants.interface import Balance


class State(NamedTuple):
    load_pressure: Annotated[float, "Pa", 1e6]


class Inputs(NamedTuple):
    pump_speed: Annotated[float, "rad/s"]


class Parameters(NamedTuple):
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
    load_pressure: Annotated[float, "Pa"]
    pressure_1: Annotated[float, "Pa"]
    pressure_2: Annotated[float, "Pa"]
    load_flow: Annotated[float, "m^3/s"]
    hydraulic_power: Annotated[float, "W"]


@equation
def filling_area(velocity: Scalar, piston_area_1: Scalar, piston_area_2: Scalar, area_ratio: Scalar) -> Scalar:
    """Area (m^2) of the chamber that fills at `velocity` (m/s)."""
    return select(velocity >= 0.0, piston_area_1, area_ratio * piston_area_2)


@equation
def pressures(state: Any, p: Any) -> tuple[Scalar, Scalar]:
    """P1 and P2 (Pa): the one fed stands above the tank's pressure, the other at it."""
    fed = state.load_pressure
    return p.tank_pressure + np.maximum(fed, 0.0), p.tank_pressure + np.maximum(-fed, 0.0)


@equation
def oil_volume(p: Any) -> Scalar:
    """V = V_h + A1 L / 2 (m^3), at mid-stroke whatever the position."""
    return p.hose_volume + 0.5 * p.piston_area_1 * p.stroke


def load_pressure_capacity(p: Any) -> tuple[float]:
    """V / beta (m^3/Pa): the flow that a rate of the load pressure takes."""
    return (oil_volume(p) / p.bulk_modulus,)


@equation
def force(state: Any, inputs: Any, p: Any) -> Scalar:
    """P1 A1 - P2 A2 (N)."""
    pressure_1, pressure_2 = pressures(state, p)
    return pressure_1 * p.piston_area_1 - pressure_2 * p.area_ratio * p.piston_area_2


@equation
def rates(state: Any, inputs: Any, p: Any) -> tuple[Scalar]:
    """dP_L/dt (Pa/s): (V/beta) dP_L/dt = D n - A v - C P_L, V = V_h + A1 L / 2, A that of the chamber which fills."""
    area = filling_area(state.velocity, p.piston_area_1, p.piston_area_2, p.area_ratio)
    taken = area * state.velocity + p.leakage_coefficient * state.load_pressure
    flow = p.pump_displacement * inputs.pump_speed - taken
    return (flow * p.bulk_modulus / oil_volume(p),)


@equation
def signals(state: Any, inputs: Any, p: Any) -> tuple[Scalar, ...]:
    """Power is the pump's, P_L D n."""
    pressure_1, pressure_2 = pressures(state, p)
    flow = p.pump_displacement * inputs.pump_speed
    return state.load_pressure, pressure_1, pressure_2, flow, state.load_pressure * flow


def equilibrium(p: Any) -> tuple[tuple[float], tuple[float]]:
    """The load held by the oil, and the leakage by the pump."""
    tank = p.tank_pressure * (p.piston_area_1 - p.area_ratio * p.piston_area_2)
    load = p.body.load_force - tank
    pressure = load / (p.piston_area_1 if load >= 0.0 else p.area_ratio * p.piston_area_2)
    return (pressure,), (p.leakage_coefficient * pressure / p.pump_displacement,)


def pump_speed_limit(p: Any) -> float:
    """Limit of the pump's speed (rad/s)."""
    return float(p.pump_speed_limit)


PUMP = Actuator(
    name="pump_cylinder",
    summary="hydraulic cylinder, fed by a pump without a valve",
    State=State,
    Inputs=Inputs,
    Parameters=Parameters,
    Signals=Signals,
    force=force,
    rates=rates,
    signals=signals,
    pressures=pressures,
    stroke=own_stroke,
    equilibrium=equilibrium,
    command_limit=pump_speed_limit,
    balances={"force": FORCE, "flow": Balance(("load_pressure",), "m^3/s", load_pressure_capacity)},
)
