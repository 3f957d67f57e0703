"""The rotating actuator with an imposed surface speed, whatever torque it takes: `rotation = "ideal"`."""

import functools
from typing import Annotated, Any, NamedTuple

import numpy as np

from plants import motor as mot
from plants.bristles import AnisotropicParameters, Parameters, PlaneBristle
from plants.equation import Scalar, equation
from plants.interface import Measurement, Plant
from plants.laws.interface import STICK_TIME, FrictionLaw
from plants.laws.lugre import LUGRE, named
from plants.non_rotating import BALANCES, holding_load_pressure, travel, voltage_limit
from plants.rotating import Signals, all_signals, held_along, hydraulic_rates, in_plane, readings, with_bristles


class State(NamedTuple):
    """Of one whose friction is the same along and around; other bristles stand in the field `bristles` for others."""

    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    load_pressure: Annotated[float, "Pa", 1e6]
    bristles: PlaneBristle
    spool_position: Annotated[float, "m", 1e-4]


class Inputs(NamedTuple):
    valve_voltage: Annotated[float, "V"]
    surface_speed: Annotated[float, "m/s"]
    disturbance_force: Annotated[float, "N"]


@equation
def measure(state: Any, p: Any) -> Measurement:
    """Position and both pressures; an imposed speed needs no sensor and no motor (NaN)."""
    return readings(state, np.nan, np.nan, p)


@functools.cache
def turned_ideally(law: FrictionLaw, bristle: str) -> Plant:
    """The plant whose surface speed is imposed, with the friction of a law in its form for these bristles."""
    plane = law.plane[bristle]
    friction, state_class = plane.friction, with_bristles(State, plane)

    @equation
    def friction_of(state: Any, inputs: Inputs, p: Any) -> tuple[Scalar, Scalar, Any]:
        """Friction along and around (N) and the rates of the bristles."""
        held = held_along(state, inputs, p.body.mass, p), p.body.mass * inputs.surface_speed / STICK_TIME
        return friction(state.velocity, inputs.surface_speed, state.bristles, held, p)

    @equation
    def derivatives(time: Scalar, state: Any, inputs: Inputs, p: Any) -> Any:
        """Rates of the states with an imposed surface speed."""
        axial, _, rates = friction_of(state, inputs, p)
        acceleration, pressure_rate, spool_rate = hydraulic_rates(state, inputs, axial, p)
        return state_class(state.velocity, acceleration, pressure_rate, rates, spool_rate)

    @equation
    def signals(time: Scalar, state: Any, inputs: Inputs, p: Any) -> Signals:
        """What is worth plotting; see `Signals`. Current and voltage are those of a motor that holds the speed."""
        axial, rotary, _ = friction_of(state, inputs, p)
        current = mot.holding_current(rotary, p.motor)
        voltage = mot.holding_voltage(current, inputs.surface_speed, p.motor)
        return all_signals(state, inputs, (axial, rotary), (inputs.surface_speed, current, voltage), p)

    def equilibrium(p: Parameters | AnisotropicParameters, surface_speed: float) -> tuple[NamedTuple, Inputs]:
        """At rest in mid-stroke, turning at `surface_speed` (m/s), the bristle bent around only."""
        bristles, _ = plane.steady_rotation(p, surface_speed)
        pressure = holding_load_pressure(p.hydraulics, p.body)
        return state_class(0.0, 0.0, pressure, bristles, 0.0), Inputs(0.0, surface_speed, 0.0)

    return Plant(
        name=named(f"rotating_{bristle}_ideal", law),
        summary=f"rotating cylinder, {bristle} bristle, imposed speed of rotation",
        State=state_class,
        Inputs=Inputs,
        Parameters=plane.Parameters,
        Signals=Signals,
        derivatives=derivatives,
        signals=signals,
        measure=measure,
        equilibrium=equilibrium,
        command_limit=voltage_limit,
        travel=travel,
        command="valve_voltage",
        rotary_command="surface_speed",
        balances=BALANCES,
        friction=law.name,
        contact="bristles",
        refit=lambda other: turned_ideally(in_plane(other, bristle), bristle),
    )


HELICAL_IDEAL, ISOTROPIC_IDEAL, ANISOTROPIC_IDEAL = (turned_ideally(LUGRE, bristle) for bristle in LUGRE.plane)
