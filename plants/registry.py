"""The plants by name: ours, and those that other packages bring by entry point."""

from plants.drive import DRIVE_FORCE, DRIVE_VOLTAGE
from plants.interface import Plant
from plants.non_rotating import NON_ROTATING
from plants.plugins import plugins
from plants.rotating import HELICAL, ISOTROPIC
from plants.rotating_ideal import HELICAL_IDEAL, ISOTROPIC_IDEAL

ENTRY_POINT_GROUP = "friction_workbench.plants"

_BUILT_IN = (NON_ROTATING, HELICAL, HELICAL_IDEAL, ISOTROPIC, ISOTROPIC_IDEAL, DRIVE_FORCE, DRIVE_VOLTAGE)


def plants() -> dict[str, Plant]:
    """All plants by name; ours first, and no other package can take their names."""
    ours = {plant.name: plant for plant in _BUILT_IN}
    return {**ours, **plugins(ENTRY_POINT_GROUP), **ours}
