"""The plants by name: ours, and those that other packages bring by entry point."""

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
from plants.non_rotating import NON_ROTATING
from plants.plugins import Registry
from plants.pump_cylinder import PUMP_CYLINDER
from plants.rotating import ANISOTROPIC, HELICAL, ISOTROPIC
from plants.rotating_ideal import ANISOTROPIC_IDEAL, HELICAL_IDEAL, ISOTROPIC_IDEAL
from plants.two_chamber import TWO_CHAMBER
from plants.two_mass import (
    TWO_INERTIA_CURRENT,
    TWO_INERTIA_TORQUE,
    TWO_INERTIA_VOLTAGE,
    TWO_MASS_CURRENT,
    TWO_MASS_FORCE,
    TWO_MASS_VOLTAGE,
)

_OURS = (
    NON_ROTATING,
    HELICAL,
    HELICAL_IDEAL,
    ISOTROPIC,
    ISOTROPIC_IDEAL,
    ANISOTROPIC,
    ANISOTROPIC_IDEAL,
    TWO_CHAMBER,
    PUMP_CYLINDER,
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
