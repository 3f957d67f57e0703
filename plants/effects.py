"""What a machine may have beyond the thesis's equations: one physical term each, neutral at its default.

Each term is written once. Evaluated along a measured motion it is a candidate for what a model lacks; in
`plants.two_chamber` it is simulated. `EFFECTS` names them, with the parameters by which they act. Some act by
parameters that every plant has: friction that differs with direction, a load, the valve's overlap, leakage, areas.
"""

from dataclasses import dataclass
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


FREE = 1e300
"""No bound."""


@dataclass(frozen=True)
class Effect:
    """An effect by name: the balance on which it shows, and the parameters by which it acts.

    `numbers` has for each parameter (canonical name) its bounds, and a size (SI) that is felt: where a search starts; 0
    for one that starts from the declared value of the other direction. `variants` are the sets of them that may act
    alone, the smallest first. `needs` are the channels without which it cannot be told. A `circular` one
    is made of what it is to explain: the pressure carries every force that is not known.
    """

    name: str
    balance: str
    source: str
    numbers: dict[str, tuple[float, float, float]]
    variants: tuple[tuple[str, ...], ...]
    needs: tuple[str, ...] = ()
    circular: bool = False


def _effect(
    name: str,
    balance: str,
    source: str,
    numbers: dict[str, tuple[float, float, float]],
    variants: tuple[tuple[str, ...], ...] = (),
    needs: tuple[str, ...] = (),
    circular: bool = False,
) -> Effect:
    return Effect(name, balance, source, numbers, variants or (tuple(numbers),), needs, circular)


_ALL = (
    _effect(
        "direction_asymmetry",
        "force",
        "Owen 2001, tables 5.2 and 5.3",
        {
            "coulomb_negative": (0.0, FREE, 0.0),
            "stribeck_negative": (0.0, FREE, 0.0),
            "viscous_negative": (0.0, FREE, 0.0),
        },
        (
            ("coulomb_negative",),
            ("viscous_negative",),
            ("coulomb_negative", "stribeck_negative"),
            ("coulomb_negative", "viscous_negative"),
            ("coulomb_negative", "stribeck_negative", "viscous_negative"),
        ),
    ),
    _effect(
        "position_dependent_friction",
        "force",
        "Bonchis, Corke and Rye 1999",
        {"friction_gradient": (-0.9, 0.9, 0.05), "friction_curvature": (-0.9, 5.0, 0.05)},
        (("friction_gradient",), ("friction_curvature",), ("friction_gradient", "friction_curvature")),
        ("position",),
    ),
    _effect(
        "pressure_dependent_friction",
        "force",
        "Bonchis, Corke and Rye 1999",
        {"friction_per_pressure": (0.0, 1e-2, 2e-5)},
        needs=("pressure_1",),
        circular=True,
    ),
    _effect("frictional_memory", "force", "Hess and Soom 1990", {"memory_time": (0.0, 0.5, 5e-3)}),
    _effect(
        "rising_static_friction",
        "force",
        "Armstrong-Helouvry, Dupont and Canudas de Wit 1994; Dieterich 1979",
        {
            "static_rise": (0.0, 10.0, 0.2),
            "static_rise_time": (0.0, FREE, 0.0),
            "static_rise_distance": (0.0, FREE, 0.0),
        },
        (
            ("static_rise",),
            ("static_rise", "static_rise_time"),
            ("static_rise", "static_rise_distance"),
            ("static_rise", "static_rise_time", "static_rise_distance"),
        ),
    ),
    _effect("quadratic_drag", "force", "Merritt 1967", {"drag_coefficient": (0.0, 1e7, 1e3)}),
    _effect("viscous_drift", "force", "oil that warms up", {"viscous_drift": (-0.02, 0.2, 1e-3)}),
    _effect("constant_load", "force", "thesis (3.29)", {"load_force": (-1e5, 1e5, 10.0)}),
    _effect("spring_load", "force", "hoses and cables", {"spring_stiffness": (-1e7, 1e7, 1e3)}, needs=("position",)),
    _effect(
        "rotation_periodic_force",
        "force",
        "a bent rod",
        {"cosine_force": (-1e5, 1e5, 5.0), "sine_force": (-1e5, 1e5, 5.0)},
        needs=("rotation_angle",),
    ),
    _effect("valve_deadband", "flow", "Merritt 1967", {"valve_overlap": (0.0, 2e-4, 2e-6)}, needs=("valve_voltage",)),
    _effect(
        "internal_leakage", "flow", "Merritt 1967", {"leakage_coefficient": (0.0, 1e-9, 1e-13)}, needs=("pressure_1",)
    ),
    _effect("supply_droop", "flow", "Merritt 1967", {"droop_resistance": (0.0, 1e11, 1e8)}, needs=("valve_voltage",)),
    _effect(
        "entrained_air", "flow", "Merritt 1967", {"air_fraction": (0.0, 0.2, 1e-3)}, needs=("pressure_1", "pressure_2")
    ),
    _effect("unequal_areas", "flow", "conservation of volume", {"area_ratio": (0.2, 2.0, 0.97)}),
    _effect(
        "command_delay",
        "valve",
        "converters and networks",
        {"command_delay": (0.0, 0.1, 1e-3)},
        needs=("valve_voltage",),
    ),
    _effect("backlash", "sensor", "Nordin and Gutman 2002", {"backlash_width": (0.0, 2e-3, 1e-5)}, needs=("position",)),
    _effect(
        "pressure_sensor_offset",
        "sensor",
        "zero of a transducer",
        {"pressure_1_offset": (-1e6, 1e6, 5e3)},
        needs=("pressure_1", "pressure_2"),
    ),
)
EFFECTS = {effect.name: effect for effect in _ALL}
