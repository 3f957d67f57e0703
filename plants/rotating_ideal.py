"""The rotating actuator with an imposed surface speed, whatever torque it takes: `rotation = "ideal"`."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants import motor as mot
from plants.equation import Scalar, equation
from plants.friction import lugre_helical, lugre_isotropic
from plants.interface import Measurement, Plant
from plants.non_rotating import holding_load_pressure, travel, voltage_limit
from plants.rotating import Parameters, Signals, all_signals, hydraulic_rates, readings, steady_rotation


class HelicalState(NamedTuple):
    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    load_pressure: Annotated[float, "Pa", 1e6]
    bristle_deflection: Annotated[float, "m", 1e-4]
    spool_position: Annotated[float, "m", 1e-4]


class IsotropicState(NamedTuple):
    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    load_pressure: Annotated[float, "Pa", 1e6]
    bristle_axial: Annotated[float, "m", 1e-4]
    bristle_rotary: Annotated[float, "m", 1e-4]
    spool_position: Annotated[float, "m", 1e-4]


class Inputs(NamedTuple):
    valve_voltage: Annotated[float, "V"]
    surface_speed: Annotated[float, "m/s"]
    disturbance_force: Annotated[float, "N"]


@equation
def helical_derivatives(time: Scalar, state: HelicalState, inputs: Inputs, p: Parameters) -> HelicalState:
    """Rates of the states with an imposed surface speed."""
    axial, _, bristle_rate = lugre_helical(state.velocity, inputs.surface_speed, state.bristle_deflection, p.friction)
    acceleration, pressure_rate, spool_rate = hydraulic_rates(state, inputs, axial, p)
    return HelicalState(state.velocity, acceleration, pressure_rate, bristle_rate, spool_rate)


@equation
def _rotation(rotary_friction: Scalar, inputs: Inputs, p: Parameters) -> Any:
    """Surface speed, and the current and voltage with which the motor would hold it."""
    current = mot.holding_current(rotary_friction, p.motor)
    return (inputs.surface_speed, current, mot.holding_voltage(current, inputs.surface_speed, p.motor))


@equation
def helical_signals(time: Scalar, state: HelicalState, inputs: Inputs, p: Parameters) -> Signals:
    """What is worth plotting; see `Signals`. Current and voltage are those of a motor that holds the speed."""
    axial, rotary, _ = lugre_helical(state.velocity, inputs.surface_speed, state.bristle_deflection, p.friction)
    return all_signals(state, inputs, (axial, rotary), _rotation(rotary, inputs, p), p)


@equation
def isotropic_derivatives(time: Scalar, state: IsotropicState, inputs: Inputs, p: Parameters) -> IsotropicState:
    """Rates of the states with an imposed surface speed."""
    axial, _, rate_axial, rate_rotary = lugre_isotropic(
        state.velocity, inputs.surface_speed, state.bristle_axial, state.bristle_rotary, p.friction
    )
    acceleration, pressure_rate, spool_rate = hydraulic_rates(state, inputs, axial, p)
    return IsotropicState(state.velocity, acceleration, pressure_rate, rate_axial, rate_rotary, spool_rate)


@equation
def isotropic_signals(time: Scalar, state: IsotropicState, inputs: Inputs, p: Parameters) -> Signals:
    """What is worth plotting; see `Signals`. Current and voltage are those of a motor that holds the speed."""
    axial, rotary, _, _ = lugre_isotropic(
        state.velocity, inputs.surface_speed, state.bristle_axial, state.bristle_rotary, p.friction
    )
    return all_signals(state, inputs, (axial, rotary), _rotation(rotary, inputs, p), p)


@equation
def measure(state: Any, p: Parameters) -> Measurement:
    """Position and both pressures; an imposed speed needs no sensor (NaN)."""
    return readings(state, np.nan, p)


def helical_equilibrium(p: Parameters, surface_speed: float) -> tuple[HelicalState, Inputs]:
    """At rest in mid-stroke, turning at `surface_speed` (m/s)."""
    deflection, _ = steady_rotation(p, surface_speed)
    pressure = holding_load_pressure(p.hydraulics, p.body)
    return HelicalState(0.0, 0.0, pressure, deflection, 0.0), Inputs(0.0, surface_speed, 0.0)


def isotropic_equilibrium(p: Parameters, surface_speed: float) -> tuple[IsotropicState, Inputs]:
    """At rest in mid-stroke, turning at `surface_speed` (m/s), the bristle bent around only."""
    deflection, _ = steady_rotation(p, surface_speed)
    pressure = holding_load_pressure(p.hydraulics, p.body)
    return IsotropicState(0.0, 0.0, pressure, 0.0, deflection, 0.0), Inputs(0.0, surface_speed, 0.0)


def _plant(bristle: str, **equations: Any) -> Plant:
    return Plant(
        name=f"rotating_{bristle}_ideal",
        summary=f"rotating cylinder, {bristle} bristle, imposed speed of rotation",
        Inputs=Inputs,
        Parameters=Parameters,
        Signals=Signals,
        measure=measure,
        command_limit=voltage_limit,
        travel=travel,
        command="valve_voltage",
        rotary_command="surface_speed",
        balances={"force": "velocity", "flow": "load_pressure", "valve": "spool_position"},
        **equations,
    )


HELICAL_IDEAL = _plant(
    "helical",
    State=HelicalState,
    derivatives=helical_derivatives,
    signals=helical_signals,
    equilibrium=helical_equilibrium,
)
ISOTROPIC_IDEAL = _plant(
    "isotropic",
    State=IsotropicState,
    derivatives=isotropic_derivatives,
    signals=isotropic_signals,
    equilibrium=isotropic_equilibrium,
)
