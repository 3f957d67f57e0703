"""The rotating hydraulic actuator of thesis 3.3: six states (or seven) and the valve's spool.

Two bristle laws: `helical`, one scalar bristle along the helix as the thesis prints it, and `isotropic`, a bristle
with an axial and a rotary component. Here a motor turns the rod, fed with a voltage, as in the thesis;
`plants.rotating_ideal` has the same laws with an imposed speed.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants import hydraulics as hyd
from plants import motor as mot
from plants.equation import Scalar, equation
from plants.friction import Friction, helical_speed, lugre_helical, lugre_isotropic
from plants.hydraulics import Hydraulics, Mass
from plants.interface import Measurement, Plant
from plants.motor import Motor
from plants.non_rotating import holding_load_pressure, travel, voltage_limit


class HelicalState(NamedTuple):
    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    load_pressure: Annotated[float, "Pa", 1e6]
    surface_speed: Annotated[float, "m/s", 1e-1]
    bristle_deflection: Annotated[float, "m", 1e-4]
    motor_current: Annotated[float, "A", 1.0]
    spool_position: Annotated[float, "m", 1e-4]


class IsotropicState(NamedTuple):
    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    load_pressure: Annotated[float, "Pa", 1e6]
    surface_speed: Annotated[float, "m/s", 1e-1]
    bristle_axial: Annotated[float, "m", 1e-4]
    bristle_rotary: Annotated[float, "m", 1e-4]
    motor_current: Annotated[float, "A", 1.0]
    spool_position: Annotated[float, "m", 1e-4]


class Inputs(NamedTuple):
    valve_voltage: Annotated[float, "V"]
    motor_voltage: Annotated[float, "V"]
    disturbance_force: Annotated[float, "N"]


class Parameters(NamedTuple):
    hydraulics: Hydraulics
    body: Mass
    friction: Friction
    motor: Motor


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


# --- what every variant shares -------------------------------------------------------------------------------


@equation
def hydraulic_rates(state: Any, inputs: Any, axial_friction: Scalar, p: Parameters) -> tuple[Scalar, Scalar, Scalar]:
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
def all_signals(
    state: Any,
    inputs: Any,
    friction: tuple[Scalar, Scalar],
    rotation: tuple[Scalar, Scalar, Scalar],
    p: Parameters,
) -> Signals:
    """All signals, given axial and rotary friction (N) and surface speed (m/s), motor current (A), voltage (V).

    Power: P_L Q_L (thesis 4.16, without the oil's compression), P_s |Q_L| from the pump, F_rotary w (4.17, 4.18)
    on the rod and V_m i at the motor's terminals.
    """
    h = p.hydraulics
    axial, rotary = friction
    surface_speed, current, voltage = rotation
    acceleration, _, _ = hydraulic_rates(state, inputs, axial, p)
    flow = hyd.load_flow(state.spool_position, state.load_pressure, h)
    pressure_1, pressure_2 = hyd.chamber_pressures(state.load_pressure, h)
    speed = helical_speed(state.velocity, surface_speed)
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
        state.load_pressure * flow,
        h.supply_pressure * np.abs(flow),
        rotary * surface_speed,
        voltage * current,
    )


@equation
def readings(state: Any, surface_speed: Scalar, p: Parameters) -> Measurement:
    pressure_1, pressure_2 = hyd.chamber_pressures(state.load_pressure, p.hydraulics)
    return Measurement(state.position, pressure_1, pressure_2, surface_speed / p.motor.piston_radius)


# --- turned by a motor ---------------------------------------------------------------------------------------


@equation
def helical_derivatives(time: Scalar, state: HelicalState, inputs: Inputs, p: Parameters) -> HelicalState:
    """Rates of the states. Thesis (3.50) to (3.55) with the valve of 3.2.1."""
    axial, rotary, bristle_rate = lugre_helical(
        state.velocity, state.surface_speed, state.bristle_deflection, p.friction
    )
    acceleration, pressure_rate, spool_rate = hydraulic_rates(state, inputs, axial, p)
    return HelicalState(
        state.velocity,
        acceleration,
        pressure_rate,
        mot.surface_acceleration(state.motor_current, rotary, p.motor),
        bristle_rate,
        mot.current_rate(state.motor_current, state.surface_speed, inputs.motor_voltage, p.motor),
        spool_rate,
    )


@equation
def helical_signals(time: Scalar, state: HelicalState, inputs: Inputs, p: Parameters) -> Signals:
    """What is worth plotting; see `Signals`."""
    axial, rotary, _ = lugre_helical(state.velocity, state.surface_speed, state.bristle_deflection, p.friction)
    rotation = (state.surface_speed, state.motor_current, inputs.motor_voltage)
    return all_signals(state, inputs, (axial, rotary), rotation, p)


@equation
def isotropic_derivatives(time: Scalar, state: IsotropicState, inputs: Inputs, p: Parameters) -> IsotropicState:
    """Rates of the states: as the helical plant, with the bristle of `lugre_isotropic`."""
    axial, rotary, rate_axial, rate_rotary = lugre_isotropic(
        state.velocity, state.surface_speed, state.bristle_axial, state.bristle_rotary, p.friction
    )
    acceleration, pressure_rate, spool_rate = hydraulic_rates(state, inputs, axial, p)
    return IsotropicState(
        state.velocity,
        acceleration,
        pressure_rate,
        mot.surface_acceleration(state.motor_current, rotary, p.motor),
        rate_axial,
        rate_rotary,
        mot.current_rate(state.motor_current, state.surface_speed, inputs.motor_voltage, p.motor),
        spool_rate,
    )


@equation
def isotropic_signals(time: Scalar, state: IsotropicState, inputs: Inputs, p: Parameters) -> Signals:
    """What is worth plotting; see `Signals`."""
    axial, rotary, _, _ = lugre_isotropic(
        state.velocity, state.surface_speed, state.bristle_axial, state.bristle_rotary, p.friction
    )
    rotation = (state.surface_speed, state.motor_current, inputs.motor_voltage)
    return all_signals(state, inputs, (axial, rotary), rotation, p)


@equation
def measure(state: Any, p: Parameters) -> Measurement:
    """Position, both pressures and the speed of rotation."""
    return readings(state, state.surface_speed, p)


def steady_rotation(p: Parameters, surface_speed: float) -> tuple[float, float]:
    """Bristle deflection (m) and rotary friction (N) of a rod that turns at `surface_speed` without moving along.

    The bristle's rate is linear in its deflection: 0 at rate(0) / (rate(0) - rate(1)).
    """
    if surface_speed == 0.0:
        return 0.0, 0.0
    _, _, unbent = lugre_helical(0.0, surface_speed, 0.0, p.friction)
    _, _, bent = lugre_helical(0.0, surface_speed, 1.0, p.friction)
    deflection = float(unbent / (unbent - bent))
    _, rotary, _ = lugre_helical(0.0, surface_speed, deflection, p.friction)
    return deflection, float(rotary)


def _motor_at(p: Parameters, surface_speed: float) -> tuple[float, float, float]:
    """Bristle deflection (m), current (A) and voltage (V) that hold `surface_speed` (m/s)."""
    deflection, friction = steady_rotation(p, surface_speed)
    current = float(mot.holding_current(friction, p.motor))
    return deflection, current, float(mot.holding_voltage(current, surface_speed, p.motor))


def helical_equilibrium(p: Parameters, surface_speed: float) -> tuple[HelicalState, Inputs]:
    """At rest in mid-stroke, turning at `surface_speed` (m/s)."""
    deflection, current, voltage = _motor_at(p, surface_speed)
    pressure = holding_load_pressure(p.hydraulics, p.body)
    return HelicalState(0.0, 0.0, pressure, surface_speed, deflection, current, 0.0), Inputs(0.0, voltage, 0.0)


def isotropic_equilibrium(p: Parameters, surface_speed: float) -> tuple[IsotropicState, Inputs]:
    """At rest in mid-stroke, turning at `surface_speed` (m/s), the bristle bent around only."""
    deflection, current, voltage = _motor_at(p, surface_speed)
    pressure = holding_load_pressure(p.hydraulics, p.body)
    state = IsotropicState(0.0, 0.0, pressure, surface_speed, 0.0, deflection, current, 0.0)
    return state, Inputs(0.0, voltage, 0.0)


def _plant(bristle: str, **equations: Any) -> Plant:
    return Plant(
        name=f"rotating_{bristle}",
        summary=f"rotating cylinder, {bristle} bristle, turned by a motor (thesis 3.3)",
        Inputs=Inputs,
        Parameters=Parameters,
        Signals=Signals,
        measure=measure,
        command_limit=voltage_limit,
        travel=travel,
        command="valve_voltage",
        rotary_command="motor_voltage",
        balances={
            "force": "velocity",
            "flow": "load_pressure",
            "valve": "spool_position",
            "rotation": "surface_speed",
            "motor": "motor_current",
        },
        **equations,
    )


HELICAL = _plant(
    "helical",
    State=HelicalState,
    derivatives=helical_derivatives,
    signals=helical_signals,
    equilibrium=helical_equilibrium,
)
ISOTROPIC = _plant(
    "isotropic",
    State=IsotropicState,
    derivatives=isotropic_derivatives,
    signals=isotropic_signals,
    equilibrium=isotropic_equilibrium,
)
