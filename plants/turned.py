"""A machine whose rod turns, or whose cylinder does around it, against friction along and around (thesis 3.3).

A motor that is fed with a voltage turns it, or it has an imposed speed of the surface, whatever torque that takes.
"""

import functools
from typing import Annotated, Any, NamedTuple

import numpy as np

from plants import motor as mot
from plants.actuators.interface import Actuator
from plants.equation import Scalar, equation, gathered, members
from plants.friction import helical_speed
from plants.interface import Balance, Measurement, Plant, unlimited
from plants.laws.interface import STICK_TIME, FrictionLaw
from plants.laws.lugre import named
from plants.motor import HasMotor
from plants.parts import (
    HYDRAULIC_POWER,
    Body,
    Disturbed,
    FrictionSignals,
    MotionSignals,
    PowerSignals,
    free_force_of,
    given,
    joined,
    own_of,
)


class MotorState(NamedTuple):
    surface_speed: Annotated[float, "m/s", 1e-1]
    motor_current: Annotated[float, "A", 1.0]


class MotorInputs(NamedTuple):
    motor_voltage: Annotated[float, "V"]


class ImposedInputs(NamedTuple):
    surface_speed: Annotated[float, "m/s"]


class TurningSignals(NamedTuple):
    """Current and voltage of an imposed speed are those of a motor that holds it."""

    surface_speed: Annotated[float, "m/s"]
    rotation_speed: Annotated[float, "rad/s"]
    helical_speed: Annotated[float, "m/s"]
    helical_friction: Annotated[float, "N"]
    rotary_friction: Annotated[float, "N"]
    motor_current: Annotated[float, "A"]
    rotation_power: Annotated[float, "W"]
    motor_electric_power: Annotated[float, "W"]


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


def motor_voltage_limit(p: HasMotor) -> float:
    """Limit (V) of the motor's drive."""
    return float(p.motor.motor_voltage_limit)


def rotary_inertia(p: HasMotor) -> tuple[float]:
    """J / r (N m s^2/m): the torque that an acceleration of the surface takes."""
    return (p.motor.rotary_inertia / p.motor.piston_radius,)


def inductance(p: HasMotor) -> tuple[float]:
    """L (V s/A): the voltage that a rate of the current takes."""
    return (p.motor.motor_inductance,)


TURNED_BY_MOTOR = {
    "rotation": Balance(("surface_speed",), "N m", rotary_inertia),
    "motor": Balance(("motor_current",), "V", inductance),
}


def name_of_turned(actuator: Actuator, bristle: str, imposed: bool) -> str:
    """Of the machine with a turning rod; the thesis's own is called by its bristle alone."""
    machine = "rotating" if actuator.name == "non_rotating" else f"rotating_{actuator.name}"
    return f"{machine}_{bristle}{'_ideal' if imposed else ''}"


@functools.cache
def turned(actuator: Actuator, law: FrictionLaw, bristle: str, imposed: bool) -> Plant:
    """The machine whose rod turns against the friction of a law, in its form for these bristles.

    `imposed`: at the surface speed that is its input; else by a motor that is fed with a voltage.
    """
    plane = law.plane[bristle]
    name = named(name_of_turned(actuator, bristle, imposed), law)
    bristles = {"contact": plane.Bristles}
    state_class = joined(f"State_{name}", actuator.Motion, actuator.State, bristles, *([] if imposed else [MotorState]))
    inputs_class = joined(f"Inputs_{name}", actuator.Inputs, ImposedInputs if imposed else MotorInputs, Disturbed)
    parameters_class = joined(f"Parameters_{name}", actuator.Parameters, Body, plane.Parameters, own_of(law))
    powered = HYDRAULIC_POWER in actuator.Signals._fields
    signals_class = joined(
        f"Signals_{name}",
        MotionSignals,
        actuator.Signals,
        FrictionSignals,
        TurningSignals,
        *([PowerSignals] if powered else []),
    )
    free_force, friction = free_force_of(actuator), plane.friction
    own_rates, own_signals = actuator.rates, actuator.signals
    own_pressures, own_position = actuator.pressures, actuator.position
    total = actuator.Signals._fields.index(HYDRAULIC_POWER) if powered else 0
    own_inputs = len(actuator.Inputs._fields)

    @equation
    def held_along(state: Any, inputs: Any, mass: Scalar, p: Any) -> Scalar:
        """Force (N) along the rod that would hold it, with the inertia `mass` (kg): see `plants.laws.interface`."""
        return free_force(state, inputs, p, 0.0) + mass * state.velocity / STICK_TIME

    @equation
    def driven_friction(state: Any, inputs: Any, p: Any) -> tuple[Scalar, Scalar, Any]:
        """Friction along and around (N) and the rates of the bristles, of a rod that a motor turns."""
        lighter = np.minimum(p.body.mass, p.motor.rotary_inertia / p.motor.piston_radius**2)
        around = p.motor.torque_constant * state.motor_current / p.motor.piston_radius
        held = (held_along(state, inputs, lighter, p), around + lighter * state.surface_speed / STICK_TIME)
        return friction(state.velocity, state.surface_speed, state.contact, held, p)

    @equation
    def imposed_friction(state: Any, inputs: Any, p: Any) -> tuple[Scalar, Scalar, Any]:
        """The same at an imposed speed."""
        held = held_along(state, inputs, p.body.mass, p), p.body.mass * inputs.surface_speed / STICK_TIME
        return friction(state.velocity, inputs.surface_speed, state.contact, held, p)

    @equation
    def driven_rates(state: Any, rotary: Scalar, inputs: Any, p: Any) -> tuple[Scalar, Scalar]:
        """Of surface speed and current. Thesis (3.53), (3.55)."""
        return (
            mot.surface_acceleration(state.motor_current, state.surface_speed, rotary, p.motor),
            mot.current_rate(state.motor_current, state.surface_speed, inputs.motor_voltage, p.motor),
        )

    @equation
    def imposed_rates(state: Any, rotary: Scalar, inputs: Any, p: Any) -> tuple[()]:
        """None: the speed is an input."""
        return ()

    @equation
    def driven_rotation(state: Any, rotary: Scalar, inputs: Any, p: Any) -> tuple[Scalar, Scalar, Scalar]:
        """Surface speed (m/s), the motor's current (A) and voltage (V)."""
        return state.surface_speed, state.motor_current, mot.drive_voltage(inputs.motor_voltage, p.motor)

    @equation
    def imposed_rotation(state: Any, rotary: Scalar, inputs: Any, p: Any) -> tuple[Scalar, Scalar, Scalar]:
        """The same of a motor that holds the speed."""
        current = mot.holding_current(rotary, inputs.surface_speed, p.motor)
        return inputs.surface_speed, current, mot.holding_voltage(current, inputs.surface_speed, p.motor)

    friction_on = imposed_friction if imposed else driven_friction
    turning_rates = imposed_rates if imposed else driven_rates
    rotation_of = imposed_rotation if imposed else driven_rotation

    @equation
    def derivatives(time: Scalar, state: Any, inputs: Any, p: Any) -> Any:
        """Rates of the states. Thesis (3.50) to (3.55)."""
        axial, rotary, bending = friction_on(state, inputs, p)
        acceleration = free_force(state, inputs, p, axial) / p.body.mass
        own, around = own_rates(state, inputs, p), turning_rates(state, rotary, inputs, p)
        return gathered(state_class, (state.velocity, acceleration, *own, bending, *around))

    @equation
    def signals(time: Scalar, state: Any, inputs: Any, p: Any) -> Any:
        """What is worth plotting. F_rotary w (thesis 4.17, 4.18) on the rod, V_m i at the motor's terminals."""
        axial, rotary, _ = friction_on(state, inputs, p)
        acceleration = free_force(state, inputs, p, axial) / p.body.mass
        own = own_signals(state, inputs, p)
        surface_speed, current, voltage = rotation_of(state, rotary, inputs, p)
        speed = helical_speed(state.velocity, surface_speed)
        rotation_power = rotary * surface_speed
        around = (
            surface_speed,
            surface_speed / p.motor.piston_radius,
            speed,
            (axial * state.velocity + rotary * surface_speed) / speed,
            rotary,
            current,
            rotation_power,
            voltage * current,
        )
        power = (own[total] + rotation_power,) if powered else ()
        moving = (state.position, state.velocity, acceleration)
        return gathered(signals_class, moving + own + (axial,) + around + power)

    @equation
    def measure_driven(state: Any, p: Any) -> Measurement:
        """Position, pressures where there are such, the speed of rotation and the motor's current."""
        pressure_1, pressure_2 = own_pressures(state, p)
        rotation_speed = state.surface_speed / p.motor.piston_radius
        return Measurement(own_position(state, p), pressure_1, pressure_2, rotation_speed, state.motor_current)

    @equation
    def measure_imposed(state: Any, p: Any) -> Measurement:
        """Position and pressures; an imposed speed needs no sensor and no motor (NaN)."""
        pressure_1, pressure_2 = own_pressures(state, p)
        return Measurement(own_position(state, p), pressure_1, pressure_2, np.nan, np.nan)

    def equilibrium(p: Any, surface_speed: float) -> tuple[NamedTuple, NamedTuple]:
        """At rest in mid-stroke, turning at `surface_speed` (m/s), the bristle bent around only."""
        bristles, rotary = plane.steady_rotation(p, surface_speed)
        states, inputs = actuator.equilibrium(p)
        if imposed:
            return state_class(0.0, 0.0, *states, bristles), given(
                inputs_class, actuator, inputs, surface_speed=surface_speed
            )
        current = float(mot.holding_current(rotary, surface_speed, p.motor))
        voltage = float(mot.holding_voltage(current, surface_speed, p.motor))
        state = state_class(0.0, 0.0, *states, bristles, surface_speed, current)
        return state, given(inputs_class, actuator, inputs, motor_voltage=voltage)

    def other(law: FrictionLaw) -> Plant:
        return turned(actuator, in_plane(law, bristle), bristle, imposed)

    return Plant(
        name=name,
        summary=f"{actuator.summary}, turning rod, {bristle} bristle, "
        + ("imposed speed of rotation" if imposed else "turned by a motor (thesis 3.3)"),
        State=state_class,
        Inputs=inputs_class,
        Parameters=parameters_class,
        Signals=signals_class,
        derivatives=derivatives,
        signals=signals,
        measure=measure_imposed if imposed else measure_driven,
        equilibrium=equilibrium,
        command_limit=actuator.command_limit,
        travel=actuator.travel,
        command=actuator.command,
        rotary_command=members(inputs_class)[own_inputs],
        rotary_limit=unlimited if imposed else motor_voltage_limit,
        balances={**actuator.balances, **({} if imposed else TURNED_BY_MOTOR)},
        friction=law.name,
        contact="contact",
        frozen_volumes=actuator.frozen_volumes,
        refit=other,
    )
