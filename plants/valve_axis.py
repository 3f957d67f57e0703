"""An axis of which nothing is known but its command and its position: velocity from voltage, by gain and dead band.

    v_t = g (u(t - T) - d)      where u(t - T) > d             forward
        + g_n (u(t - T_n) + d_n)  where u(t - T_n) < -d_n      backward
        + v_drift
    tau dv/dt = v_t - v,   dx/dt = v

Each side of the valve has its own gain, dead band and transport delay; where the delays differ both may act for a
moment, and add. This is what a log without pressures can show of a mobile machine's or a crane's axis: friction, mass,
oil and the electronics are all in these few numbers, and no force is known. The delay is a true one: the plant's inputs
are the command as it was T and T_n ago, and the simulation switches them exactly then.
"""

from typing import Annotated, NamedTuple, Protocol, runtime_checkable

import numpy as np

from plants.equation import Scalar, equation, select
from plants.interface import Balance, Measurement, Plant


class State(NamedTuple):
    """`velocity` is what the valve gives; on an end stop the axis rests, and the oil goes elsewhere."""

    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-2]


class Inputs(NamedTuple):
    """The command, and as it arrives at either side of the valve."""

    valve_voltage: Annotated[float, "V"]
    arriving_voltage: Annotated[float, "V"]
    arriving_voltage_negative: Annotated[float, "V"]


class Side(NamedTuple):
    """One side of the valve."""

    velocity_gain: Annotated[float, "m/(s V)"]
    dead_band: Annotated[float, "V"]
    command_delay: Annotated[float, "s"]


class Valve(NamedTuple):
    """The forward side of the valve, and the backward one."""

    velocity_gain: Annotated[float, "m/(s V)"]
    dead_band: Annotated[float, "V"]
    command_delay: Annotated[float, "s"]
    negative: Side


class Parameters(NamedTuple):
    valve: Valve
    axis_time_constant: Annotated[float, "s"]
    drift_velocity: Annotated[float, "m/s"] = 0.0
    stroke: Annotated[float, "m"] = np.inf
    voltage_limit: Annotated[float, "V"] = np.inf


class Signals(NamedTuple):
    position: Annotated[float, "m"]
    velocity: Annotated[float, "m/s"]
    acceleration: Annotated[float, "m/s^2"]
    target_velocity: Annotated[float, "m/s"]


@runtime_checkable
class ValveDriven(Protocol):
    """Parameters of an axis whose velocity follows a voltage."""

    @property
    def valve(self) -> Valve: ...

    @property
    def axis_time_constant(self) -> float: ...


@equation
def target_velocity(inputs: Inputs, p: Parameters) -> Scalar:
    """v_t (m/s), to which the voltages that arrive drive the axis: see above."""
    forward = p.valve.velocity_gain * np.maximum(inputs.arriving_voltage - p.valve.dead_band, 0.0)
    other = p.valve.negative
    backward = other.velocity_gain * np.minimum(inputs.arriving_voltage_negative + other.dead_band, 0.0)
    return forward + backward + p.drift_velocity


@equation
def stopped(velocity: Scalar, position: Scalar, p: Parameters) -> Scalar:
    """A velocity (m/s) that no end stop is in the way of: none outwards at +-stroke/2."""
    inwards = select(position >= 0.5 * p.stroke, np.minimum(velocity, 0.0), velocity)
    return select(position <= -0.5 * p.stroke, np.maximum(inwards, 0.0), inwards)


@equation
def derivatives(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> State:
    """dx/dt = v, dv/dt = (v_t - v)/tau; on an end stop neither goes on outwards."""
    target = stopped(target_velocity(inputs, p), state.position, p)
    return State(stopped(state.velocity, state.position, p), (target - state.velocity) / p.axis_time_constant)


@equation
def signals(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> Signals:
    """What is worth plotting."""
    rates = derivatives(time, state, inputs, p)
    return Signals(state.position, rates.position, rates.velocity, target_velocity(inputs, p))


@equation
def measure(state: State, p: Parameters) -> Measurement:
    """Position alone."""
    return Measurement(state.position, np.nan, np.nan, np.nan, np.nan)


def equilibrium(p: Parameters, surface_speed: float) -> tuple[State, Inputs]:
    """At rest in mid-stroke, a drift held by the valve."""
    if p.drift_velocity == 0.0:
        held = 0.0
    elif p.drift_velocity < 0.0:
        held = p.valve.dead_band - p.drift_velocity / p.valve.velocity_gain
    else:
        held = -p.valve.negative.dead_band - p.drift_velocity / p.valve.negative.velocity_gain
    return State(0.0, 0.0), Inputs(held, held, held)


def voltage_limit(p: Parameters) -> float:
    """Limit of the amplifier (V)."""
    return p.voltage_limit


def travel(p: Parameters) -> float:
    """Distance (m) between the end stops."""
    return p.stroke


def delay(p: Parameters) -> float:
    """T (s)."""
    return p.valve.command_delay


def delay_negative(p: Parameters) -> float:
    """T_n (s)."""
    return p.valve.negative.command_delay


def time_constant(p: Parameters) -> tuple[float]:
    """tau (s): the velocity that a rate of it lacks."""
    return (p.axis_time_constant,)


VALVE_AXIS = Plant(
    name="valve_axis",
    summary="axis of which the velocity follows a voltage: gain, dead band and delay of either direction, no pressures",
    State=State,
    Inputs=Inputs,
    Parameters=Parameters,
    Signals=Signals,
    derivatives=derivatives,
    signals=signals,
    measure=measure,
    equilibrium=equilibrium,
    command_limit=voltage_limit,
    travel=travel,
    command="valve_voltage",
    balances={"velocity": Balance(("velocity",), "m/s", time_constant)},
    delayed={"arriving_voltage": delay, "arriving_voltage_negative": delay_negative},
    unknown=("velocity_gain", "dead_band", "command_delay", "axis_time_constant", "drift_velocity"),
)
