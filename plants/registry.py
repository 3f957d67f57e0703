"""The plants by name: ours, and those that other packages bring by entry point."""

from collections.abc import Mapping

from plants.actuators.cylinder import CYLINDER, TWO_CHAMBER
from plants.actuators.drive import coupled, driven
from plants.actuators.load_pressure import LOAD_PRESSURE
from plants.actuators.pneumatic import PNEUMATIC
from plants.actuators.pump import PUMP
from plants.axis import AXES, LINEAR
from plants.equation import fields
from plants.interface import Plant
from plants.laws.lugre import LUGRE
from plants.machine import straight
from plants.plugins import Registry
from plants.sources import CURRENT, FORCE, PRESSED, VOLTAGE, Source
from plants.valve_axis import VALVE_AXIS

THESIS = straight(LOAD_PRESSURE, LUGRE)
"""The thesis's actuator."""

CHAMBERS = straight(TWO_CHAMBER, LUGRE)
"""The same with a pressure in each chamber: what tells most of it."""

SOURCES = (FORCE, VOLTAGE, CURRENT)


def drive(source: Source, axis: str = LINEAR) -> Plant:
    """What a source of force drives along a straight axis, or one that turns."""
    return straight(driven(source, axis), LUGRE, axis)


DRIVE_FORCE, DRIVE_VOLTAGE, DRIVE_CURRENT = (drive(source) for source in SOURCES)


def pressed(axis: str = LINEAR) -> Plant:
    """What any machine is of which the force, or the torque, is measured that drives it; pressures may be too."""
    return drive(PRESSED, axis)


_OURS = (
    THESIS,
    *(THESIS.with_turning_rod(bristle, imposed) for bristle in LUGRE.plane for imposed in (False, True)),
    straight(CYLINDER, LUGRE),
    CHAMBERS,
    straight(PUMP, LUGRE),
    straight(PNEUMATIC, LUGRE),
    *(drive(source, axis) for axis in AXES for source in SOURCES),
    *(straight(coupled(source, axis), LUGRE, axis) for axis in AXES for source in SOURCES),
    VALVE_AXIS,
)


def _check(plant: Plant) -> None:
    for cls in (plant.State, plant.Inputs, plant.Parameters, plant.Signals):
        try:
            fields(cls)
        except (AttributeError, TypeError):
            raise TypeError(f"{cls.__name__}: expected a NamedTuple of Annotated[float, unit]") from None


PLANTS = Registry("friction_workbench.plants", Plant, {plant.name: plant for plant in _OURS}, _check)


def plants() -> Mapping[str, Plant]:
    """All plants by name; ours first."""
    return PLANTS.working()
