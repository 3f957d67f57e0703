"""A machine: what pushes a mass along, the friction of its rod by any law, and a part that turns the rod or does not.

    dv/dt = (F - F_friction - F_load - disturbance + end stops) / M

Friction lies along the rod, or where it turns along and around it (`plants.turned`).
"""

import functools
from typing import Any, NamedTuple

from plants.actuators.interface import Actuator
from plants.axis import LINEAR, along, unit_along
from plants.equation import Scalar, equation, fields, gathered
from plants.interface import Measurement, Plant
from plants.laws.interface import FrictionLaw, at_rest, friction_of
from plants.laws.lugre import named
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
from plants.turned import in_plane, turned


def contact_of(actuator: Actuator, law: FrictionLaw) -> dict[str, type]:
    """What the contact of a law remembers; a bristle's deflection with the magnitude that is typical of the machine."""
    return {"contact": actuator.Contact if actuator.Contact._fields == law.Contact._fields else law.Contact}


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
        frozen_volumes=actuator.frozen_volumes,
        refit=lambda other: straight(actuator, other, axis),
        turned=with_turning_rod if axis == LINEAR else None,
    )
