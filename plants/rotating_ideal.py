"""The rotating actuator with an imposed surface speed, whatever torque it takes: `rotation = "ideal"`."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants import bristles as laws
from plants import motor as mot
from plants.bristles import BristleLaw, GuidedBristle, HelicalBristle, PlaneBristle
from plants.equation import Scalar, equation
from plants.interface import Measurement, Plant
from plants.non_rotating import holding_load_pressure, travel, voltage_limit
from plants.rotating import Signals, all_signals, hydraulic_rates, readings


class HelicalState(NamedTuple):
    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    load_pressure: Annotated[float, "Pa", 1e6]
    bristles: HelicalBristle
    spool_position: Annotated[float, "m", 1e-4]


class IsotropicState(NamedTuple):
    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    load_pressure: Annotated[float, "Pa", 1e6]
    bristles: PlaneBristle
    spool_position: Annotated[float, "m", 1e-4]


class AnisotropicState(NamedTuple):
    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]
    load_pressure: Annotated[float, "Pa", 1e6]
    bristles: GuidedBristle
    spool_position: Annotated[float, "m", 1e-4]


class Inputs(NamedTuple):
    valve_voltage: Annotated[float, "V"]
    surface_speed: Annotated[float, "m/s"]
    disturbance_force: Annotated[float, "N"]


@equation
def measure(state: Any, p: Any) -> Measurement:
    """Position and both pressures; an imposed speed needs no sensor and no motor (NaN)."""
    return readings(state, np.nan, np.nan, p)


def turned_ideally(law: BristleLaw, state_class: Any) -> Plant:
    """The plant whose surface speed is imposed, with the friction of a bristle law."""
    friction = law.friction

    @equation
    def derivatives(time: Scalar, state: Any, inputs: Inputs, p: Any) -> Any:
        """Rates of the states with an imposed surface speed."""
        axial, _, rates = friction(state.velocity, inputs.surface_speed, state.bristles, p)
        acceleration, pressure_rate, spool_rate = hydraulic_rates(state, inputs, axial, p)
        return state_class(state.velocity, acceleration, pressure_rate, rates, spool_rate)

    @equation
    def signals(time: Scalar, state: Any, inputs: Inputs, p: Any) -> Signals:
        """What is worth plotting; see `Signals`. Current and voltage are those of a motor that holds the speed."""
        axial, rotary, _ = friction(state.velocity, inputs.surface_speed, state.bristles, p)
        current = mot.holding_current(rotary, p.motor)
        voltage = mot.holding_voltage(current, inputs.surface_speed, p.motor)
        return all_signals(state, inputs, (axial, rotary), (inputs.surface_speed, current, voltage), p)

    def equilibrium(p: Any, surface_speed: float) -> tuple[Any, Inputs]:
        """At rest in mid-stroke, turning at `surface_speed` (m/s), the bristle bent around only."""
        bristles, _ = law.steady_rotation(p, surface_speed)
        pressure = holding_load_pressure(p.hydraulics, p.body)
        return state_class(0.0, 0.0, pressure, bristles, 0.0), Inputs(0.0, surface_speed, 0.0)

    return Plant(
        name=f"rotating_{law.name}_ideal",
        summary=f"rotating cylinder, {law.name} bristle, imposed speed of rotation",
        State=state_class,
        Inputs=Inputs,
        Parameters=law.Parameters,
        Signals=Signals,
        derivatives=derivatives,
        signals=signals,
        measure=measure,
        equilibrium=equilibrium,
        command_limit=voltage_limit,
        travel=travel,
        command="valve_voltage",
        rotary_command="surface_speed",
        balances={"force": "velocity", "flow": "load_pressure", "valve": "spool_position"},
    )


HELICAL_IDEAL = turned_ideally(laws.HELICAL, HelicalState)
ISOTROPIC_IDEAL = turned_ideally(laws.ISOTROPIC, IsotropicState)
ANISOTROPIC_IDEAL = turned_ideally(laws.ANISOTROPIC, AnisotropicState)
