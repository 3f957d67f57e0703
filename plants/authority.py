"""What a valve can do with a cylinder: the speed that an opening gives against a force, and how stiff the fluid is.

    v = x_o c sqrt(F_stall -+ F)      forward and backward, each with a c and a stall force of its own

Both edges of the direction pass the same motion, and P1 A1 - P2 A2 = F: for oil this is exact where speeds are steady
(thesis (3.22) with equal areas, Jelali and Kroll 2003 without), for air a curve through the speed without load and the
force without speed. Controllers believe in it.
"""

from typing import Annotated, NamedTuple

import numpy as np

from plants.equation import Scalar, equation, select
from plants.hydraulics import Cylinder, Hydraulic, Hydraulics, oil_volumes
from plants.pneumatics import (
    Pneumatic,
    Pneumatics,
    air_volumes,
    flow_share,
    normal_flow,
    specific_energy,
)
from plants.rising import rising


class Way(NamedTuple):
    """One direction of motion: speed an opening and root of a force, and the force at which the piston stalls."""

    speed_gain: Annotated[float, "1/(s N^0.5)"]
    stall_force: Annotated[float, "N"]


class Authority(NamedTuple):
    """Both directions, the valve's gain, lag and overlap, and the stiffness of the fluid at mid-stroke."""

    forward: Way
    backward: Way
    position_gain: Annotated[float, "m/V"]
    time_constant: Annotated[float, "s"]
    stiffness: Annotated[float, "N/m"]
    dead_band: Annotated[float, "V"]


NONE = Authority(Way(0.0, 0.0), Way(0.0, 0.0), 0.0, 0.0, 0.0, 0.0)
"""Of what has no valve."""


@equation
def speed_of_opening(velocity: Scalar, force: Scalar, least: Scalar, a: Authority) -> Scalar:
    """Speed (m/s) an opening (m) towards `velocity`, against the `force` (N) on the piston that the load takes.

    What is left of the stall force counts as at least its share `least`: the root must not vanish.
    """
    forward = velocity >= 0.0
    gain = select(forward, a.forward.speed_gain, a.backward.speed_gain)
    stall = select(forward, a.forward.stall_force, a.backward.stall_force)
    left = stall - np.sign(velocity) * force
    return gain * np.sqrt(np.maximum(left, least * stall))


def authority(p: Hydraulic | Pneumatic) -> Authority:
    """Of a cylinder that a valve feeds with oil or air."""
    return _of_air(p.pneumatics) if isinstance(p, Pneumatic) else _of_oil(p)


def velocity_gains(a: Authority) -> tuple[float, float]:
    """K_q (m/s per V) forward and backward: velocity of the unloaded piston for one volt at the valve."""
    ways = (a.forward, a.backward)
    forward, backward = (way.speed_gain * float(np.sqrt(way.stall_force)) * a.position_gain for way in ways)
    return forward, backward


def _of_oil(p: Hydraulic) -> Authority:
    """c = ((A1^3/K_pa^2 + A2^3/K_bt^2))^-1/2, F_stall = P_s A1 - P_T A2 forward; K_xy = K g_xy sqrt(2 share)."""
    h = p.hydraulics
    own = getattr(p, "cylinder", Cylinder())
    root = h.valve_flow_gain * np.sqrt(2.0 * h.flow_pressure_share)

    def way(filled: float, fills: float, emptied: float, empties: float) -> Way:
        stall = h.supply_pressure * filled - h.tank_pressure * emptied
        if stall <= 0.0:
            raise ValueError(
                f"a supply of {h.supply_pressure:g} Pa on {filled:g} m^2 does not move the piston against the tank's "
                f"{h.tank_pressure:g} Pa on {emptied:g} m^2"
            )
        resistance = filled**3 / (root * fills) ** 2 + emptied**3 / (root * empties) ** 2
        return Way(float(resistance**-0.5), stall)

    volumes = oil_volumes(0.0, h, own)
    return _authority(
        way(h.piston_area_1, own.edge_gain_pa, h.piston_area_2, own.edge_gain_bt),
        way(h.piston_area_2, own.edge_gain_pb, h.piston_area_1, own.edge_gain_at),
        h,
        stiffness(h, volumes, (h.bulk_modulus, h.bulk_modulus)),
    )


def stiffness(areas: Hydraulics | Pneumatics, volumes: tuple[float, float], moduli: tuple[float, float]) -> float:
    """k = B_1 A1^2/V_1 + B_2 A2^2/V_2 (N/m): of enclosed fluid, B the bulk modulus of either side (Pa)."""
    (volume_1, volume_2), (modulus_1, modulus_2) = volumes, moduli
    return float(modulus_1 * areas.piston_area_1**2 / volume_1 + modulus_2 * areas.piston_area_2**2 / volume_2)


def _authority(forward: Way, backward: Way, valve: Hydraulics | Pneumatics, stiff: float) -> Authority:
    gain = valve.valve_position_gain
    return Authority(forward, backward, gain, valve.valve_time_constant, stiff, valve.valve_overlap / gain)


def _of_air(p: Pneumatics) -> Authority:
    """Through the speed without load and the force without speed; stiff as at the supply's half pressure."""

    def way(filled: float, emptied: float) -> Way:
        stall = p.supply_pressure * filled
        return Way(_unloaded_speed(p, filled, emptied) / p.spool_limit / float(np.sqrt(stall)), stall)

    modulus = p.polytropic_exponent * (0.5 * p.supply_pressure + p.ambient_pressure)
    return _authority(
        way(p.piston_area_1, p.piston_area_2),
        way(p.piston_area_2, p.piston_area_1),
        p,
        stiffness(p, air_volumes(0.0, p), (modulus, modulus)),
    )


def _unloaded_speed(p: Pneumatics, filled: float, emptied: float) -> float:
    """Steady speed (m/s) without load at full opening: what fills, and what empties against it, pass the same motion.

    C k P_s psi(P_in/P_s) = P_in A_in v,  C g k psi(P_atm/P_out) = A_out v,  k = rho_0 sqrt(T_0/T) R T,
    P_in A_in - P_out A_out = P_atm (A_in - A_out).
    """
    volume = p.sonic_conductance * float(normal_flow(p) * specific_energy(p))
    supply, ambient = p.supply_pressure + p.ambient_pressure, p.ambient_pressure
    critical, fastest = p.critical_pressure_ratio, p.exhaust_gain * volume / emptied

    def lacking(speed: float) -> float:
        """Force (N) that the piston lacks at a speed."""
        share = min(speed / fastest, 1.0)
        behind = ambient / (critical + (1.0 - critical) * float(np.sqrt(1.0 - share**2)))
        before = _filling_ratio(p, speed * filled / volume) * supply
        return ambient * (filled - emptied) - (before * filled - behind * emptied)

    return rising(lacking, 0.0, fastest)


def _filling_ratio(p: Pneumatics, taken: float) -> float:
    """Pressure of a chamber over the supply's at which it takes psi(y) / y = `taken`."""
    return rising(lambda ratio: taken * ratio - float(flow_share(ratio, p.critical_pressure_ratio)), 0.0, 1.0)
