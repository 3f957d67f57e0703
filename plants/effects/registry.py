"""The effects by name, in the order in which they act: ours, and those that other packages bring by entry point."""

import functools
from collections.abc import Mapping

from plants.axis import LINEAR
from plants.effects.chambers import ENTRAINED_AIR, POSITION_DEPENDENT_AREA, POSITION_DEPENDENT_VOLUME, UNEQUAL_AREAS
from plants.effects.command import COMMAND_DELAY
from plants.effects.compliant import COMPLIANT_LOAD
from plants.effects.contact import MAXWELL_SLIP, PRESLIDING_CURVE
from plants.effects.curves import CURVES
from plants.effects.friction_in_time import (
    FRICTIONAL_MEMORY,
    RISING_STATIC_FRICTION,
    VISCOUS_DRIFT,
    VISCOUS_WARMING,
)
from plants.effects.friction_levels import (
    DIRECTION_ASYMMETRY,
    POSITION_DEPENDENT_FRICTION,
    PRESSURE_DEPENDENT_FRICTION,
)
from plants.effects.interface import Effect
from plants.effects.leakage import EXTERNAL_LEAKAGE, INTERNAL_AIR_LEAKAGE, INTERNAL_LEAKAGE
from plants.effects.loads import COGGING, CONSTANT_LOAD, CUSHION, QUADRATIC_DRAG, ROTATION_PERIODIC_FORCE, SPRING_LOAD
from plants.effects.maps import FORCE_MAP
from plants.effects.sensors import BACKLASH, PRESSURE_SENSOR_OFFSET, SENSOR_LAG, SENSOR_NONLINEARITY
from plants.effects.supply import SUPPLY_DROOP, SUPPLY_RIPPLE
from plants.effects.valve import SPOOL_STICTION, VALVE_DYNAMICS, VALVE_HYSTERESIS
from plants.effects.valve_flow import VALVE_DEADBAND, VALVE_GAIN_ASYMMETRY, VALVE_GAIN_CURVE
from plants.equation import fields, unmarked
from plants.plugins import Registry

_OURS = (
    DIRECTION_ASYMMETRY,
    POSITION_DEPENDENT_FRICTION,
    PRESSURE_DEPENDENT_FRICTION,
    RISING_STATIC_FRICTION,
    FRICTIONAL_MEMORY,
    VISCOUS_DRIFT,
    VISCOUS_WARMING,
    PRESLIDING_CURVE,
    MAXWELL_SLIP,
    QUADRATIC_DRAG,
    CONSTANT_LOAD,
    SPRING_LOAD,
    CUSHION,
    COGGING,
    ROTATION_PERIODIC_FORCE,
    COMPLIANT_LOAD,
    VALVE_DEADBAND,
    VALVE_GAIN_CURVE,
    VALVE_GAIN_ASYMMETRY,
    INTERNAL_LEAKAGE,
    INTERNAL_AIR_LEAKAGE,
    EXTERNAL_LEAKAGE,
    SUPPLY_DROOP,
    SUPPLY_RIPPLE,
    ENTRAINED_AIR,
    POSITION_DEPENDENT_VOLUME,
    UNEQUAL_AREAS,
    POSITION_DEPENDENT_AREA,
    COMMAND_DELAY,
    VALVE_HYSTERESIS,
    SPOOL_STICTION,
    VALVE_DYNAMICS,
    BACKLASH,
    SENSOR_NONLINEARITY,
    SENSOR_LAG,
    PRESSURE_SENSOR_OFFSET,
    *CURVES.values(),
    FORCE_MAP,
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
    return dict(_along(tuple(EFFECTS.working().items()), axis))


@functools.cache
def _along(known: tuple[tuple[str, Effect], ...], axis: str) -> Mapping[str, Effect]:
    return {name: effect.along(axis) for name, effect in known}
