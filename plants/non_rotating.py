"""The hydraulic actuator of thesis 3.2: position, velocity, load pressure, the valve's spool, and the contact's memory.

One plant for each friction law of `plants.laws`; the thesis's is LuGre's.
"""

import functools
from typing import Annotated, Any, NamedTuple

import numpy as np

from plants import hydraulics as hyd
from plants.equation import Scalar, equation
from plants.friction import Friction
from plants.hydraulics import Hydraulic, Hydraulics, Mass
from plants.interface import Balance, Measurement, Plant
from plants.laws.interface import FrictionLaw, at_rest, fitted, friction_of
from plants.laws.lugre import LUGRE, Bristle, named


class State(NamedTuple):
    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    load_pressure: Annotated[float, "Pa", 1e6]
    contact: Bristle
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
    contact: Bristle
    load_flow: Annotated[float, "m^3/s"]
    axial_friction: Annotated[float, "N"]
    hydraulic_power: Annotated[float, "W"]
    supply_power: Annotated[float, "W"]
    total_power: Annotated[float, "W"]


@equation
def measure(state: State, p: Parameters) -> Measurement:
    """Position and both pressures; the rod does not rotate."""
    pressure_1, pressure_2 = hyd.chamber_pressures(state.load_pressure, p.hydraulics)
    return Measurement(state.position, pressure_1, pressure_2, 0.0, 0.0)


def holding_load_pressure(h: Hydraulics, body: Mass) -> float:
    """P_L (Pa) that balances the constant load, held by a closed valve if no oil leaks: P1 A1 - P2 A2 = F_load."""
    total = h.supply_pressure + h.tank_pressure
    by_areas = 0.5 * total * (h.piston_area_1 - h.piston_area_2)
    return float((body.load_force - by_areas) / hyd.piston_area(h))


def voltage_limit(p: Parameters) -> float:
    """Limit of the valve amplifier (V)."""
    return p.hydraulics.voltage_limit


def travel(p: Parameters) -> float:
    """Distance (m) between the end stops, if they are modelled."""
    return p.hydraulics.stroke if p.body.end_stop_stiffness else np.inf


def load_pressure_capacity(p: Hydraulic) -> tuple[float]:
    """V_t / (4 beta) (m^3/Pa): the flow that a rate of the load pressure takes."""
    return (hyd.oil_volume(p.hydraulics) / (4.0 * p.hydraulics.bulk_modulus),)


BALANCES = {
    "force": hyd.FORCE,
    "flow": Balance(("load_pressure",), "m^3/s", load_pressure_capacity),
    "valve": hyd.VALVE,
}
"""Of an actuator in the load-pressure form."""


@equation
def free_acceleration(state: Any, inputs: Any, p: Any) -> Scalar:
    """dv/dt (m/s^2) without friction."""
    pressure, force = state.load_pressure, inputs.disturbance_force
    return hyd.piston_acceleration(state.position, state.velocity, pressure, 0.0, force, p.hydraulics, p.body)


@functools.cache
def actuator(law: FrictionLaw) -> Plant:
    """The actuator with a friction law."""
    state_class, parameters_class, signals_class = fitted(law, State, Parameters, Signals)
    friction, unbent = friction_of(law, free_acceleration), at_rest(law)

    @equation
    def derivatives(time: Scalar, state: Any, inputs: Inputs, p: Any) -> Any:
        """Rates of the states. Thesis (3.35) to (3.38) with the valve of 3.2.1."""
        h = p.hydraulics
        force, rates = friction(state, inputs, p)
        flow = hyd.load_flow(state.spool_position, state.load_pressure, h)
        return state_class(
            state.velocity,
            hyd.piston_acceleration(
                state.position, state.velocity, state.load_pressure, force, inputs.disturbance_force, h, p.body
            ),
            hyd.load_pressure_rate(flow, state.velocity, state.load_pressure, h),
            rates,
            hyd.spool_rate(state.spool_position, inputs.valve_voltage, h),
        )

    @equation
    def signals(time: Scalar, state: Any, inputs: Inputs, p: Any) -> Any:
        """What is worth plotting. Power: P_L Q_L (thesis 4.16, without the oil's compression) and P_s |Q_L|;
        total: hydraulic alone.
        """
        h = p.hydraulics
        force, _ = friction(state, inputs, p)
        flow = hyd.load_flow(state.spool_position, state.load_pressure, h)
        pressure_1, pressure_2 = hyd.chamber_pressures(state.load_pressure, h)
        return signals_class(
            state.position,
            state.velocity,
            derivatives(time, state, inputs, p).velocity,
            state.load_pressure,
            pressure_1,
            pressure_2,
            state.spool_position,
            state.contact,
            flow,
            force,
            state.load_pressure * flow,
            h.supply_pressure * np.abs(flow),
            state.load_pressure * flow,
        )

    def equilibrium(p: Parameters, surface_speed: float) -> tuple[NamedTuple, Inputs]:
        """At rest in mid-stroke with the valve closed; this plant does not rotate."""
        return state_class(0.0, 0.0, holding_load_pressure(p.hydraulics, p.body), unbent, 0.0), Inputs(0.0, 0.0)

    return Plant(
        name=named("non_rotating", law),
        summary="hydraulic cylinder with servo valve (thesis 3.2)",
        State=state_class,
        Inputs=Inputs,
        Parameters=parameters_class,
        Signals=signals_class,
        derivatives=derivatives,
        signals=signals,
        measure=measure,
        equilibrium=equilibrium,
        command_limit=voltage_limit,
        travel=travel,
        command="valve_voltage",
        balances=BALANCES,
        friction=law.name,
        contact="contact",
        refit=actuator,
    )


NON_ROTATING = actuator(LUGRE)
