"""Servo valve, flow, pressure, and the forces on the piston: what the rotating and the other actuator share.

The load-pressure form of the thesis: one pressure state, P_L = P1 - P2, equal piston areas. The thesis's valve and
piston seal are ideal; overlap and leakage are what real ones add, and 0 by default.
"""

from typing import Annotated, NamedTuple, Protocol, runtime_checkable

import numpy as np

from plants.equation import Scalar, equation, select
from plants.interface import Balance

FLOW_LAWS = {"derived": 0.5, "chapter3": 1.0}
"""The share of the pressure drop that one edge of the spool sees, by the name of the flow law.

`derived`: both edges share the drop, thesis (3.22) and appendix C. `chapter3`: the flow that reproduces the
printed phase shifts of chapter 3; the same as a valve gain sqrt(2) times larger, and not what (3.22) gives.
"""


LAMINAR_DROP = 1e4
"""Pa. Pressure drop below which the flow through an edge is laminar: 0.1 bar, of a hundred in use."""


class Hydraulics(NamedTuple):
    """Supply, valve and cylinder. `valve_overlap` is that of both directions, unless the negative one has its own."""

    piston_area_1: Annotated[float, "m^2"]
    piston_area_2: Annotated[float, "m^2"]
    stroke: Annotated[float, "m"]
    hose_volume: Annotated[float, "m^3"]
    bulk_modulus: Annotated[float, "Pa"]
    supply_pressure: Annotated[float, "Pa"]
    tank_pressure: Annotated[float, "Pa"]
    valve_flow_gain: Annotated[float, "m^2/(s Pa^0.5)"]
    valve_position_gain: Annotated[float, "m/V"]
    valve_time_constant: Annotated[float, "s"]
    spool_limit: Annotated[float, "m"]
    voltage_limit: Annotated[float, "V"]
    flow_pressure_share: Annotated[float, "1"]
    valve_overlap: Annotated[float, "m"] = 0.0
    leakage_coefficient: Annotated[float, "m^3/(s Pa)"] = 0.0
    valve_overlap_negative: Annotated[float, "m"] = 0.0
    external_leakage_1: Annotated[float, "m^3/(s Pa)"] = 0.0
    external_leakage_2: Annotated[float, "m^3/(s Pa)"] = 0.0


LEAST_VOLUME = 1e-3
"""Share of a chamber's swept volume that is left in it at the end of the stroke, whatever its dead volume."""


class Cylinder(NamedTuple):
    """What a cylinder and its valve have beside a symmetric actuator's `Hydraulics`.

    Dead volumes are of the oil in each end of the cylinder and in the block, beside the hose's. The edges of the spool
    are called by what they join: pump (p), tank (t), and the ports of chambers 1 (a) and 2 (b). Each has a gain, a
    multiple of `valve_flow_gain`, and an overlap beside `valve_overlap`, negative of an edge that is open at rest.
    """

    dead_volume_1: Annotated[float, "m^3"] = 0.0
    dead_volume_2: Annotated[float, "m^3"] = 0.0
    edge_gain_pa: Annotated[float, "1"] = 1.0
    edge_gain_at: Annotated[float, "1"] = 1.0
    edge_gain_pb: Annotated[float, "1"] = 1.0
    edge_gain_bt: Annotated[float, "1"] = 1.0
    edge_overlap_pa: Annotated[float, "m"] = 0.0
    edge_overlap_at: Annotated[float, "m"] = 0.0
    edge_overlap_pb: Annotated[float, "m"] = 0.0
    edge_overlap_bt: Annotated[float, "m"] = 0.0


class Mass(NamedTuple):
    """The moving mass, what pulls at it, and where its travel ends."""

    mass: Annotated[float, "kg"]
    load_force: Annotated[float, "N"]
    end_stop_stiffness: Annotated[float, "N/m"]
    end_stop_damping: Annotated[float, "s/m"]


@runtime_checkable
class Hydraulic(Protocol):
    """Parameters of a valve and a cylinder: the command has a velocity gain, and the force is measured as pressures."""

    @property
    def hydraulics(self) -> Hydraulics: ...


class Spool(Protocol):
    """Parameters of a valve whose spool follows a voltage, and whose lands cover its ports."""

    @property
    def valve_position_gain(self) -> float: ...
    @property
    def valve_time_constant(self) -> float: ...
    @property
    def spool_limit(self) -> float: ...
    @property
    def valve_overlap(self) -> float: ...
    @property
    def valve_overlap_negative(self) -> float: ...


class Bored(Protocol):
    """Parameters of a cylinder, whatever fills it."""

    @property
    def piston_area_1(self) -> float: ...
    @property
    def piston_area_2(self) -> float: ...
    @property
    def stroke(self) -> float: ...


class Moving(Protocol):
    """Parameters of a mass that moves."""

    @property
    def body(self) -> Mass: ...


def mass(p: Moving) -> tuple[float]:
    """M (kg): the force that an acceleration takes."""
    return (p.body.mass,)


def valve_time(p: Hydraulic) -> tuple[float]:
    """tau_sv (s): the way of the spool's target that a rate of the spool takes."""
    return (p.hydraulics.valve_time_constant,)


FORCE, VALVE = Balance(("velocity",), "N", mass), Balance(("spool_position",), "m", valve_time)
"""The balances of a mass, and of a valve's spool."""


@equation
def piston_area(p: Hydraulics) -> Scalar:
    """Mean area A (m^2) of the two sides."""
    return 0.5 * (p.piston_area_1 + p.piston_area_2)


@equation
def oil_volume(p: Hydraulics) -> Scalar:
    """V_t = 2 V_h + A L (m^3): both hoses and the cylinder, independent of position."""
    return 2.0 * p.hose_volume + piston_area(p) * p.stroke


@equation
def chamber_pressures(load_pressure: Scalar, p: Hydraulics) -> tuple[Scalar, Scalar]:
    """P1 and P2 (Pa) from P_L, for a valve of matched edges: their sum is P_s + P_T. Thesis (3.18), (3.19)."""
    total = p.supply_pressure + p.tank_pressure
    return 0.5 * (total + load_pressure), 0.5 * (total - load_pressure)


@equation
def spool_rate(spool: Scalar, voltage: Scalar, p: Spool) -> Scalar:
    """dx_s/dt (m/s) = (K_sv V - x_s) / tau_sv, thesis 3.2.1; the spool's target stays within its travel."""
    target = np.minimum(np.maximum(p.valve_position_gain * voltage, -p.spool_limit), p.spool_limit)
    return (target - spool) / p.valve_time_constant


@equation
def valve_opening(spool: Scalar, p: Spool) -> Scalar:
    """How far (m) the spool at `spool` (m) opens the ports: x_s - sgn(x_s) overlap beyond the overlap, 0 within it.

    The overlap of either direction is how far the lands cover the ports (Merritt 1967). The opening has kinks but no
    jump; without overlap it is the spool's position.
    """
    overlap = select(spool >= 0.0, p.valve_overlap, p.valve_overlap_negative)
    return select(np.abs(spool) < overlap, 0.0, spool - np.sign(spool) * overlap)


@equation
def load_flow(spool: Scalar, load_pressure: Scalar, p: Hydraulics) -> Scalar:
    """Q_L (m^3/s) = K x_o sqrt(share (P_s - P_T - sgn(x_s) P_L)), thesis (3.22) with share = 1/2.

    x_o (m) is the `valve_opening`; in the thesis that is x_s itself.
    """
    drop = p.supply_pressure - p.tank_pressure - np.sign(spool) * load_pressure
    opening = valve_opening(spool, p)
    return p.valve_flow_gain * opening * np.sqrt(np.maximum(p.flow_pressure_share * drop, 0.0))


@equation
def opening(way: Scalar, overlap: Scalar, own: Scalar) -> Scalar:
    """How far (m) an edge is open whose spool has gone `way` (m) towards it: beyond the overlaps, 0 within them."""
    return np.maximum(way - (overlap + own), 0.0)


@equation
def chamber_volumes(position: Scalar, dead_1: Scalar, dead_2: Scalar, p: Bored) -> tuple[Scalar, Scalar]:
    """Fluid (m^3) in each chamber: what is always there, and A (L/2 +- x), the rod at `position` x (m) from mid-stroke.

    At least `LEAST_VOLUME` of what is swept.
    """
    swept_1, swept_2 = p.piston_area_1 * p.stroke, p.piston_area_2 * p.stroke
    volume_1 = dead_1 + 0.5 * swept_1 + p.piston_area_1 * position
    volume_2 = dead_2 + 0.5 * swept_2 - p.piston_area_2 * position
    return np.maximum(volume_1, LEAST_VOLUME * swept_1), np.maximum(volume_2, LEAST_VOLUME * swept_2)


@equation
def oil_volumes(position: Scalar, h: Hydraulics, c: Cylinder) -> tuple[Scalar, Scalar]:
    """Oil (m^3) in each chamber with its hose, the rod at `position` (m) from mid-stroke."""
    return chamber_volumes(position, h.hose_volume + c.dead_volume_1, h.hose_volume + c.dead_volume_2, h)


@equation
def orifice(drop: Scalar) -> Scalar:
    """sgn(dp) sqrt(|dp|) (Pa^0.5), turbulent either way; laminar within `LAMINAR_DROP`, without a kink at its end.

        sqrt(d) (5 s - s^3) / 4,  s = dp / d    for |dp| <= d

    A bare root has an infinite slope where nothing flows, of which an integrator makes endless steps. [derived here]
    """
    share = drop / LAMINAR_DROP
    laminar = np.sqrt(LAMINAR_DROP) * share * (5.0 - share**2) / 4.0
    return select(np.abs(drop) > LAMINAR_DROP, np.sign(drop) * np.sqrt(np.abs(drop)), laminar)


@equation
def edge_flow(opening: Scalar, drop: Scalar, p: Hydraulics) -> Scalar:
    """Flow (m^3/s) across one edge of the spool: K x_o sgn(dp) sqrt(2 share |dp|), dp = `drop` in Pa (see `orifice`).

    With the share of 1/2 of (3.22) an edge sees half the drop of both, which is its own.
    """
    return p.valve_flow_gain * opening * orifice(2.0 * p.flow_pressure_share * drop)


@equation
def internal_leakage(load_pressure: Scalar, p: Hydraulics) -> Scalar:
    """Flow (m^3/s) across the piston from chamber 1 to chamber 2, laminar: C P_L (Merritt 1967)."""
    return p.leakage_coefficient * load_pressure


@equation
def external_leakages(pressure_1: Scalar, pressure_2: Scalar, p: Hydraulics) -> tuple[Scalar, Scalar]:
    """Flows (m^3/s) out of either chamber to the tank, laminar: C_e (P - P_T) (Merritt 1967)."""
    tank = p.tank_pressure
    return p.external_leakage_1 * (pressure_1 - tank), p.external_leakage_2 * (pressure_2 - tank)


@equation
def load_leakage(load_pressure: Scalar, p: Hydraulics) -> Scalar:
    """Flow (m^3/s) that the load flow lacks: past the piston, and half of what chamber 1 loses more than chamber 2."""
    pressure_1, pressure_2 = chamber_pressures(load_pressure, p)
    lost_1, lost_2 = external_leakages(pressure_1, pressure_2, p)
    return internal_leakage(load_pressure, p) + 0.5 * (lost_1 - lost_2)


@equation
def load_pressure_rate(flow: Scalar, velocity: Scalar, load_pressure: Scalar, p: Hydraulics) -> Scalar:
    """dP_L/dt (Pa/s) = 4 beta / V_t (Q_L - A v - Q_leak), held at |P_L| = P_s. Thesis (3.28) and 3.2.3 with leakage."""
    net = flow - piston_area(p) * velocity - load_leakage(load_pressure, p)
    rate = 4.0 * p.bulk_modulus / oil_volume(p) * net
    return select(
        load_pressure >= p.supply_pressure,
        np.minimum(rate, 0.0),
        select(load_pressure <= -p.supply_pressure, np.maximum(rate, 0.0), rate),
    )


@equation
def pressure_force(load_pressure: Scalar, p: Hydraulics) -> Scalar:
    """P1 A1 - P2 A2 (N). Thesis (3.29)."""
    pressure_1, pressure_2 = chamber_pressures(load_pressure, p)
    return pressure_1 * p.piston_area_1 - pressure_2 * p.piston_area_2


@equation
def end_stop_force(position: Scalar, velocity: Scalar, stroke: Scalar, p: Mass) -> Scalar:
    """Force (N) of the end stops on the mass; position 0 is the middle of the stroke.

    F = -sgn(x) k d max(1 + c d', 0) with d the penetration beyond +-stroke/2 (Hunt and Crossley 1975): damped,
    never sticking, and 0 inside the stroke.
    """
    side = np.sign(position)
    depth = np.maximum(np.abs(position) - 0.5 * stroke, 0.0)
    return -side * p.end_stop_stiffness * depth * np.maximum(1.0 + p.end_stop_damping * side * velocity, 0.0)


@equation
def piston_acceleration(
    position: Scalar,
    velocity: Scalar,
    load_pressure: Scalar,
    friction: Scalar,
    disturbance: Scalar,
    h: Hydraulics,
    m: Mass,
) -> Scalar:
    """dv/dt (m/s^2) = (P1 A1 - P2 A2 - F_friction - F_load - disturbance + end stops) / M. Thesis (3.29)."""
    stop = end_stop_force(position, velocity, h.stroke, m)
    return (pressure_force(load_pressure, h) - friction - m.load_force - disturbance + stop) / m.mass
