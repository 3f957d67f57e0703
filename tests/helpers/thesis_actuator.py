"""What the thesis's actuator has not, and other plants need beside its parameters; its numbers on a turning axis."""

from collections.abc import Mapping

from plants.axis import name_along
from plants.interface import Plant

OF_OTHERS = {
    "force_gain": 100.0,
    "force_constant": 50.0,
    "pump_displacement": 2e-7,
    "motor_mass": 5.0,
    "motor_viscous": 20.0,
    "coupling_stiffness": 2e6,
    "coupling_damping": 300.0,
    "dead_volume_1": 1e-5,
    "dead_volume_2": 1e-5,
    "sonic_conductance": 3e-9,
    "critical_pressure_ratio": 0.3,
    "polytropic_exponent": 1.2,
}
"""SI. What drives, pumps, a motor with a coupling to its load, and air need beside them."""

OF_AXES = {"velocity_gain": 0.1, "dead_band": 0.05, "command_delay": 0.0123, "axis_time_constant": 0.02}
"""And a valve-driven axis. A command that comes late is an effect on every other plant."""


def along(plant: Plant, values: Mapping[str, float]) -> dict[str, float]:
    """The same numbers under the names that they have on the plant's axis, and what a plant with a delay needs."""
    values = {**values, **OF_AXES} if plant.delayed else values
    return {name_along(name, plant.axis): value for name, value in values.items()}
