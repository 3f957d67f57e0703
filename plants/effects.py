"""What a machine may have beyond the thesis's equations: one physical term each, neutral at its default.

Each term is written once. Evaluated along a measured motion it is a candidate for what a model lacks; in
`plants.two_chamber` it is simulated. `plants.effect_list` names them, with the parameters by which they act. Some act
by parameters that every plant has: friction that differs with direction, a load, the valve's overlap, leakage, areas.
"""

from typing import Annotated, NamedTuple

import numpy as np

from plants.equation import Scalar, equation, select
from plants.friction import LuGre

LEAST_FRICTION = 0.05
"""Share of its friction that a contact keeps along the stroke. With none at all LuGre's bristle would be renewed at
once, and no solver could follow it."""

SHORTEST_MEMORY = 1e-4
"""s. A memory that is shorter is simulated with this one: the bristle itself is no faster."""

ATMOSPHERE = 101325.0
"""Pa. Pressures of a record are relative to it."""


class FrictionEffects(NamedTuple):
    """What changes friction, or adds to it."""

    friction_gradient: Annotated[float, "1"] = 0.0
    friction_curvature: Annotated[float, "1"] = 0.0
    friction_per_pressure: Annotated[float, "N/Pa"] = 0.0
    memory_time: Annotated[float, "s"] = 0.0
    static_rise: Annotated[float, "1"] = 0.0
    static_rise_time: Annotated[float, "s"] = 1.0
    static_rise_distance: Annotated[float, "m"] = 1e-4
    drag_coefficient: Annotated[float, "N s^2/m^2"] = 0.0
    viscous_drift: Annotated[float, "1/s"] = 0.0
    spring_stiffness: Annotated[float, "N/m"] = 0.0
    cosine_force: Annotated[float, "N"] = 0.0
    sine_force: Annotated[float, "N"] = 0.0


class FlowEffects(NamedTuple):
    """What changes supply and oil."""

    droop_resistance: Annotated[float, "Pa s/m^3"] = 0.0
    air_fraction: Annotated[float, "1"] = 0.0


@equation
def affected_contact(
    contact: LuGre,
    position: Scalar,
    load_pressure: Scalar,
    time: Scalar,
    rested: Scalar,
    stroke: Scalar,
    e: FrictionEffects,
) -> LuGre:
    """The contact's LuGre set with what position, pressure, time and rest make of it.

        a0 <- a0 f + c |P_L|,   a1 <- a1 f (1 + s r),   a2 <- a2 (1 + d t),   f = 1 + b1 xi + b2 xi^2,  xi = 2 x / L

    `position` x (m) from mid-stroke, `load_pressure` P_L (Pa), `time` t (s) since the record began, `rested` r in [0,
    1].

    position_dependent_friction (b1, b2): wear and seal fit along the bore (Bonchis, Corke and Rye 1999). Looks like
    friction that is larger at one end or in the middle; a spring load is the same without changing sign with the
    velocity. pressure_dependent_friction (c): a seal pressed by what it seals (Bonchis et al. 1999). Looks like
    friction that grows with the load; a poorly fitted bristle leaves a residual that |P_L| sgn(v) explains as well.
    rising_static_friction (s): break-away grows with the time at rest (Armstrong-Helouvry et al. 1994). Looks like a
    higher peak after long holds; noise of the velocity in holds looks alike.
    viscous_drift (d): oil warms up. Looks like a slope of friction that changes along the record.
    """
    along = 2.0 * position / stroke
    shape = np.maximum(1.0 + e.friction_gradient * along + e.friction_curvature * along**2, LEAST_FRICTION)
    return LuGre(
        contact.coulomb * shape + e.friction_per_pressure * np.abs(load_pressure),
        contact.stribeck * shape * (1.0 + e.static_rise * rested),
        contact.viscous * np.maximum(1.0 + e.viscous_drift * time, 0.0),
        contact.stribeck_velocity,
        contact.bristle_stiffness,
        contact.bristle_damping,
    )


@equation
def lagged_rate(velocity: Scalar, lagged: Scalar, e: FrictionEffects) -> Scalar:
    """Rate (m/s^2) of the velocity at which the Stribeck curve is taken, dv_m/dt = (v - v_m)/tau_m; 0 without memory.

    frictional_memory: friction follows velocity late (Hess and Soom 1990), here by a lag of first order. Looks like
    loops of friction over velocity while sliding; a command's delay or a velocity that is filtered more than the
    pressures looks alike.
    """
    return select(e.memory_time > 0.0, (velocity - lagged) / np.maximum(e.memory_time, SHORTEST_MEMORY), 0.0)


@equation
def stribeck_speed(velocity: Scalar, lagged: Scalar, e: FrictionEffects) -> Scalar:
    """The velocity (m/s) at which the Stribeck curve is taken: the lagged one where there is memory."""
    return select(e.memory_time > 0.0, lagged, velocity)


@equation
def rested_rate(slip: Scalar, rested: Scalar, e: FrictionEffects) -> Scalar:
    """Rate (1/s) of the share r of its rise that static friction has made, dr/dt = (1 - r)/T - |s| r/D.

    rising_static_friction: the law of contacts that age (Dieterich 1979, Ruina 1983), here with an end: up at rest in
    the time T, forgotten within the distance D of sliding. `slip` s = v - dz/dt (m/s): a bristle that bends is not
    renewed.
    """
    return (1.0 - rested) / e.static_rise_time - np.abs(slip) * rested / e.static_rise_distance


@equation
def added_force(position: Scalar, velocity: Scalar, angle: Scalar, e: FrictionEffects) -> Scalar:
    """Force (N) against the motion beside friction: c v |v| + k x + A cos(theta) + B sin(theta).

    quadratic_drag (c): turbulent flow through ports and lines (Merritt 1967). Looks like resistance that bends upward
    at speed; a Stribeck velocity that is off looks alike at low speed.
    spring_load (k): what bends as it moves, such as hoses or a cable. Looks like a force in step with the position.
    rotation_periodic_force (A, B): a bent rod, a coupling off its axis. Looks like a ripple with the angle theta (rad).
    """
    swing = e.cosine_force * np.cos(angle) + e.sine_force * np.sin(angle)
    return e.drag_coefficient * velocity * np.abs(velocity) + e.spring_stiffness * position + swing


@equation
def drooped_supply(supply_pressure: Scalar, pump_flow: Scalar, e: FlowEffects) -> Scalar:
    """Supply pressure (Pa) at a flow (m^3/s) taken from the pump: P_s - R |Q|.

    supply_droop: a supply line, or a pump at its limit. Looks like flow that saturates with speed; a smaller gain of
    the valve looks alike where speeds vary little.
    """
    return supply_pressure - e.droop_resistance * np.abs(pump_flow)


@equation
def compliance(pressure: Scalar, bulk_modulus: Scalar, e: FlowEffects) -> Scalar:
    """1/beta_eff (1/Pa) of oil with a volume fraction alpha of air: 1/beta + alpha P_atm / P_abs^2 (isothermal).

    entrained_air (Merritt 1967). Looks like oil that is soft at low pressure and stiff at high.
    """
    absolute = np.maximum(pressure, 0.0) + ATMOSPHERE
    return 1.0 / bulk_modulus + e.air_fraction * ATMOSPHERE / absolute**2


@equation
def gap_rate(velocity: Scalar, gap: Scalar, width: Scalar) -> Scalar:
    """Rate (m/s) of the distance by which a sensor behind a backlash is ahead of the rod: -v until a flank carries it.

    backlash: a loose coupling between rod and sensor (Nordin and Gutman 2002). Looks like a position that rests at each
    reversal while oil flows; presliding looks alike, but the pressure then follows the position.
    """
    behind = select(gap <= -0.5 * width, np.minimum(velocity, 0.0), velocity)  # a flank carries the sensor forward
    return -select(gap >= 0.5 * width, np.maximum(behind, 0.0), behind)
