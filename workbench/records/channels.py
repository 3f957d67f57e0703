"""The channels of an experiment: where each stands in a file, and how its numbers become SI along the plant's axis."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from plants.axis import LINEAR, ROTARY, unit_along
from plants.interface import SENSORS, Plant
from workbench.errors import nearest
from workbench.records.importing.words import is_reference
from workbench.records.schema import CHANNELS, ChannelTable
from workbench.records.spelled import without_unit
from workbench.toml import reading as files
from workbench.toml.units import QuantityError, factor, nearest_unit, si

FORCE, TORQUE = "force", "torque"
"""What drives a straight axis, and what a turning one: the same channel under two names."""

AXES = {LINEAR: "goes straight", ROTARY: "turns"}
"""In words."""


@dataclass(frozen=True)
class ChannelSpec:
    """Where a channel stands in a file, by a column's name or its number from 0, and how its numbers become SI.

    SI value = factor * number + offset. `called` is its name in the experiment file; `doubt` says why its column or
    unit may be wrong, "" where nothing speaks against it.
    """

    called: str
    column: str | int
    factor: float
    offset: float
    anti_alias: float
    doubt: str = ""


def unit_of(name: str, plant: Plant) -> str:
    """The SI unit of a channel of a plant, whichever way its axis goes."""
    return plant.command_unit if name == "command" else unit_along(CHANNELS[name], plant.axis)


def channels_of(tables: Mapping[str, ChannelTable], plant: Plant) -> dict[str, ChannelSpec]:
    """The channels by name; a torque, which is along a turning axis what a force is along a straight one, is `force`.

    Raises:
        SchemaError: an unknown channel or unit, one of the other kind of axis, or no time.
    """
    specs = {}
    for called, table in tables.items():
        name = _name(called, plant)
        unit = unit_of(name, plant)
        try:
            scale = factor(table.unit, unit) if table.unit != unit else 1.0
        except QuantityError:
            raise files.SchemaError(("channels", called, "unit"), _unit_mistake(name, table.unit, plant)) from None
        cutoff = quantity(table.anti_alias, "Hz", ("channels", called, "anti_alias"))
        raw = table.offset
        offset = raw * scale if isinstance(raw, float) else quantity(raw, unit, ("channels", called, "offset"))
        specs[name] = ChannelSpec(
            called, table.column, table.scale * scale, offset, cutoff, _doubt(called, table, unit, scale)
        )
    if "time" not in specs:
        raise files.SchemaError(("channels", "time"), "is missing; this key is needed here")
    return specs


def _doubt(called: str, table: ChannelTable, unit: str, scale: float) -> str:
    """That the column of a channel is, as it is called, what was wanted and not measured, or has another unit of the
    same kind; one with a `scale` of its own is converted by somebody who knows.
    """
    if called in SENSORS and isinstance(table.column, str) and is_reference(table.column):
        return f'the column of {called} is called "{table.column}", as what was wanted is: was it measured?'
    named = without_unit(table.column)[1] if isinstance(table.column, str) and table.scale == 1.0 else ""
    try:
        other = factor(named, unit) if named else scale
    except QuantityError:
        return ""
    if math.isclose(other, scale):
        return ""
    return f'the column of {called} is called "{table.column}", and its unit said to be {table.unit}: which is right?'


def quantity(value: float | str, unit: str, place: files.Key) -> float:
    """A quantity in SI.

    Raises:
        SchemaError: it is none of that unit.
    """
    try:
        return si(value, unit)
    except QuantityError as error:
        raise files.SchemaError(place, str(error)) from None


def _name(called: str, plant: Plant) -> str:
    """The name of a channel on a straight axis."""
    turns = plant.axis == ROTARY
    if called == (FORCE if turns else TORQUE):
        meant = f'a torque: call the channel "{TORQUE}", in N m' if turns else f'a force: call it "{FORCE}", in N'
        way = f"the axis of {plant.name} {AXES[plant.axis]}, and what drives it is {meant}"
        raise files.SchemaError(("channels", called), way)
    if called == TORQUE:
        return FORCE
    if called not in CHANNELS:
        raise files.SchemaError(("channels", called), f"unknown channel; {nearest(called, [*CHANNELS, TORQUE])}")
    return called


def _unit_mistake(name: str, got: str, plant: Plant) -> str:
    unit = unit_of(name, plant)
    if got == "1":
        return f'got no unit; expected that of the column, such as unit = "{unit}"'
    if meant := nearest_unit(got, unit):
        return f'got "{got}"; did you mean "{meant}"?'
    other = LINEAR if plant.axis == ROTARY else ROTARY
    if name != "command" and unit_along(CHANNELS[name], other) != unit_along(CHANNELS[name], plant.axis):
        try:
            factor(got, unit_along(CHANNELS[name], other))
        except QuantityError:
            return f'got "{got}", expected a unit such as "{unit}"'
        return (
            f'got "{got}", the unit of an axis that {AXES[other]}, and that of {plant.name} {AXES[plant.axis]}: '
            f'expected a unit such as "{unit}", or a plant whose axis {AXES[other]}'
        )
    return f'got "{got}", expected a unit such as "{unit}"'
