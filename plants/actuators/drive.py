"""A mass that a force moves: electric drives, linear and rotary, and the reference cases of the friction laws.

An optional spring to a point that moves (an input), end stops. Driven by a force (N), by a voltage through a force
gain, or by a current through a force constant. The equations are written for an axis that goes straight; those that
turn are the same machines with units named anew (`plants.axis`).

`driven` moves the mass itself, `coupled` a motor with a mass and viscous friction of its own, which moves it through a
compliance. There `position` and `velocity` are the load's, and the sensor shows its position or the motor's
(`measured_at`). With a coupling that does not give it is the other drive, whose mass and viscous friction are both. It
has no balance by which a record could be diagnosed: no sensor shows the motor beside the load.
"""

import functools
import math
from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.actuators.interface import Actuator, own_stroke
from plants.axis import LINEAR, ROTARY, name_along
from plants.coupling import Coupling, coupling_force, measured_position, motor_acceleration
from plants.equation import Scalar, equation, retyped
from plants.hydraulics import FORCE
from plants.sources import ForceLimits, Source


class Bristle(NamedTuple):
    """As LuGre's, of the contact of a drive, which is stiffer than a seal."""

    bristle_deflection: Annotated[float, "m", 1e-5]


class Motion(NamedTuple):
    position: Annotated[float, "m", 1e-3]
    velocity: Annotated[float, "m/s", 1e-2]


class Parameters(NamedTuple):
    source: ForceLimits
    stroke: Annotated[float, "m"] = np.inf
    spring_stiffness: Annotated[float, "N/m"] = 0.0


class Signals(NamedTuple):
    drive_force: Annotated[float, "N"]
    spring_force: Annotated[float, "N"]


class MotorState(NamedTuple):
    """Of a motor behind a coupling."""

    twist: Annotated[float, "m", 1e-4]
    motor_velocity: Annotated[float, "m/s", 1e-2]


class CoupledParameters(NamedTuple):
    coupling: Coupling
    source: ForceLimits
    stroke: Annotated[float, "m"] = np.inf
    spring_stiffness: Annotated[float, "N/m"] = 0.0


class CoupledSignals(NamedTuple):
    drive_force: Annotated[float, "N"]
    spring_force: Annotated[float, "N"]
    motor_position: Annotated[float, "m"]
    motor_velocity: Annotated[float, "m/s"]
    coupling_force: Annotated[float, "N"]


@equation
def spring_force(state: Any, inputs: Any, p: Any) -> Scalar:
    """Force (N) of the spring on the mass: k (x_end - x)."""
    return p.spring_stiffness * (inputs.spring_end - state.position)


@equation
def through(state: Any, p: Any) -> Scalar:
    """Force (N) of the coupling on the load."""
    return coupling_force(state.twist, state.motor_velocity, state.velocity, p.coupling)


@equation
def coupled_force(state: Any, inputs: Any, p: Any) -> Scalar:
    """Force (N) on the load: that of the coupling, and of the spring."""
    return through(state, p) + spring_force(state, inputs, p)


@equation
def sensed(state: Any, p: Any) -> Scalar:
    """The position (m) of the motor, or that of the load."""
    return measured_position(state.position, state.twist, p.coupling)


@equation
def no_rates(state: Any, inputs: Any, p: Any) -> tuple[()]:
    """What gives its force at once has no states."""
    return ()


FAMILIES = {LINEAR: ("drive", "two_mass"), ROTARY: ("rotary", "two_inertia")}
"""What the names of drives begin with, by their axis: of one mass, and of two."""

BODIES = {LINEAR: ("mass", "masses"), ROTARY: ("turning inertia", "inertias")}
"""What moves, in words."""


@functools.cache
def driven(source: Source, axis: str = LINEAR) -> Actuator:
    """A mass that a source of force moves."""
    gain, limit = source.gain, source.limit

    @equation
    def force(state: Any, inputs: Any, p: Any) -> Scalar:
        """F + k (x_end - x) (N)."""
        return gain(p.source) * inputs[0] + spring_force(state, inputs, p)

    @equation
    def signals(state: Any, inputs: Any, p: Any) -> tuple[Scalar, ...]:
        """The source's force and the spring's."""
        return gain(p.source) * inputs[0], spring_force(state, inputs, p)

    def equilibrium(p: Any) -> tuple[tuple[()], tuple[float, ...]]:
        """At the origin, a constant load held by the drive."""
        return (), _held(source, p)

    return Actuator(
        name=f"{FAMILIES[axis][0]}_{name_along(source.name, axis)}",
        summary=f"{BODIES[axis][0]} with friction and an optional spring, {name_along(source.words, axis)}",
        Inputs=source.Inputs,
        Parameters=retyped(Parameters, source.name, source=source.Parameters),
        Signals=Signals,
        force=force,
        rates=no_rates,
        signals=signals,
        stroke=own_stroke,
        equilibrium=equilibrium,
        command_limit=lambda p: limit(p.source),
        balances={"force": FORCE},
        Motion=Motion,
        Contact=Bristle,
        rotation=math.nan,
    )


@functools.cache
def coupled(source: Source, axis: str = LINEAR) -> Actuator:
    """A mass that a motor with a source of force moves through a compliance."""
    gain, limit = source.gain, source.limit

    @equation
    def rates(state: Any, inputs: Any, p: Any) -> tuple[Scalar, Scalar]:
        """Of the twist, and of the motor's velocity."""
        driving = gain(p.source) * inputs[0]
        acceleration = motor_acceleration(driving, through(state, p), state.motor_velocity, p.coupling)
        return state.motor_velocity - state.velocity, acceleration

    @equation
    def signals(state: Any, inputs: Any, p: Any) -> tuple[Scalar, ...]:
        """Forces of source, spring and coupling, and the motor's motion."""
        return (
            gain(p.source) * inputs[0],
            spring_force(state, inputs, p),
            state.position + state.twist,
            state.motor_velocity,
            through(state, p),
        )

    def equilibrium(p: Any) -> tuple[tuple[float, float], tuple[float, ...]]:
        """At rest, the load at the origin: what holds a constant load twists the coupling."""
        return (p.body.load_force / p.coupling.coupling_stiffness, 0.0), _held(source, p)

    return Actuator(
        name=f"{FAMILIES[axis][1]}_{name_along(source.name, axis)}",
        summary=f"motor and load as two {BODIES[axis][1]} with a compliance between them, friction at the load, "
        f"{name_along(source.words, axis)}",
        State=MotorState,
        Inputs=source.Inputs,
        Parameters=retyped(CoupledParameters, source.name, source=source.Parameters),
        Signals=CoupledSignals,
        force=coupled_force,
        rates=rates,
        signals=signals,
        stroke=own_stroke,
        equilibrium=equilibrium,
        position=sensed,
        command_limit=lambda p: limit(p.source),
        Motion=Motion,
        Contact=Bristle,
        rotation=math.nan,
    )


def _held(source: Source, p: Any) -> tuple[float, ...]:
    """The inputs of a source that holds a constant load, the other ones 0."""
    others = [0.0] * (len(source.Inputs._fields) - 1)
    return p.body.load_force / source.gain(p.source), *others
