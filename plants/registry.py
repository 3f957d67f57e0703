"""The plants by name: ours, and those that other packages bring by entry point."""

from plants.actuators.cylinder import CYLINDER, TWO_CHAMBER
from plants.actuators.load_pressure import LOAD_PRESSURE
from plants.actuators.pneumatic import PNEUMATIC
from plants.actuators.pump import PUMP
from plants.drive import (
    DRIVE_CURRENT,
    DRIVE_FORCE,
    DRIVE_VOLTAGE,
    ROTARY_CURRENT,
    ROTARY_TORQUE,
    ROTARY_VOLTAGE,
)
from plants.equation import fields
from plants.interface import Plant
from plants.laws.lugre import LUGRE
from plants.machine import straight
from plants.plugins import Registry
from plants.two_mass import (
    TWO_INERTIA_CURRENT,
    TWO_INERTIA_TORQUE,
    TWO_INERTIA_VOLTAGE,
    TWO_MASS_CURRENT,
    TWO_MASS_FORCE,
    TWO_MASS_VOLTAGE,
)
from plants.valve_axis import VALVE_AXIS

THESIS = straight(LOAD_PRESSURE, LUGRE)
"""The thesis's actuator."""

CHAMBERS = straight(TWO_CHAMBER, LUGRE)
"""The same with a pressure in each chamber: what tells most of it."""

_OURS = (
    THESIS,
    *(THESIS.with_turning_rod(bristle, imposed) for bristle in LUGRE.plane for imposed in (False, True)),
    CHAMBERS,
    straight(CYLINDER, LUGRE),
    straight(PUMP, LUGRE),
    straight(PNEUMATIC, LUGRE),
    DRIVE_FORCE,
    DRIVE_VOLTAGE,
    DRIVE_CURRENT,
    ROTARY_TORQUE,
    ROTARY_VOLTAGE,
    ROTARY_CURRENT,
    TWO_MASS_FORCE,
    TWO_MASS_VOLTAGE,
    TWO_MASS_CURRENT,
    TWO_INERTIA_TORQUE,
    TWO_INERTIA_VOLTAGE,
    TWO_INERTIA_CURRENT,
    VALVE_AXIS,
)


def _check(plant: Plant) -> None:
    for cls in (plant.State, plant.Inputs, plant.Parameters, plant.Signals):
        try:
            fields(cls)
        except (AttributeError, TypeError):
            raise TypeError(f"{cls.__name__}: expected a NamedTuple of Annotated[float, unit]") from None


PLANTS = Registry("friction_workbench.plants", Plant, {plant.name: plant for plant in _OURS}, _check)


def plants() -> dict[str, Plant]:
    """All plants by name; ours first."""
    return PLANTS.working()
