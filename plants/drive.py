"""A mass that a force moves: electric drives, linear and rotary, and the reference cases of the friction laws.

Friction by any law of `plants.laws`, an optional spring to a point that moves (an input), end stops. Driven by a force
(N), by a voltage through a force gain, or by a current through a force constant. The equations are written for an axis
that goes straight; those that turn are the same plants with units named anew (`plants.axis`).
"""

import functools
from typing import Annotated, Any, NamedTuple, Protocol

import numpy as np

from plants.axis import LINEAR, ROTARY, along, name_along, unit_along
from plants.equation import Scalar, equation, fields, retyped
from plants.friction import Friction
from plants.hydraulics import FORCE as NEWTON
from plants.hydraulics import Mass, Moving, end_stop_force
from plants.interface import Balance, Measurement, Plant
from plants.laws.interface import FrictionLaw, at_rest, fitted, friction_of
from plants.laws.lugre import LUGRE, named
from plants.sources import CURRENT, FORCE, PRESSED, VOLTAGE, ForceLimits, Source


class Bristle(NamedTuple):
    """As LuGre's, of the contact of a drive, which is stiffer than a seal."""

    bristle_deflection: Annotated[float, "m", 1e-5]


class State(NamedTuple):
    position: Annotated[float, "m", 1e-3]
    velocity: Annotated[float, "m/s", 1e-2]
    contact: Bristle


class Parameters(NamedTuple):
    body: Mass
    friction: Friction
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


class Stroked(Moving, Protocol):
    """Parameters of a mass that moves between two ends."""

    @property
    def stroke(self) -> float: ...


@equation
def spring_force(state: Any, inputs: Any, p: Any) -> Scalar:
    """Force (N) of the spring on the mass: k (x_end - x)."""
    return p.spring_stiffness * (inputs.spring_end - state.position)


@equation
def sum_of_forces(state: Any, force: Scalar, friction: Scalar, inputs: Any, p: Any) -> Scalar:
    """Force (N) on the mass: F + k (x_end - x) + end stops - F_friction - F_load - disturbance."""
    stop = end_stop_force(state.position, state.velocity, p.stroke, p.body)
    return force + spring_force(state, inputs, p) + stop - friction - p.body.load_force - inputs.disturbance_force


@equation
def measure(state: State, p: Any) -> Measurement:
    """Position alone, as such drives have it."""
    return Measurement(state.position, np.nan, np.nan, np.nan, np.nan)


def travel(p: Stroked) -> float:
    """Distance (m) between the end stops, if they are modelled."""
    return p.stroke if p.body.end_stop_stiffness else np.inf


def balances(axis: str) -> dict[str, Balance]:
    """The balance of the mass, in the unit of forces along the axis."""
    return {"force": NEWTON._replace(unit=unit_along(NEWTON.unit, axis))}


FAMILIES = {LINEAR: "drive", ROTARY: "rotary"}
"""What the names of drives begin with, by their axis."""

BODIES = {LINEAR: "mass", ROTARY: "turning inertia"}
"""What moves, in words."""


@functools.cache
def drive(law: FrictionLaw, source: Source, axis: str = LINEAR) -> Plant:
    """The drive with a friction law and a source of force, along a straight axis or one that turns."""
    fitted_classes = fitted(law, State, retyped(Parameters, source.name, source=source.Parameters), Signals)
    state_class, parameters_class, signals_class = (along(cls, axis) for cls in fitted_classes)
    inputs_class, gain, limit = along(source.Inputs, axis), source.gain, source.limit

    @equation
    def free_acceleration(state: Any, inputs: Any, p: Any) -> Scalar:
        """dv/dt (m/s^2) without friction."""
        return sum_of_forces(state, gain(p.source) * inputs[0], 0.0, inputs, p) / p.body.mass

    friction, unbent = friction_of(law, free_acceleration), at_rest(law)

    @equation
    def derivatives(time: Scalar, state: Any, inputs: Any, p: Any) -> Any:
        """Rates of the states."""
        opposed, rates = friction(state, inputs, p)
        total = sum_of_forces(state, gain(p.source) * inputs[0], opposed, inputs, p)
        return state_class(state.velocity, total / p.body.mass, rates)

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
        )

    def equilibrium(p: Any, surface_speed: float) -> tuple[Any, Any]:
        """At rest at the origin, a constant load held by the drive."""
        return state_class(0.0, 0.0, unbent), inputs_class(p.body.load_force / gain(p.source), 0.0, 0.0)

    return Plant(
        name=named(f"{FAMILIES[axis]}_{name_along(source.name, axis)}", law),
        summary=f"{BODIES[axis]} with friction and an optional spring, {name_along(source.words, axis)}",
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
        balances=balances(axis),
        friction=law.name,
        contact="contact",
        refit=lambda other: drive(other, source, axis),
    )


DRIVE_FORCE, DRIVE_VOLTAGE, DRIVE_CURRENT = (drive(LUGRE, source) for source in (FORCE, VOLTAGE, CURRENT))
ROTARY_TORQUE, ROTARY_VOLTAGE, ROTARY_CURRENT = (drive(LUGRE, source, ROTARY) for source in (FORCE, VOLTAGE, CURRENT))


def pressed(axis: str = LINEAR) -> Plant:
    """What any machine is of which the force, or the torque, is measured that drives it."""
    return drive(LUGRE, PRESSED, axis)
