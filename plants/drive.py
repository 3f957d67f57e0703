"""A mass that a force moves: electric drives, and the reference cases of the friction laws.

Friction by any law of `plants.laws`, an optional spring to a point that moves (an input), end stops. Driven by a force
(N), or by a voltage through a force gain.
"""

import functools
from collections.abc import Callable
from typing import Annotated, Any, NamedTuple, Protocol, TypeVar

import numpy as np

from plants.equation import Scalar, equation
from plants.friction import Friction
from plants.hydraulics import FORCE, Mass, Moving, end_stop_force
from plants.interface import Measurement, Plant
from plants.laws.interface import FrictionLaw, at_rest, fitted, friction_of
from plants.laws.lugre import LUGRE, named


class Bristle(NamedTuple):
    """As LuGre's, of the contact of a drive, which is stiffer than a seal."""

    bristle_deflection: Annotated[float, "m", 1e-5]


class State(NamedTuple):
    position: Annotated[float, "m", 1e-3]
    velocity: Annotated[float, "m/s", 1e-2]
    contact: Bristle


class Inputs(NamedTuple):
    drive_force: Annotated[float, "N"]
    spring_end: Annotated[float, "m"]
    disturbance_force: Annotated[float, "N"]


class PressedInputs(NamedTuple):
    """Of a mass on which oil or air presses too: the drive's force contains that, and seals feel it."""

    drive_force: Annotated[float, "N"]
    spring_end: Annotated[float, "m"]
    disturbance_force: Annotated[float, "N"]
    pressure_1: Annotated[float, "Pa"] = 0.0
    pressure_2: Annotated[float, "Pa"] = 0.0


class VoltageInputs(NamedTuple):
    drive_voltage: Annotated[float, "V"]
    spring_end: Annotated[float, "m"]
    disturbance_force: Annotated[float, "N"]


class Parameters(NamedTuple):
    body: Mass
    friction: Friction
    stroke: Annotated[float, "m"] = np.inf
    spring_stiffness: Annotated[float, "N/m"] = 0.0
    force_limit: Annotated[float, "N"] = np.inf


class VoltageParameters(NamedTuple):
    body: Mass
    friction: Friction
    force_gain: Annotated[float, "N/V"]
    stroke: Annotated[float, "m"] = np.inf
    spring_stiffness: Annotated[float, "N/m"] = 0.0
    voltage_limit: Annotated[float, "V"] = np.inf


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


InputsT = TypeVar("InputsT", bound=Inputs | PressedInputs | VoltageInputs)
ParametersT = TypeVar("ParametersT", bound=Parameters | VoltageParameters)


@equation
def force_command(inputs: Inputs | PressedInputs, p: Parameters) -> Scalar:
    """Force (N) of the drive."""
    return inputs.drive_force


@equation
def voltage_command(inputs: VoltageInputs, p: VoltageParameters) -> Scalar:
    """Force (N) of the drive: K u."""
    return p.force_gain * inputs.drive_voltage


@equation
def sum_of_forces(state: Any, force: Scalar, friction: Scalar, inputs: Any, p: Any) -> Scalar:
    """Force (N) on the mass: F + k (x_end - x) + end stops - F_friction - F_load - disturbance."""
    spring = p.spring_stiffness * (inputs.spring_end - state.position)
    stop = end_stop_force(state.position, state.velocity, p.stroke, p.body)
    return force + spring + stop - friction - p.body.load_force - inputs.disturbance_force


@equation
def measure(state: State, p: Any) -> Measurement:
    """Position alone, as such drives have it."""
    return Measurement(state.position, np.nan, np.nan, np.nan, np.nan)


def force_limit(p: Parameters) -> float:
    """Limit of the drive's force (N)."""
    return p.force_limit


def voltage_limit(p: VoltageParameters) -> float:
    """Limit of the amplifier (V)."""
    return p.voltage_limit


def unit_gain(p: Parameters) -> float:
    """Force (N) of 1 N."""
    return 1.0


def force_gain(p: VoltageParameters) -> float:
    """Force (N) of 1 V."""
    return p.force_gain


def travel(p: Stroked) -> float:
    """Distance (m) between the end stops, if they are modelled."""
    return p.stroke if p.body.end_stop_stiffness else np.inf


def _drive(
    law: FrictionLaw,
    command: str,
    force: Callable[[InputsT, ParametersT], Scalar],
    inputs_class: type[InputsT],
    parameters: type[ParametersT],
    limit: Callable[[ParametersT], float],
    gain: Callable[[ParametersT], float],
    refit: Callable[[FrictionLaw], Plant],
) -> Plant:
    """The drive with a friction law: `force` (N) of its inputs, `gain` (N a unit) of its command."""
    state_class, parameters_class, signals_class = fitted(law, State, parameters, Signals)

    @equation
    def free_acceleration(state: Any, inputs: Any, p: Any) -> Scalar:
        """dv/dt (m/s^2) without friction."""
        return sum_of_forces(state, force(inputs, p), 0.0, inputs, p) / p.body.mass

    friction, unbent = friction_of(law, free_acceleration), at_rest(law)

    @equation
    def derivatives(time: Scalar, state: Any, inputs: Any, p: Any) -> Any:
        """Rates of the states."""
        opposed, rates = friction(state, inputs, p)
        total = sum_of_forces(state, force(inputs, p), opposed, inputs, p)
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
            force(inputs, p),
            p.spring_stiffness * (inputs.spring_end - state.position),
        )

    def equilibrium(p: ParametersT, surface_speed: float) -> tuple[NamedTuple, InputsT]:
        """At rest at the origin, a constant load held by the drive."""
        return state_class(0.0, 0.0, unbent), inputs_class(p.body.load_force / gain(p), 0.0, 0.0)

    driven = command.removeprefix("drive_")
    return Plant(
        name=named(command, law),
        summary=f"mass with friction and an optional spring, driven by a {driven}"
        + (" through a force gain" if driven == "voltage" else ""),
        State=state_class,
        Inputs=inputs_class,
        Parameters=parameters_class,
        Signals=signals_class,
        derivatives=derivatives,
        signals=signals,
        measure=measure,
        equilibrium=equilibrium,
        command_limit=limit,
        travel=travel,
        command=command,
        balances={"force": FORCE},
        friction=law.name,
        contact="contact",
        refit=refit,
    )


@functools.cache
def driven_by_force(law: FrictionLaw) -> Plant:
    """The mass that a force (N) drives, with a friction law."""
    return _drive(law, "drive_force", force_command, Inputs, Parameters, force_limit, unit_gain, driven_by_force)


@functools.cache
def driven_by_pressed_force(law: FrictionLaw) -> Plant:
    """The mass that a measured force (N) drives, with a friction law whose effects may depend on pressures."""
    refit = driven_by_pressed_force
    return _drive(law, "drive_force", force_command, PressedInputs, Parameters, force_limit, unit_gain, refit)


@functools.cache
def driven_by_voltage(law: FrictionLaw) -> Plant:
    """The mass that a voltage (V) drives through a force gain, with a friction law."""
    command, inputs, parameters = voltage_command, VoltageInputs, VoltageParameters
    return _drive(law, "drive_voltage", command, inputs, parameters, voltage_limit, force_gain, driven_by_voltage)


DRIVE_FORCE, DRIVE_VOLTAGE = driven_by_force(LUGRE), driven_by_voltage(LUGRE)
PRESSED_MASS = driven_by_pressed_force(LUGRE)
"""What any machine is of which the force is measured that drives it."""
