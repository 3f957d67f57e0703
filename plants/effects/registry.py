"""The effects by name, in the order in which they act: ours, and those that other packages bring by entry point."""

from plants.axis import LINEAR
from plants.effects.hydraulic import (
    COMMAND_DELAY,
    ENTRAINED_AIR,
    INTERNAL_LEAKAGE,
    SUPPLY_DROOP,
    UNEQUAL_AREAS,
    VALVE_DEADBAND,
)
from plants.effects.interface import Effect
from plants.effects.loads import CONSTANT_LOAD, QUADRATIC_DRAG, ROTATION_PERIODIC_FORCE, SPRING_LOAD
from plants.effects.on_friction import (
    DIRECTION_ASYMMETRY,
    FRICTIONAL_MEMORY,
    POSITION_DEPENDENT_FRICTION,
    PRESSURE_DEPENDENT_FRICTION,
    RISING_STATIC_FRICTION,
    VISCOUS_DRIFT,
)
from plants.effects.sensors import BACKLASH, PRESSURE_SENSOR_OFFSET
from plants.effects.valve import VALVE_DYNAMICS, VALVE_HYSTERESIS
from plants.equation import fields, unmarked
from plants.plugins import Registry

_OURS = (
    DIRECTION_ASYMMETRY,
    POSITION_DEPENDENT_FRICTION,
    PRESSURE_DEPENDENT_FRICTION,
    RISING_STATIC_FRICTION,
    FRICTIONAL_MEMORY,
    QUADRATIC_DRAG,
    VISCOUS_DRIFT,
    CONSTANT_LOAD,
    SPRING_LOAD,
    ROTATION_PERIODIC_FORCE,
    VALVE_DEADBAND,
    INTERNAL_LEAKAGE,
    SUPPLY_DROOP,
    ENTRAINED_AIR,
    UNEQUAL_AREAS,
    COMMAND_DELAY,
    VALVE_HYSTERESIS,
    VALVE_DYNAMICS,
    BACKLASH,
    PRESSURE_SENSOR_OFFSET,
)


def _check(effect: Effect) -> None:
    """Its functions are equations, its parameters neutral at their defaults, and none of ours has their names."""
    if mistake := unmarked(effect.equations):
        raise TypeError(mistake)
    for item in (*fields(effect.Own), *fields(effect.Memory)):
        if item.default is None:
            raise TypeError(f"{item.name}: expected a default, at which the effect does nothing")
    for name in effect.own_names:
        owner = next((ours.name for ours in _OURS if name in ours.own_names and ours is not effect), None)
        if owner is not None:
            raise ValueError(f'parameter {name} is that of the effect "{owner}"; choose another name')


EFFECTS = Registry("friction_workbench.effects", Effect, {effect.name: effect for effect in _OURS}, _check)


def effects(axis: str = LINEAR) -> dict[str, Effect]:
    """All effects by name, of plants along that axis; ours first."""
    return {name: effect.along(axis) for name, effect in EFFECTS.working().items()}
