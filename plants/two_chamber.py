"""The hydraulic actuator with a pressure in each chamber, which takes every effect that a machine may have.

With equal areas and no effect it is `non_rotating`: the chambers' pressures then add up to supply and tank pressure.
"""

import functools
from dataclasses import replace
from typing import Annotated, Any, NamedTuple

import numpy as np

from plants import hydraulics as hyd
from plants.equation import Scalar, equation, select
from plants.hydraulics import Hydraulic, Hydraulics, edge_flow
from plants.interface import Balance, Measurement, Plant
from plants.laws.interface import FrictionLaw, at_rest, fitted, friction_of
from plants.laws.lugre import LUGRE, Bristle, named
from plants.non_rotating import BALANCES, Inputs, Parameters, Signals, actuator


class State(NamedTuple):
    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    pressure_1: Annotated[float, "Pa", 1e6]
    pressure_2: Annotated[float, "Pa", 1e6]
    contact: Bristle
    spool_position: Annotated[float, "m", 1e-4]


@equation
def valve_flows(spool: Scalar, pressure_1: Scalar, pressure_2: Scalar, h: Hydraulics) -> tuple[Scalar, Scalar]:
    """Flows (m^3/s) through the valve into chamber 1 and out of chamber 2."""
    opening, supply, tank = hyd.valve_opening(spool, h), h.supply_pressure, h.tank_pressure
    forward = opening >= 0.0
    into = select(forward, edge_flow(opening, supply - pressure_1, h), edge_flow(opening, pressure_1 - tank, h))
    out = select(forward, edge_flow(opening, pressure_2 - tank, h), edge_flow(opening, supply - pressure_2, h))
    return into, out


@equation
def chamber_volumes(h: Hydraulics) -> tuple[Scalar, Scalar]:
    """Oil (m^3) in each chamber with its hose, at mid-stroke whatever the position, as in (3.28)."""
    return h.hose_volume + 0.5 * h.piston_area_1 * h.stroke, h.hose_volume + 0.5 * h.piston_area_2 * h.stroke


@equation
def sum_of_forces(state: Any, friction: Scalar, inputs: Inputs, p: Any) -> Scalar:
    """Force (N) on the mass: P1 A1 - P2 A2 + end stops - F_friction - F_load - disturbance."""
    h = p.hydraulics
    stop = hyd.end_stop_force(state.position, state.velocity, h.stroke, p.body)
    force = state.pressure_1 * h.piston_area_1 - state.pressure_2 * h.piston_area_2
    return force + stop - friction - p.body.load_force - inputs.disturbance_force


@equation
def free_acceleration(state: Any, inputs: Inputs, p: Any) -> Scalar:
    """dv/dt (m/s^2) without friction."""
    return sum_of_forces(state, 0.0, inputs, p) / p.body.mass


@equation
def pressure_rates(state: Any, p: Any) -> tuple[Scalar, Scalar]:
    """dP_1/dt and dP_2/dt (Pa/s): continuity of each chamber, with leakage past the piston."""
    h = p.hydraulics
    into, out = valve_flows(state.spool_position, state.pressure_1, state.pressure_2, h)
    volume_1, volume_2 = chamber_volumes(h)
    leakage = hyd.internal_leakage(state.pressure_1 - state.pressure_2, h)
    return (
        (into - h.piston_area_1 * state.velocity - leakage) * h.bulk_modulus / volume_1,
        (h.piston_area_2 * state.velocity + leakage - out) * h.bulk_modulus / volume_2,
    )


@equation
def measure(state: State, p: Any) -> Measurement:
    """Position and both pressures; the rod does not rotate."""
    return Measurement(state.position, state.pressure_1, state.pressure_2, 0.0, 0.0)


def chamber_capacities(p: Hydraulic) -> tuple[float, float]:
    """V / beta (m^3/Pa) of each chamber: the flow that a rate of its pressure takes."""
    volume_1, volume_2 = chamber_volumes(p.hydraulics)
    return volume_1 / p.hydraulics.bulk_modulus, volume_2 / p.hydraulics.bulk_modulus


@functools.cache
def chambered(law: FrictionLaw) -> Plant:
    """The actuator with a friction law: `non_rotating` with other states and equations."""
    state_class, signals_class = fitted(law, State, Signals)
    friction, unbent = friction_of(law, free_acceleration), at_rest(law)

    @equation
    def derivatives(time: Scalar, state: Any, inputs: Inputs, p: Any) -> Any:
        """Rates of the states: Newton, a continuity equation for each chamber, the contact, the valve."""
        opposed, rates = friction(state, inputs, p)
        total = sum_of_forces(state, opposed, inputs, p)
        rate_1, rate_2 = pressure_rates(state, p)
        spool = hyd.spool_rate(state.spool_position, inputs.valve_voltage, p.hydraulics)
        return state_class(state.velocity, total / p.body.mass, rate_1, rate_2, rates, spool)

    @equation
    def signals(time: Scalar, state: Any, inputs: Inputs, p: Any) -> Any:
        """What is worth plotting; power as in `non_rotating`."""
        h = p.hydraulics
        opposed, _ = friction(state, inputs, p)
        into, out = valve_flows(state.spool_position, state.pressure_1, state.pressure_2, h)
        power = state.pressure_1 * into - state.pressure_2 * out
        return signals_class(
            state.position,
            state.velocity,
            derivatives(time, state, inputs, p).velocity,
            state.pressure_1 - state.pressure_2,
            state.pressure_1,
            state.pressure_2,
            state.spool_position,
            state.contact,
            0.5 * (into + out),
            opposed,
            power,
            h.supply_pressure * np.abs(select(into >= 0.0, into, out)),
            power,
        )

    def equilibrium(p: Parameters, surface_speed: float) -> tuple[NamedTuple, Inputs]:
        """At rest in mid-stroke, the load held by the oil: P1 A1 - P2 A2 = F_load with P1 + P2 = P_s + P_T."""
        h = p.hydraulics
        total = h.supply_pressure + h.tank_pressure
        pressure_1 = (p.body.load_force + total * h.piston_area_2) / (h.piston_area_1 + h.piston_area_2)
        return state_class(0.0, 0.0, pressure_1, total - pressure_1, unbent, 0.0), Inputs(0.0, 0.0)

    return replace(
        actuator(law),
        name=named("two_chamber", law),
        summary="hydraulic actuator with a pressure in each chamber",
        State=state_class,
        derivatives=derivatives,
        signals=signals,
        measure=measure,
        equilibrium=equilibrium,
        balances={**BALANCES, "flow": Balance(("pressure_1", "pressure_2"), "m^3/s", chamber_capacities)},
        refit=chambered,
    )


TWO_CHAMBER = chambered(LUGRE)
