"""A machine: what pushes a mass along, the friction of its rod by any law, and a part that turns the rod or does not.

    dv/dt = (F - F_friction - F_load - disturbance + end stops) / M

Friction lies along the rod, or where it turns along and around it (thesis 3.3): turned by a motor that is fed with a
voltage, or with an imposed speed of the surface, whatever torque that takes.
"""

import functools
import typing
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np

from plants import motor as mot
from plants.actuators.interface import Actuator
from plants.axis import LINEAR, along, unit_along
from plants.equation import Scalar, equation, fields, gathered, members, named_tuple
from plants.friction import Friction, helical_speed
from plants.hydraulics import Mass, end_stop_force
from plants.interface import Balance, Measurement, Plant, unlimited
from plants.laws.interface import STICK_TIME, FrictionLaw, Nothing, at_rest, friction_of
from plants.laws.lugre import named
from plants.motor import HasMotor

HYDRAULIC_POWER = "hydraulic_power"


class Disturbed(NamedTuple):
    """The input of every machine behind its own."""

    disturbance_force: Annotated[float, "N"]


class Body(NamedTuple):
    """Parameters of every machine."""

    body: Mass
    friction: Friction


class MotionSignals(NamedTuple):
    position: Annotated[float, "m"]
    velocity: Annotated[float, "m/s"]
    acceleration: Annotated[float, "m/s^2"]


class FrictionSignals(NamedTuple):
    axial_friction: Annotated[float, "N"]


class PowerSignals(NamedTuple):
    """Of a machine that fluid drives: hydraulic, and with rotation the rotary power too (thesis 4.19)."""

    total_power: Annotated[float, "W"]


class MotorState(NamedTuple):
    surface_speed: Annotated[float, "m/s", 1e-1]
    motor_current: Annotated[float, "A", 1.0]


class MotorInputs(NamedTuple):
    motor_voltage: Annotated[float, "V"]


class ImposedInputs(NamedTuple):
    surface_speed: Annotated[float, "m/s"]


ROTARY_INPUTS = (*MotorInputs._fields, *ImposedInputs._fields)


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


def joined(name: str, *parts: type[NamedTuple] | Mapping[str, type]) -> type:
    """A NamedTuple class with the members of several, or such as are named here, one behind another.

    Those with a default stand last, as a NamedTuple wants it.
    """
    members: dict[str, type] = {}
    defaults: dict[str, Any] = {}
    for part in parts:
        if isinstance(part, type):
            members |= typing.get_type_hints(part, include_extras=True)
            defaults |= part._field_defaults
        else:
            members |= part
    order = [*(key for key in members if key not in defaults), *defaults]
    return named_tuple(name, __name__, {key: members[key] for key in order}, defaults, f"Of the machine {name}.")


def contact_of(actuator: Actuator, law: FrictionLaw) -> dict[str, type]:
    """What the contact of a law remembers; a bristle's deflection with the magnitude that is typical of the machine."""
    return {"contact": actuator.Contact if actuator.Contact._fields == law.Contact._fields else law.Contact}


def own_of(law: FrictionLaw) -> dict[str, type]:
    """The parameters that a law has beside the contact's set, as a member of a machine's."""
    return {} if law.Extra is Nothing else {"law": law.Extra}


def given(cls: type, actuator: Actuator, own: Sequence[float], *rotary: float) -> NamedTuple:
    """Inputs of a machine that nothing disturbs: the actuator's own, and the rotary one, if there is such."""
    names = [*members(actuator.Inputs), *(name for name in ROTARY_INPUTS if name in members(cls)), *Disturbed._fields]
    return cls(**dict(zip(names, (*own, *rotary, 0.0), strict=True)))


def free_force_of(actuator: Actuator) -> Any:
    """The force (N) on the mass less a friction: an equation (state, inputs, parameters, friction) -> force."""
    push, stroke = actuator.force, actuator.stroke

    @equation
    def free_force(state: Any, inputs: Any, p: Any, friction: Scalar) -> Scalar:
        stop = end_stop_force(state.position, state.velocity, stroke(p), p.body)
        return push(state, inputs, p) - friction - p.body.load_force - inputs.disturbance_force + stop

    return free_force


@functools.cache
def straight(actuator: Actuator, law: FrictionLaw, axis: str = LINEAR) -> Plant:
    """The machine whose rod slides and does not turn; or along a turning `axis` the same in other units."""
    name = named(actuator.name, law)
    contact = contact_of(actuator, law)
    state_class = along(joined(f"State_{name}", actuator.Motion, actuator.State, contact), axis)
    inputs_class = along(joined(f"Inputs_{actuator.name}", actuator.Inputs, Disturbed), axis)
    parameters_class = along(joined(f"Parameters_{name}", actuator.Parameters, Body, own_of(law)), axis)
    powered = HYDRAULIC_POWER in actuator.Signals._fields
    power_signals = [PowerSignals] if powered else []
    signals_class = along(
        joined(f"Signals_{name}", MotionSignals, actuator.Signals, FrictionSignals, *power_signals, contact), axis
    )
    free_force = free_force_of(actuator)
    own_rates, own_signals = actuator.rates, actuator.signals
    own_pressures, own_position, still = actuator.pressures, actuator.position, actuator.rotation
    total = actuator.Signals._fields.index(HYDRAULIC_POWER) if powered else 0

    @equation
    def free_acceleration(state: Any, inputs: Any, p: Any) -> Scalar:
        """dv/dt (m/s^2) without friction."""
        return free_force(state, inputs, p, 0.0) / p.body.mass

    friction, unbent = friction_of(law, free_acceleration), at_rest(law)

    @equation
    def derivatives(time: Scalar, state: Any, inputs: Any, p: Any) -> Any:
        """Rates of the states."""
        opposed, bending = friction(state, inputs, p)
        acceleration = free_force(state, inputs, p, opposed) / p.body.mass
        return gathered(state_class, (state.velocity, acceleration, *own_rates(state, inputs, p), bending))

    @equation
    def signals(time: Scalar, state: Any, inputs: Any, p: Any) -> Any:
        """What is worth plotting."""
        opposed, _ = friction(state, inputs, p)
        acceleration = free_force(state, inputs, p, opposed) / p.body.mass
        own = own_signals(state, inputs, p)
        moving = (state.position, state.velocity, acceleration)
        power = (own[total],) if powered else ()
        return gathered(signals_class, moving + own + (opposed,) + power + (state.contact,))

    @equation
    def measure(state: Any, p: Any) -> Measurement:
        """Position, and pressures where there are such; the rod does not rotate."""
        pressure_1, pressure_2 = own_pressures(state, p)
        return Measurement(own_position(state, p), pressure_1, pressure_2, still, still)

    def equilibrium(p: Any, surface_speed: float) -> tuple[NamedTuple, NamedTuple]:
        """At rest in mid-stroke; this machine does not rotate."""
        states, inputs = actuator.equilibrium(p)
        return state_class(0.0, 0.0, *states, unbent), given(inputs_class, actuator, inputs)

    def with_turning_rod(bristle: str, imposed: bool) -> Plant:
        return turned(actuator, in_plane(law, bristle), bristle, imposed)

    return Plant(
        name=name,
        summary=actuator.summary,
        State=state_class,
        Inputs=inputs_class,
        Parameters=parameters_class,
        Signals=signals_class,
        derivatives=derivatives,
        signals=signals,
        measure=measure,
        equilibrium=equilibrium,
        command_limit=actuator.command_limit,
        travel=actuator.travel,
        command=fields(inputs_class)[0].name,
        balances={name: item._replace(unit=unit_along(item.unit, axis)) for name, item in actuator.balances.items()},
        friction=law.name,
        contact="contact",
        refit=lambda other: straight(actuator, other, axis),
        turned=with_turning_rod if axis == LINEAR else None,
    )


# --- a rod that turns -----------------------------------------------------------------------------------------


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
            return state_class(0.0, 0.0, *states, bristles), given(inputs_class, actuator, inputs, surface_speed)
        current = float(mot.holding_current(rotary, surface_speed, p.motor))
        voltage = float(mot.holding_voltage(current, surface_speed, p.motor))
        state = state_class(0.0, 0.0, *states, bristles, surface_speed, current)
        return state, given(inputs_class, actuator, inputs, voltage)

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
        refit=other,
    )
