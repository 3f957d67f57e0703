"""A mass that a force moves: electric drives, and the reference cases of the LuGre law.

LuGre friction, an optional spring to a point that moves (an input), end stops. Driven by a force (N), or by a
voltage through a force gain.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.equation import Scalar, equation
from plants.friction import Friction, lugre
from plants.hydraulics import Mass, end_stop_force
from plants.interface import Measurement, Plant


class State(NamedTuple):
    position: Annotated[float, "m", 1e-3]
    velocity: Annotated[float, "m/s", 1e-2]
    bristle_deflection: Annotated[float, "m", 1e-5]


class Inputs(NamedTuple):
    drive_force: Annotated[float, "N"]
    spring_end: Annotated[float, "m"]
    disturbance_force: Annotated[float, "N"]


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
    bristle_deflection: Annotated[float, "m"]
    axial_friction: Annotated[float, "N"]
    drive_force: Annotated[float, "N"]
    spring_force: Annotated[float, "N"]


@equation
def _rates(state: State, force: Scalar, inputs: Any, p: Any) -> State:
    """M dv/dt = force + k (x_end - x) - F_friction - F_load - disturbance + end stops."""
    friction, bristle_rate = lugre(state.velocity, state.bristle_deflection, p.friction)
    spring = p.spring_stiffness * (inputs.spring_end - state.position)
    stop = end_stop_force(state.position, state.velocity, p.stroke, p.body)
    total = force + spring + stop - friction - p.body.load_force - inputs.disturbance_force
    return State(state.velocity, total / p.body.mass, bristle_rate)


@equation
def _all_signals(state: State, force: Scalar, inputs: Any, p: Any) -> Signals:
    friction, _ = lugre(state.velocity, state.bristle_deflection, p.friction)
    return Signals(
        state.position,
        state.velocity,
        _rates(state, force, inputs, p).velocity,
        state.bristle_deflection,
        friction,
        force,
        p.spring_stiffness * (inputs.spring_end - state.position),
    )


@equation
def derivatives(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> State:
    """Rates of the states under a force command."""
    return _rates(state, inputs.drive_force, inputs, p)


@equation
def signals(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> Signals:
    """What is worth plotting."""
    return _all_signals(state, inputs.drive_force, inputs, p)


@equation
def voltage_derivatives(time: Scalar, state: State, inputs: VoltageInputs, p: VoltageParameters) -> State:
    """Rates of the states under a voltage command."""
    return _rates(state, p.force_gain * inputs.drive_voltage, inputs, p)


@equation
def voltage_signals(time: Scalar, state: State, inputs: VoltageInputs, p: VoltageParameters) -> Signals:
    """What is worth plotting."""
    return _all_signals(state, p.force_gain * inputs.drive_voltage, inputs, p)


@equation
def measure(state: State, p: Any) -> Measurement:
    """Position alone, as such drives have it."""
    return Measurement(state.position, np.nan, np.nan, np.nan, np.nan)


def equilibrium(p: Parameters, surface_speed: float) -> tuple[State, Inputs]:
    """At rest at the origin, a constant load held by the drive."""
    return State(0.0, 0.0, 0.0), Inputs(p.body.load_force, 0.0, 0.0)


def voltage_equilibrium(p: VoltageParameters, surface_speed: float) -> tuple[State, VoltageInputs]:
    """At rest at the origin, a constant load held by the drive."""
    return State(0.0, 0.0, 0.0), VoltageInputs(p.body.load_force / p.force_gain, 0.0, 0.0)


def force_limit(p: Parameters) -> float:
    """Limit of the drive's force (N)."""
    return p.force_limit


def voltage_limit(p: VoltageParameters) -> float:
    """Limit of the amplifier (V)."""
    return p.voltage_limit


def travel(p: Any) -> float:
    """Distance (m) between the end stops, if they are modelled."""
    return p.stroke if p.body.end_stop_stiffness else np.inf


DRIVE_FORCE = Plant(
    name="drive_force",
    summary="mass with LuGre friction and an optional spring, driven by a force",
    State=State,
    Inputs=Inputs,
    Parameters=Parameters,
    Signals=Signals,
    derivatives=derivatives,
    signals=signals,
    measure=measure,
    equilibrium=equilibrium,
    command_limit=force_limit,
    travel=travel,
    command="drive_force",
    balances={"force": "velocity"},
)

DRIVE_VOLTAGE = Plant(
    name="drive_voltage",
    summary="mass with LuGre friction and an optional spring, driven by a voltage through a force gain",
    State=State,
    Inputs=VoltageInputs,
    Parameters=VoltageParameters,
    Signals=Signals,
    derivatives=voltage_derivatives,
    signals=voltage_signals,
    measure=measure,
    equilibrium=voltage_equilibrium,
    command_limit=voltage_limit,
    travel=travel,
    command="drive_voltage",
    balances={"force": "velocity"},
)
