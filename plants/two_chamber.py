"""The hydraulic actuator with a pressure in each chamber, and every effect that a machine may have beside the thesis.

With equal areas and no effect it is `non_rotating`: the chambers' pressures then add up to supply and tank pressure.
"""

from typing import Annotated, NamedTuple

import numpy as np

from plants import effects as fx
from plants import hydraulics as hyd
from plants.effects import FlowEffects, FrictionEffects
from plants.equation import Scalar, equation, select
from plants.friction import Friction, directed, stribeck_level
from plants.hydraulics import Hydraulics, Mass
from plants.interface import Measurement, Plant
from plants.non_rotating import Inputs, travel, voltage_limit


class Parameters(NamedTuple):
    """The load-pressure actuator's, with effects; `area_ratio` is A2 over its declared value."""

    hydraulics: Hydraulics
    body: Mass
    friction: Friction
    friction_effects: FrictionEffects
    flow_effects: FlowEffects
    area_ratio: Annotated[float, "1"] = 1.0
    command_delay: Annotated[float, "s"] = 0.0
    backlash_width: Annotated[float, "m"] = 0.0
    pressure_1_offset: Annotated[float, "Pa"] = 0.0


class State(NamedTuple):
    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    pressure_1: Annotated[float, "Pa", 1e6]
    pressure_2: Annotated[float, "Pa", 1e6]
    bristle_deflection: Annotated[float, "m", 1e-4]
    spool_position: Annotated[float, "m", 1e-4]
    lagged_velocity: Annotated[float, "m/s", 1e-1]
    rested: Annotated[float, "1", 1.0]
    delayed_voltage: Annotated[float, "V", 1.0]
    sensor_gap: Annotated[float, "m", 1e-5]


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
def edge_flow(opening: Scalar, drop: Scalar, h: Hydraulics) -> Scalar:
    """Flow (m^3/s) across one edge of the spool: K x_o sqrt(2 share drop), `drop` in Pa, none against the pressure.

    With the share of 1/2 of (3.22) an edge sees half the drop of both, which is its own.
    """
    return h.valve_flow_gain * opening * np.sqrt(np.maximum(2.0 * h.flow_pressure_share * drop, 0.0))


@equation
def valve_flows(
    spool: Scalar, pressure_1: Scalar, pressure_2: Scalar, h: Hydraulics, e: FlowEffects
) -> tuple[Scalar, Scalar]:
    """Flows (m^3/s) through the valve into chamber 1 and out of chamber 2, with the supply as it droops.

    The droop is that of the pump's flow at the declared supply pressure.
    """
    opening = hyd.valve_opening(spool, h)
    forward = opening >= 0.0
    pumped = select(
        forward,
        edge_flow(opening, h.supply_pressure - pressure_1, h),
        edge_flow(-opening, h.supply_pressure - pressure_2, h),
    )
    supply = fx.drooped_supply(h.supply_pressure, pumped, e)
    into = select(
        forward, edge_flow(opening, supply - pressure_1, h), edge_flow(opening, pressure_1 - h.tank_pressure, h)
    )
    out = select(
        forward, edge_flow(opening, pressure_2 - h.tank_pressure, h), edge_flow(opening, supply - pressure_2, h)
    )
    return into, out


@equation
def chamber_volumes(h: Hydraulics, area_ratio: Scalar) -> tuple[Scalar, Scalar]:
    """Oil (m^3) in each chamber with its hose, at mid-stroke whatever the position, as in (3.28)."""
    return (
        h.hose_volume + 0.5 * h.piston_area_1 * h.stroke,
        h.hose_volume + 0.5 * area_ratio * h.piston_area_2 * h.stroke,
    )


@equation
def friction_rates(
    position: Scalar,
    velocity: Scalar,
    slip: Scalar,
    load_pressure: Scalar,
    time: Scalar,
    bristle: Scalar,
    lagged: Scalar,
    rested: Scalar,
    stroke: Scalar,
    friction: Friction,
    e: FrictionEffects,
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Friction (N), the bristle's rate constant a (1/s), its rate (m/s) and the deflection (m) beyond which it slips.

        F = sigma0 z + sigma1 dz/dt + a2 v,   dz/dt = v - a z,   a = sigma0 s / g(v_m),   z_s = g / sigma0

    LuGre (thesis 3.31 to 3.33) with what effects make of its set. `slip` s is |v|; a measured velocity has noise, which
    |v| would take for a creep that never ends, so that who knows of it gives 0 in its place.
    """
    contact = fx.affected_contact(
        directed(velocity, bristle, friction), position, load_pressure, time, rested, stroke, e
    )
    level = stribeck_level(fx.stribeck_speed(velocity, lagged, e), contact)
    relaxation = contact.bristle_stiffness * slip / level
    rate = velocity - relaxation * bristle
    force = contact.bristle_stiffness * bristle + contact.bristle_damping * rate + contact.viscous * velocity
    return force, relaxation, rate, level / contact.bristle_stiffness


@equation
def state_friction(time: Scalar, state: State, p: Parameters) -> tuple[Scalar, Scalar]:
    """Friction (N) and the bristle's rate (m/s) in a state: see `friction_rates`."""
    force, _, rate, _ = friction_rates(
        state.position,
        state.velocity,
        np.abs(state.velocity),
        state.pressure_1 - state.pressure_2,
        time,
        state.bristle_deflection,
        state.lagged_velocity,
        state.rested,
        p.hydraulics.stroke,
        p.friction,
        p.friction_effects,
    )
    return force, rate


@equation
def derivatives(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> State:
    """Rates of the states: Newton, a continuity equation for each chamber, the valve, the bristle, the effects."""
    h = p.hydraulics
    load_pressure = state.pressure_1 - state.pressure_2
    friction, bristle_rate = state_friction(time, state, p)
    area_2 = p.area_ratio * h.piston_area_2
    stop = hyd.end_stop_force(state.position, state.velocity, h.stroke, p.body)
    added = fx.added_force(state.position, state.velocity, 0.0, p.friction_effects)
    force = state.pressure_1 * h.piston_area_1 - state.pressure_2 * area_2
    acceleration = (force + stop - friction - added - p.body.load_force - inputs.disturbance_force) / p.body.mass

    into, out = valve_flows(state.spool_position, state.pressure_1, state.pressure_2, h, p.flow_effects)
    volume_1, volume_2 = chamber_volumes(h, p.area_ratio)
    leakage = hyd.internal_leakage(load_pressure, h)
    rate_1 = (into - h.piston_area_1 * state.velocity - leakage) / volume_1
    rate_2 = (area_2 * state.velocity + leakage - out) / volume_2
    voltage = select(p.command_delay > 0.0, state.delayed_voltage, inputs.valve_voltage)
    delay = np.maximum(p.command_delay, 1e-6)
    return State(
        state.velocity,
        acceleration,
        rate_1 / fx.compliance(state.pressure_1, h.bulk_modulus, p.flow_effects),
        rate_2 / fx.compliance(state.pressure_2, h.bulk_modulus, p.flow_effects),
        bristle_rate,
        hyd.spool_rate(state.spool_position, voltage, h),
        fx.lagged_rate(state.velocity, state.lagged_velocity, p.friction_effects),
        fx.rested_rate(state.velocity - bristle_rate, state.rested, p.friction_effects),
        select(p.command_delay > 0.0, (inputs.valve_voltage - state.delayed_voltage) / delay, 0.0),
        fx.gap_rate(state.velocity, state.sensor_gap, p.backlash_width),
    )


@equation
def signals(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> Signals:
    """What is worth plotting; power as in `non_rotating`."""
    h = p.hydraulics
    load_pressure = state.pressure_1 - state.pressure_2
    friction, _ = state_friction(time, state, p)
    into, out = valve_flows(state.spool_position, state.pressure_1, state.pressure_2, h, p.flow_effects)
    flow = 0.5 * (into + out)
    power = state.pressure_1 * into - state.pressure_2 * out
    return Signals(
        state.position,
        state.velocity,
        derivatives(time, state, inputs, p).velocity,
        load_pressure,
        state.pressure_1,
        state.pressure_2,
        state.spool_position,
        state.bristle_deflection,
        flow,
        friction,
        power,
        h.supply_pressure * np.abs(select(into >= 0.0, into, out)),
        power,
    )


@equation
def measure(state: State, p: Parameters) -> Measurement:
    """Position behind the backlash, both pressures, the first with its offset."""
    gap = np.minimum(np.maximum(state.sensor_gap, -0.5 * p.backlash_width), 0.5 * p.backlash_width)
    return Measurement(state.position + gap, state.pressure_1 + p.pressure_1_offset, state.pressure_2, 0.0, 0.0)


def equilibrium(p: Parameters, surface_speed: float) -> tuple[State, Inputs]:
    """At rest for long in mid-stroke, the load held by the oil: P1 A1 - P2 A2 = F_load with P1 + P2 = P_s + P_T."""
    h = p.hydraulics
    total, area_2 = h.supply_pressure + h.tank_pressure, p.area_ratio * h.piston_area_2
    pressure_1 = (p.body.load_force + total * area_2) / (h.piston_area_1 + area_2)
    return State(0.0, 0.0, pressure_1, total - pressure_1, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0), Inputs(0.0, 0.0)


TWO_CHAMBER = Plant(
    name="two_chamber",
    summary="hydraulic actuator with a pressure in each chamber and the effects of a real machine",
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
    balances={"force": "velocity", "flow": "pressure_1", "valve": "spool_position"},
)
