"""A drive whose motor moves its load through a compliance: two masses, or two inertias where it turns.

The load is that of `plants.drive`, which the coupling's force moves in place of the source's: friction by any law, end
stops, an optional spring. The motor has a mass and viscous friction of its own. `position` and `velocity` are the
load's; the sensor shows its position or the motor's (`measured_at`). With a coupling that does not give it is that
drive, whose mass is both and whose viscous friction is both. It has no balance by which a record could be diagnosed: no
sensor shows the motor beside the load.
"""

import functools
from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.axis import LINEAR, ROTARY, along, name_along
from plants.coupling import Coupling, coupling_force, measured_position, motor_acceleration
from plants.drive import Bristle, spring_force, sum_of_forces, travel
from plants.equation import Scalar, equation, fields, retyped
from plants.friction import Friction
from plants.hydraulics import Mass
from plants.interface import Measurement, Plant
from plants.laws.interface import FrictionLaw, at_rest, fitted, friction_of
from plants.laws.lugre import LUGRE, named
from plants.sources import CURRENT, FORCE, VOLTAGE, ForceLimits, Source


class State(NamedTuple):
    position: Annotated[float, "m", 1e-3]
    velocity: Annotated[float, "m/s", 1e-2]
    contact: Bristle
    twist: Annotated[float, "m", 1e-4]
    motor_velocity: Annotated[float, "m/s", 1e-2]


class Parameters(NamedTuple):
    body: Mass
    friction: Friction
    coupling: Coupling
    source: ForceLimits
    stroke: Annotated[float, "m"] = np.inf
    spring_stiffness: Annotated[float, "N/m"] = 0.0


class Signals(NamedTuple):
    position: Annotated[float, "m"]
    velocity: Annotated[float, "m/s"]
    acceleration: Annotated[float, "m/s^2"]
    contact: Bristle
    axial_friction: Annotated[float, "N"]
    drive_force: Annotated[float, "N"]
    spring_force: Annotated[float, "N"]
    motor_position: Annotated[float, "m"]
    motor_velocity: Annotated[float, "m/s"]
    coupling_force: Annotated[float, "N"]


@equation
def through(state: Any, p: Any) -> Scalar:
    """Force (N) of the coupling on the load."""
    return coupling_force(state.twist, state.motor_velocity, state.velocity, p.coupling)


@equation
def measure(state: State, p: Any) -> Measurement:
    """The position of the motor, or that of the load."""
    return Measurement(measured_position(state.position, state.twist, p.coupling), np.nan, np.nan, np.nan, np.nan)


FAMILIES = {LINEAR: "two_mass", ROTARY: "two_inertia"}
"""What the names of these plants begin with, by their axis."""

PARTS = {LINEAR: "masses", ROTARY: "inertias"}


@functools.cache
def two_mass(law: FrictionLaw, source: Source, axis: str = LINEAR) -> Plant:
    """The drive with a compliant coupling, a friction law at its load and a source of force at its motor."""
    fitted_classes = fitted(law, State, retyped(Parameters, source.name, source=source.Parameters), Signals)
    state_class, parameters_class, signals_class = (along(cls, axis) for cls in fitted_classes)
    inputs_class, gain, limit = along(source.Inputs, axis), source.gain, source.limit

    @equation
    def free_acceleration(state: Any, inputs: Any, p: Any) -> Scalar:
        """dv/dt (m/s^2) of the load without friction."""
        return sum_of_forces(state, through(state, p), 0.0, inputs, p) / p.body.mass

    friction, unbent = friction_of(law, free_acceleration), at_rest(law)

    @equation
    def derivatives(time: Scalar, state: Any, inputs: Any, p: Any) -> Any:
        """Rates of the states."""
        opposed, rates = friction(state, inputs, p)
        coupled = through(state, p)
        return state_class(
            state.velocity,
            sum_of_forces(state, coupled, opposed, inputs, p) / p.body.mass,
            rates,
            state.motor_velocity - state.velocity,
            motor_acceleration(gain(p.source) * inputs[0], coupled, state.motor_velocity, p.coupling),
        )

    @equation
    def signals(time: Scalar, state: Any, inputs: Any, p: Any) -> Any:
        """What is worth plotting."""
        opposed, _ = friction(state, inputs, p)
        return signals_class(
            state.position,
            state.velocity,
            derivatives(time, state, inputs, p).velocity,
            state.contact,
            opposed,
            gain(p.source) * inputs[0],
            spring_force(state, inputs, p),
            state.position + state.twist,
            state.motor_velocity,
            through(state, p),
        )

    def equilibrium(p: Any, surface_speed: float) -> tuple[Any, Any]:
        """At rest, the load at the origin: what holds a constant load twists the coupling."""
        load = p.body.load_force
        state = state_class(0.0, 0.0, unbent, load / p.coupling.coupling_stiffness, 0.0)
        return state, inputs_class(load / gain(p.source), 0.0, 0.0)

    return Plant(
        name=named(f"{FAMILIES[axis]}_{name_along(source.name, axis)}", law),
        summary=f"motor and load as two {PARTS[axis]} with a compliance between them, friction at the load, "
        f"{name_along(source.words, axis)}",
        State=state_class,
        Inputs=inputs_class,
        Parameters=parameters_class,
        Signals=signals_class,
        derivatives=derivatives,
        signals=signals,
        measure=measure,
        equilibrium=equilibrium,
        command_limit=lambda p: limit(p.source),
        travel=travel,
        command=fields(inputs_class)[0].name,
        balances={},
        friction=law.name,
        contact="contact",
        refit=lambda other: two_mass(other, source, axis),
    )


TWO_MASS_FORCE, TWO_MASS_VOLTAGE, TWO_MASS_CURRENT = (two_mass(LUGRE, source) for source in (FORCE, VOLTAGE, CURRENT))
TWO_INERTIA_TORQUE, TWO_INERTIA_VOLTAGE, TWO_INERTIA_CURRENT = (
    two_mass(LUGRE, source, ROTARY) for source in (FORCE, VOLTAGE, CURRENT)
)
