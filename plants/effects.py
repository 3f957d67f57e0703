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


class Number(NamedTuple):
    """Between which values (SI) a parameter of an effect may lie, and a `size` that is felt: where a search starts; 0
    for one that starts from the declared value of the other direction.
    """

    low: float
    high: float
    size: float


@dataclass(frozen=True, kw_only=True)
class Effect:
    """An effect: the balance on which it shows, and the parameters by which it acts.

    `words` say what it is to a reader who does not know its name. `numbers` are its parameters by canonical name, and
    `apart` the sets of them that may act alone, the smallest first: all together where none are given. `needs` are the
    channels without which it cannot be told, `acts_on` the signals over which it shows beyond those that are always
    looked at. A `circular` one is made of what it is to explain: the pressure carries every force that is not known.
    """

    name: str
    balance: str
    words: str
    source: str
    numbers: dict[str, Number]
    apart: tuple[tuple[str, ...], ...] = ()
    needs: tuple[str, ...] = ()
    acts_on: tuple[str, ...] = ()
    circular: bool = False

    @property
    def variants(self) -> tuple[tuple[str, ...], ...]:
        """The sets of its parameters that may act, the smallest first."""
        return self.apart or (tuple(self.numbers),)

    @property
    def signed(self) -> tuple[str, ...]:
        """Its parameters that may have either sign."""
        return tuple(name for name, number in self.numbers.items() if number.low < 0.0)


_ALL = (
    Effect(
        name="direction_asymmetry",
        balance="force",
        words="friction differs between the two directions",
        source="Owen 2001, tables 5.2 and 5.3",
        numbers={
            "coulomb_negative": Number(0.0, FREE, 0.0),
            "stribeck_negative": Number(0.0, FREE, 0.0),
            "viscous_negative": Number(0.0, FREE, 0.0),
        },
        apart=(
            ("coulomb_negative",),
            ("viscous_negative",),
            ("coulomb_negative", "stribeck_negative"),
            ("coulomb_negative", "viscous_negative"),
            ("coulomb_negative", "stribeck_negative", "viscous_negative"),
        ),
    ),
    Effect(
        name="position_dependent_friction",
        balance="force",
        words="friction changes along the stroke",
        source="Bonchis, Corke and Rye 1999",
        numbers={
            "friction_gradient": Number(-0.9, 0.9, 0.05),
            "friction_curvature": Number(-0.9, 5.0, 0.05),
        },
        apart=(
            ("friction_gradient",),
            ("friction_curvature",),
            ("friction_gradient", "friction_curvature"),
        ),
        needs=("position",),
    ),
    Effect(
        name="pressure_dependent_friction",
        balance="force",
        words="friction grows with the load pressure, as of a seal that is pressed by it",
        source="Bonchis, Corke and Rye 1999",
        numbers={
            "friction_per_pressure": Number(0.0, 0.01, 2e-05),
        },
        needs=("pressure_1",),
        circular=True,
    ),
    Effect(
        name="frictional_memory",
        balance="force",
        words="friction follows the velocity late",
        source="Hess and Soom 1990",
        numbers={
            "memory_time": Number(0.0, 0.5, 0.005),
        },
        acts_on=("acceleration",),
    ),
    Effect(
        name="rising_static_friction",
        balance="force",
        words="break-away friction grows with the time at rest",
        source="Armstrong-Helouvry, Dupont and Canudas de Wit 1994; Dieterich 1979",
        numbers={
            "static_rise": Number(0.0, 10.0, 0.2),
            "static_rise_time": Number(0.0, FREE, 0.0),
            "static_rise_distance": Number(0.0, FREE, 0.0),
        },
        apart=(
            ("static_rise",),
            ("static_rise", "static_rise_time"),
            ("static_rise", "static_rise_distance"),
            ("static_rise", "static_rise_time", "static_rise_distance"),
        ),
    ),
    Effect(
        name="quadratic_drag",
        balance="force",
        words="a resistance grows with the square of the velocity",
        source="Merritt 1967",
        numbers={
            "drag_coefficient": Number(0.0, 10000000.0, 1000.0),
        },
    ),
    Effect(
        name="viscous_drift",
        balance="force",
        words="viscous friction changes along the record, as of oil that warms up",
        source="oil that warms up",
        numbers={
            "viscous_drift": Number(-0.02, 0.2, 0.001),
        },
    ),
    Effect(
        name="constant_load",
        balance="force",
        words="a constant force acts on the rod",
        source="thesis (3.29)",
        numbers={
            "load_force": Number(-100000.0, 100000.0, 10.0),
        },
    ),
    Effect(
        name="spring_load",
        balance="force",
        words="a force grows with the position, as of a hose or cable that bends",
        source="hoses and cables",
        numbers={
            "spring_stiffness": Number(-10000000.0, 10000000.0, 1000.0),
        },
        needs=("position",),
    ),
    Effect(
        name="rotation_periodic_force",
        balance="force",
        words="a force repeats with every turn of the rod",
        source="a bent rod",
        numbers={
            "cosine_force": Number(-100000.0, 100000.0, 5.0),
            "sine_force": Number(-100000.0, 100000.0, 5.0),
        },
        needs=("rotation_angle",),
    ),
    Effect(
        name="valve_deadband",
        balance="flow",
        words="the spool has to move by its overlap before oil flows",
        source="Merritt 1967",
        numbers={
            "valve_overlap": Number(0.0, 0.0002, 2e-06),
        },
        needs=("valve_voltage",),
    ),
    Effect(
        name="internal_leakage",
        balance="flow",
        words="oil leaks from one chamber into the other",
        source="Merritt 1967",
        numbers={
            "leakage_coefficient": Number(0.0, 1e-09, 1e-13),
        },
        needs=("pressure_1",),
    ),
    Effect(
        name="supply_droop",
        balance="flow",
        words="the supply pressure falls when much oil is taken",
        source="Merritt 1967",
        numbers={
            "droop_resistance": Number(0.0, 100000000000.0, 100000000.0),
        },
        needs=("valve_voltage",),
    ),
    Effect(
        name="entrained_air",
        balance="flow",
        words="air makes the oil soft at low pressure",
        source="Merritt 1967",
        numbers={
            "air_fraction": Number(0.0, 0.2, 0.001),
        },
        needs=("pressure_1", "pressure_2"),
        acts_on=("pressure_1", "pressure_2"),
    ),
    Effect(
        name="unequal_areas",
        balance="flow",
        words="the second chamber's piston area is not the declared one",
        source="conservation of volume",
        numbers={
            "area_ratio": Number(0.2, 2.0, 0.97),
        },
    ),
    Effect(
        name="command_delay",
        balance="valve",
        words="the valve gets its command late",
        source="converters and networks",
        numbers={
            "command_delay": Number(0.0, 0.1, 0.001),
        },
        needs=("valve_voltage",),
    ),
    Effect(
        name="backlash",
        balance="sensor",
        words="the position sensor is coupled loosely to the rod",
        source="Nordin and Gutman 2002",
        numbers={
            "backlash_width": Number(0.0, 0.002, 1e-05),
        },
        needs=("position",),
    ),
    Effect(
        name="pressure_sensor_offset",
        balance="sensor",
        words="the first pressure sensor is off by a constant",
        source="zero of a transducer",
        numbers={
            "pressure_1_offset": Number(-1000000.0, 1000000.0, 5000.0),
        },
        needs=("pressure_1", "pressure_2"),
        acts_on=("pressure_1",),
    ),
)
EFFECTS = {effect.name: effect for effect in _ALL}
