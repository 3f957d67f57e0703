"""The rotating hydraulic actuator of thesis 3.3, turned by a motor that is fed with a voltage.

One plant for each friction law of `plants.laws` that has a form in the plane, and each of these forms, its bristles;
`plants.rotating_ideal` has the same with an imposed speed.
"""

import functools
from typing import Annotated, Any, NamedTuple

import numpy as np

from plants import hydraulics as hyd
from plants import motor as mot
from plants.bristles import AnisotropicParameters, BristleLaw, Parameters, PlaneBristle
from plants.equation import Scalar, equation, retyped
from plants.friction import helical_speed
from plants.interface import Balance, Measurement, Plant
from plants.laws.interface import STICK_TIME, FrictionLaw
from plants.laws.lugre import LUGRE, named
from plants.motor import HasMotor
from plants.non_rotating import BALANCES, holding_load_pressure, travel, voltage_limit


class State(NamedTuple):
    """Of one whose friction is the same along and around; other bristles stand in the field `bristles` for others."""

    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    load_pressure: Annotated[float, "Pa", 1e6]
    surface_speed: Annotated[float, "m/s", 1e-1]
    bristles: PlaneBristle
    motor_current: Annotated[float, "A", 1.0]
    spool_position: Annotated[float, "m", 1e-4]


class Inputs(NamedTuple):
    valve_voltage: Annotated[float, "V"]
    motor_voltage: Annotated[float, "V"]
    disturbance_force: Annotated[float, "N"]


class Signals(NamedTuple):
    position: Annotated[float, "m"]
    velocity: Annotated[float, "m/s"]
    acceleration: Annotated[float, "m/s^2"]
    load_pressure: Annotated[float, "Pa"]
    pressure_1: Annotated[float, "Pa"]
    pressure_2: Annotated[float, "Pa"]
    spool_position: Annotated[float, "m"]
    load_flow: Annotated[float, "m^3/s"]
    axial_friction: Annotated[float, "N"]
    surface_speed: Annotated[float, "m/s"]
    rotation_speed: Annotated[float, "rad/s"]
    helical_speed: Annotated[float, "m/s"]
    helical_friction: Annotated[float, "N"]
    rotary_friction: Annotated[float, "N"]
    motor_current: Annotated[float, "A"]
    hydraulic_power: Annotated[float, "W"]
    supply_power: Annotated[float, "W"]
    rotation_power: Annotated[float, "W"]
    motor_electric_power: Annotated[float, "W"]
    total_power: Annotated[float, "W"]


# --- what every variant shares -------------------------------------------------------------------------------


@equation
def hydraulic_rates(state: Any, inputs: Any, axial_friction: Scalar, p: Any) -> tuple[Scalar, Scalar, Scalar]:
    """Rates of velocity, load pressure and spool: (3.36), (3.37) and the valve, given the axial friction (N)."""
    h = p.hydraulics
    flow = hyd.load_flow(state.spool_position, state.load_pressure, h)
    force = inputs.disturbance_force
    return (
        hyd.piston_acceleration(state.position, state.velocity, state.load_pressure, axial_friction, force, h, p.body),
        hyd.load_pressure_rate(flow, state.velocity, state.load_pressure, h),
        hyd.spool_rate(state.spool_position, inputs.valve_voltage, h),
    )


@equation
def held_along(state: Any, inputs: Any, mass: Scalar, p: Any) -> Scalar:
    """Force (N) along the rod that would hold it, with the inertia `mass` (kg): see `plants.laws.interface`."""
    acceleration, _, _ = hydraulic_rates(state, inputs, 0.0, p)
    return p.body.mass * acceleration + mass * state.velocity / STICK_TIME


@equation
def all_signals(
    state: Any,
    inputs: Any,
    friction: tuple[Scalar, Scalar],
    rotation: tuple[Scalar, Scalar, Scalar],
    p: Any,
) -> Signals:
    """All signals, given axial and rotary friction (N) and surface speed (m/s), motor current (A), voltage (V).

    Power: P_L Q_L (thesis 4.16, without the oil's compression), P_s |Q_L| from the pump, F_rotary w (4.17, 4.18)
    on the rod, V_m i at the motor's terminals; total: hydraulic and rotary (4.19).
    """
    h = p.hydraulics
    axial, rotary = friction
    surface_speed, current, voltage = rotation
    acceleration, _, _ = hydraulic_rates(state, inputs, axial, p)
    flow = hyd.load_flow(state.spool_position, state.load_pressure, h)
    pressure_1, pressure_2 = hyd.chamber_pressures(state.load_pressure, h)
    speed = helical_speed(state.velocity, surface_speed)
    hydraulic_power, rotation_power = state.load_pressure * flow, rotary * surface_speed
    return Signals(
        state.position,
        state.velocity,
        acceleration,
        state.load_pressure,
        pressure_1,
        pressure_2,
        state.spool_position,
        flow,
        axial,
        surface_speed,
        surface_speed / p.motor.piston_radius,
        speed,
        (axial * state.velocity + rotary * surface_speed) / speed,
        rotary,
        current,
        hydraulic_power,
        h.supply_pressure * np.abs(flow),
        rotation_power,
        voltage * current,
        hydraulic_power + rotation_power,
    )


@equation
def readings(state: Any, surface_speed: Scalar, current: Scalar, p: Any) -> Measurement:
    pressure_1, pressure_2 = hyd.chamber_pressures(state.load_pressure, p.hydraulics)
    return Measurement(state.position, pressure_1, pressure_2, surface_speed / p.motor.piston_radius, current)


def with_bristles(template: type[NamedTuple], plane: BristleLaw) -> type:
    """The class of states of a plant with these bristles, made from that with the bristle in the plane."""
    if plane.Bristles is PlaneBristle:
        return template
    return retyped(template, plane.Bristles.__name__, bristles=plane.Bristles)


def in_plane(law: FrictionLaw, bristle: str) -> FrictionLaw:
    """The law, which has a form for these bristles.

    Raises:
        ValueError: it has not.
    """
    if bristle not in law.plane:
        forms = ", ".join(f'"{name}"' for name in law.plane)
        expected = f"expected bristle = {forms}" if forms else "expected a rod that does not rotate, or another law"
        raise ValueError(f'friction "{law.name}" has no form for a turning rod with bristle "{bristle}"; {expected}')
    return law


# --- turned by a motor ---------------------------------------------------------------------------------------


@equation
def measure(state: Any, p: Any) -> Measurement:
    """Position, both pressures, the speed of rotation and the motor's current."""
    return readings(state, state.surface_speed, state.motor_current, p)


def motor_voltage_limit(p: HasMotor) -> float:
    """Limit (V) of the motor's drive."""
    return float(p.motor.motor_voltage_limit)


def rotary_inertia(p: HasMotor) -> tuple[float]:
    """J / r (N m s^2/m): the torque that an acceleration of the surface takes."""
    return (p.motor.rotary_inertia / p.motor.piston_radius,)


def inductance(p: HasMotor) -> tuple[float]:
    """L (V s/A): the voltage that a rate of the current takes."""
    return (p.motor.motor_inductance,)


@functools.cache
def turned_by_motor(law: FrictionLaw, bristle: str) -> Plant:
    """The plant whose rod a motor turns against the friction of a law, in its form for these bristles."""
    plane = law.plane[bristle]
    friction, state_class = plane.friction, with_bristles(State, plane)

    @equation
    def friction_of(state: Any, inputs: Inputs, p: Any) -> tuple[Scalar, Scalar, Any]:
        """Friction along and around (N) and the rates of the bristles."""
        inertia = p.motor.rotary_inertia / p.motor.piston_radius**2
        lighter = np.minimum(p.body.mass, inertia)
        around = p.motor.torque_constant * state.motor_current / p.motor.piston_radius
        held = (
            held_along(state, inputs, lighter, p),
            around + lighter * state.surface_speed / STICK_TIME,
        )
        return friction(state.velocity, state.surface_speed, state.bristles, held, p)

    @equation
    def derivatives(time: Scalar, state: Any, inputs: Inputs, p: Any) -> Any:
        """Rates of the states. Thesis (3.50) to (3.55) with the valve of 3.2.1."""
        axial, rotary, rates = friction_of(state, inputs, p)
        acceleration, pressure_rate, spool_rate = hydraulic_rates(state, inputs, axial, p)
        return state_class(
            state.velocity,
            acceleration,
            pressure_rate,
            mot.surface_acceleration(state.motor_current, rotary, p.motor),
            rates,
            mot.current_rate(state.motor_current, state.surface_speed, inputs.motor_voltage, p.motor),
            spool_rate,
        )

    @equation
    def signals(time: Scalar, state: Any, inputs: Inputs, p: Any) -> Signals:
        """What is worth plotting; see `Signals`."""
        axial, rotary, _ = friction_of(state, inputs, p)
        rotation = (state.surface_speed, state.motor_current, mot.drive_voltage(inputs.motor_voltage, p.motor))
        return all_signals(state, inputs, (axial, rotary), rotation, p)

    def equilibrium(p: Parameters | AnisotropicParameters, surface_speed: float) -> tuple[NamedTuple, Inputs]:
        """At rest in mid-stroke, turning at `surface_speed` (m/s), the bristle bent around only."""
        bristles, rotary = plane.steady_rotation(p, surface_speed)
        current = float(mot.holding_current(rotary, p.motor))
        voltage = float(mot.holding_voltage(current, surface_speed, p.motor))
        pressure = holding_load_pressure(p.hydraulics, p.body)
        return state_class(0.0, 0.0, pressure, surface_speed, bristles, current, 0.0), Inputs(0.0, voltage, 0.0)

    return Plant(
        name=named(f"rotating_{bristle}", law),
        summary=f"rotating cylinder, {bristle} bristle, turned by a motor (thesis 3.3)",
        State=state_class,
        Inputs=Inputs,
        Parameters=plane.Parameters,
        Signals=Signals,
        derivatives=derivatives,
        signals=signals,
        measure=measure,
        equilibrium=equilibrium,
        command_limit=voltage_limit,
        travel=travel,
        command="valve_voltage",
        rotary_command="motor_voltage",
        rotary_limit=motor_voltage_limit,
        balances={
            **BALANCES,
            "rotation": Balance(("surface_speed",), "N m", rotary_inertia),
            "motor": Balance(("motor_current",), "V", inductance),
        },
        friction=law.name,
        contact="bristles",
        refit=lambda other: turned_by_motor(in_plane(other, bristle), bristle),
    )


HELICAL, ISOTROPIC, ANISOTROPIC = (turned_by_motor(LUGRE, bristle) for bristle in LUGRE.plane)
