"""Cylinder with a pressure in each chamber, differential or not, on a valve of four edges.

    V_1 = V_h + V_d1 + A_1 (L/2 + x),  V_2 = V_h + V_d2 + A_2 (L/2 - x)
    dP_1/dt = beta / V_1 (Q_1 - A_1 v - C (P_1 - P_2)),  dP_2/dt = beta / V_2 (A_2 v + C (P_1 - P_2) - Q_2)

Q_1 flows through the valve into chamber 1, Q_2 out of chamber 2 (Merritt 1967; Jelali and Kroll 2003). The thesis
freezes the volumes at mid-stroke (3.28): that is `TWO_CHAMBER`, which with equal areas is the thesis's plant. Every
effect that a machine may have finds its place here.
"""

from typing import Annotated, Any, NamedTuple

from plants import hydraulics as hyd
from plants.actuators.interface import Actuator
from plants.actuators.load_pressure import Inputs, Signals, stroke, voltage_limit
from plants.actuators.resting import Resting, at_rest
from plants.equation import Equation, Scalar, equation
from plants.hydraulics import Cylinder, Hydraulics, edge_flow, oil_volumes, opening
from plants.interface import Balance


class State(NamedTuple):
    pressure_1: Annotated[float, "Pa", 1e6]
    pressure_2: Annotated[float, "Pa", 1e6]
    spool_position: Annotated[float, "m", 1e-4]


class Parameters(NamedTuple):
    hydraulics: Hydraulics
    cylinder: Cylinder = Cylinder()


@equation
def edge_flows(
    spool: Scalar, pressure_1: Scalar, pressure_2: Scalar, h: Hydraulics, c: Cylinder
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Flows (m^3/s) across the edges, from pump to 1, from 1 to tank, from pump to 2, from 2 to tank."""
    covered, back, supply, tank = h.valve_overlap, h.valve_overlap_negative, h.supply_pressure, h.tank_pressure
    return (
        c.edge_gain_pa * edge_flow(opening(spool, covered, c.edge_overlap_pa), supply - pressure_1, h),
        c.edge_gain_at * edge_flow(opening(-spool, back, c.edge_overlap_at), pressure_1 - tank, h),
        c.edge_gain_pb * edge_flow(opening(-spool, back, c.edge_overlap_pb), supply - pressure_2, h),
        c.edge_gain_bt * edge_flow(opening(spool, covered, c.edge_overlap_bt), pressure_2 - tank, h),
    )


@equation
def net_flows(spool: Scalar, pressure_1: Scalar, pressure_2: Scalar, p: Any) -> tuple[Scalar, Scalar]:
    """Flows (m^3/s) into chamber 1 and out of chamber 2, less what leaks past the piston and outside: they move it."""
    from_pump_1, to_tank_1, from_pump_2, to_tank_2 = edge_flows(spool, pressure_1, pressure_2, p.hydraulics, p.cylinder)
    leakage = hyd.internal_leakage(pressure_1 - pressure_2, p.hydraulics)
    lost_1, lost_2 = hyd.external_leakages(pressure_1, pressure_2, p.hydraulics)
    return from_pump_1 - to_tank_1 - leakage - lost_1, to_tank_2 - from_pump_2 - leakage + lost_2


@equation
def following(position: Scalar) -> Scalar:
    """The position (m) by which chambers have their volumes: the rod's."""
    return position


@equation
def frozen(position: Scalar) -> Scalar:
    """The same at mid-stroke whatever the position, as in (3.28)."""
    return 0.0


@equation
def force(state: Any, inputs: Any, p: Any) -> Scalar:
    """P1 A1 - P2 A2 (N)."""
    h = p.hydraulics
    return state.pressure_1 * h.piston_area_1 - state.pressure_2 * h.piston_area_2


@equation
def signals(state: Any, inputs: Any, p: Any) -> tuple[Scalar, ...]:
    """Power: P_1 Q_1 - P_2 Q_2 into the cylinder, and P_s times the flow from the pump."""
    h = p.hydraulics
    from_pump_1, to_tank_1, from_pump_2, to_tank_2 = edge_flows(
        state.spool_position, state.pressure_1, state.pressure_2, h, p.cylinder
    )
    into, out = from_pump_1 - to_tank_1, to_tank_2 - from_pump_2
    return (
        state.pressure_1 - state.pressure_2,
        state.pressure_1,
        state.pressure_2,
        state.spool_position,
        0.5 * (into + out),
        state.pressure_1 * into - state.pressure_2 * out,
        h.supply_pressure * (from_pump_1 + from_pump_2),
    )


@equation
def pressures(state: Any, p: Any) -> tuple[Scalar, Scalar]:
    """P1 and P2 (Pa)."""
    return state.pressure_1, state.pressure_2


def chamber_capacities(p: Any) -> tuple[float, float]:
    """V / beta (m^3/Pa) of each chamber at mid-stroke: the flow that a rate of its pressure takes."""
    volume_1, volume_2 = oil_volumes(0.0, p.hydraulics, p.cylinder)
    return float(volume_1) / p.hydraulics.bulk_modulus, float(volume_2) / p.hydraulics.bulk_modulus


def equilibrium(p: Any) -> tuple[tuple[float, float, float], tuple[float]]:
    """At rest, the load held by the oil; what a closed valve leaves open is P1 + P2 = P_s + P_T, as in motion."""
    h = p.hydraulics
    cylinder = Resting(h.piston_area_1, h.piston_area_2, h.tank_pressure, h.supply_pressure, h.spool_limit)
    pressure_1, pressure_2, spool = at_rest(net_flows, p, cylinder, h.supply_pressure + h.tank_pressure)
    return (pressure_1, pressure_2, spool), (spool / h.valve_position_gain,)


def _chambered(name: str, summary: str, counted: Equation) -> Actuator:
    """The actuator whose chambers have their volumes by the position that an equation counts."""

    @equation
    def rates(state: Any, inputs: Any, p: Any) -> tuple[Scalar, Scalar, Scalar]:
        """Of both pressures, by continuity, and of the spool."""
        h = p.hydraulics
        into, out = net_flows(state.spool_position, state.pressure_1, state.pressure_2, p)
        volume_1, volume_2 = oil_volumes(counted(state.position), h, p.cylinder)
        return (
            (into - h.piston_area_1 * state.velocity) * h.bulk_modulus / volume_1,
            (h.piston_area_2 * state.velocity - out) * h.bulk_modulus / volume_2,
            hyd.spool_rate(state.spool_position, inputs.valve_voltage, h),
        )

    return Actuator(
        name=name,
        summary=summary,
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
        frozen_volumes=counted is frozen,
        balances={
            "force": hyd.FORCE,
            "flow": Balance(("pressure_1", "pressure_2"), "m^3/s", chamber_capacities),
            "valve": hyd.VALVE,
        },
    )


CYLINDER = _chambered("cylinder", "hydraulic cylinder, differential or not, with servo valve", following)
TWO_CHAMBER = _chambered("two_chamber", "the same with chambers frozen at mid-stroke, as in the thesis", frozen)
