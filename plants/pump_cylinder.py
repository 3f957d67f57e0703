"""A cylinder that a pump drives: no valve, the pump's speed is the flow (electro-hydraulic actuators).

The pump feeds the chamber towards which it turns; the other one drains to the tank. One pressure state, P_L = P1 - P2,
the fed chamber's pressure above the tank's. Areas may differ by `area_ratio`, A2 over its declared value.
"""

import functools
from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.drive import travel
from plants.equation import Scalar, equation, select
from plants.friction import Friction
from plants.hydraulics import FORCE, Mass, end_stop_force
from plants.interface import Balance, Measurement, Plant
from plants.laws.interface import FrictionLaw, at_rest, fitted, friction_of
from plants.laws.lugre import LUGRE, Bristle, named


class State(NamedTuple):
    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    load_pressure: Annotated[float, "Pa", 1e6]
    contact: Bristle


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
    contact: Bristle
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
def oil_volume(p: Any) -> Scalar:
    """V = V_h + A1 L / 2 (m^3), at mid-stroke whatever the position."""
    return p.hose_volume + 0.5 * p.piston_area_1 * p.stroke


def load_pressure_capacity(p: Parameters) -> tuple[float]:
    """V / beta (m^3/Pa): the flow that a rate of the load pressure takes."""
    return (oil_volume(p) / p.bulk_modulus,)


@equation
def sum_of_forces(state: Any, friction: Scalar, inputs: Inputs, p: Any) -> Scalar:
    """Force (N) on the mass: P1 A1 - P2 A2 + end stops - F_friction - F_load - disturbance."""
    pressure_1, pressure_2 = chamber_pressures(state.load_pressure, p)
    stop = end_stop_force(state.position, state.velocity, p.stroke, p.body)
    force = pressure_1 * p.piston_area_1 - pressure_2 * p.area_ratio * p.piston_area_2
    return force + stop - friction - p.body.load_force - inputs.disturbance_force


@equation
def free_acceleration(state: Any, inputs: Inputs, p: Any) -> Scalar:
    """dv/dt (m/s^2) without friction."""
    return sum_of_forces(state, 0.0, inputs, p) / p.body.mass


@equation
def load_pressure_rate(state: Any, inputs: Inputs, p: Any) -> Scalar:
    """dP_L/dt (Pa/s): (V/beta) dP_L/dt = D n - A v - C P_L, V = V_h + A1 L / 2, A that of the chamber which fills."""
    area = filling_area(state.velocity, p.piston_area_1, p.piston_area_2, p.area_ratio)
    taken = area * state.velocity + p.leakage_coefficient * state.load_pressure
    flow = p.pump_displacement * inputs.pump_speed - taken
    return flow * p.bulk_modulus / oil_volume(p)


@equation
def measure(state: State, p: Parameters) -> Measurement:
    """Position and both pressures."""
    pressure_1, pressure_2 = chamber_pressures(state.load_pressure, p)
    return Measurement(state.position, pressure_1, pressure_2, 0.0, 0.0)


def pump_speed_limit(p: Parameters) -> float:
    """Limit of the pump's speed (rad/s)."""
    return p.pump_speed_limit


@functools.cache
def pumped(law: FrictionLaw) -> Plant:
    """The cylinder with a friction law."""
    state_class, parameters_class, signals_class = fitted(law, State, Parameters, Signals)
    friction, unbent = friction_of(law, free_acceleration), at_rest(law)

    @equation
    def derivatives(time: Scalar, state: Any, inputs: Inputs, p: Any) -> Any:
        """Rates of the states."""
        opposed, rates = friction(state, inputs, p)
        total = sum_of_forces(state, opposed, inputs, p)
        return state_class(state.velocity, total / p.body.mass, load_pressure_rate(state, inputs, p), rates)

    @equation
    def signals(time: Scalar, state: Any, inputs: Inputs, p: Any) -> Any:
        """What is worth plotting; power is the pump's, P_L D n."""
        opposed, _ = friction(state, inputs, p)
        pressure_1, pressure_2 = chamber_pressures(state.load_pressure, p)
        flow = p.pump_displacement * inputs.pump_speed
        return signals_class(
            state.position,
            state.velocity,
            derivatives(time, state, inputs, p).velocity,
            state.load_pressure,
            pressure_1,
            pressure_2,
            state.contact,
            flow,
            opposed,
            state.load_pressure * flow,
        )

    def equilibrium(p: Parameters, surface_speed: float) -> tuple[NamedTuple, Inputs]:
        """At rest in mid-stroke, the load held by the oil and the leakage by the pump."""
        tank = p.tank_pressure * (p.piston_area_1 - p.area_ratio * p.piston_area_2)
        load = p.body.load_force - tank
        pressure = load / (p.piston_area_1 if load >= 0.0 else p.area_ratio * p.piston_area_2)
        leaking = p.leakage_coefficient * pressure / p.pump_displacement
        return state_class(0.0, 0.0, pressure, unbent), Inputs(leaking, 0.0)

    return Plant(
        name=named("pump_cylinder", law),
        summary="hydraulic cylinder, fed by a pump without a valve",
        State=state_class,
        Inputs=Inputs,
        Parameters=parameters_class,
        Signals=signals_class,
        derivatives=derivatives,
        signals=signals,
        measure=measure,
        equilibrium=equilibrium,
        command_limit=pump_speed_limit,
        travel=travel,
        command="pump_speed",
        balances={"force": FORCE, "flow": Balance(("load_pressure",), "m^3/s", load_pressure_capacity)},
        friction=law.name,
        contact="contact",
        refit=pumped,
    )


PUMP_CYLINDER = pumped(LUGRE)
