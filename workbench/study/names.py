"""Names of what runs leave behind, with their units: signals over time, and columns of the results."""

import json
from collections.abc import Mapping
from contextlib import suppress
from typing import SupportsFloat

from controllers.interface import Controller
from controllers.registry import controllers
from plants.axis import AXES, LINEAR, unit_along
from plants.equation import fields
from plants.interface import SENSORS, Measurement, Plant
from plants.registry import plants
from workbench.metrics.interface import ending
from workbench.metrics.registry import columns
from workbench.simulation.run import ESTIMATE, FRICTION_ERROR, MEASURED, TRUE, Run
from workbench.simulation.setup import memory_names
from workbench.toml.units import COMMAND, factor

TRACKING = ("reference_position", "reference_velocity", "error")
"""Signals of runs that have a reference."""

SIGNAL_UNITS = {
    "time": "s",
    "error": "m",
    FRICTION_ERROR: "N",
    "reference_position": "m",
    "reference_velocity": "m/s",
    **{f"{MEASURED}{item.name}": item.unit for item in fields(Measurement) if item.name in SENSORS},
}
"""Units of signals that no plant declares."""

BASE_UNITS = {
    "deg": "deg",
    "m": "m",
    "s": "s",
    "W": "W",
    "V": "V",
    "J": "J",
    "N": "N",
    "N_m": "N m",
    "N_s_per_m": "N s/m",
    "m_per_s": "m/s",
    "m_per_s3": "m/s^3",
    "rad": "rad",
    "rad_per_s": "rad/s",
    "rad_per_s3": "rad/s^3",
    "N_m_s_per_rad": "N m s/rad",
    "rpm": "rpm",
}
"""Units of figures that no metric declares, such as probes, by the ending of a column's name."""


def signals_of(plant: Plant, controller: Controller, tracks: bool) -> list[str]:
    """Names of the signals of a run; `tracks`: whether a position reference is followed."""
    names = [item.name for item in (*fields(plant.Signals), *fields(plant.Inputs))]
    measured = [f"{MEASURED}{name}" for name in SENSORS]
    memory = memory_names(controller)
    judged = [FRICTION_ERROR] if ESTIMATE in memory and TRUE in names else []
    return list(dict.fromkeys([*names, "time", *measured, *memory, *judged, *(TRACKING if tracks else ())]))


def signal_units(axis: str = LINEAR) -> dict[str, str]:
    """The SI unit of every signal that some plant of that axis, or a controller of one, has, by name; none of those in
    the command's unit.
    """
    units = {name: unit_along(unit, axis) for name, unit in SIGNAL_UNITS.items()}
    for plant in plants().values():
        for item in (*fields(plant.Signals), *fields(plant.Inputs)) if plant.axis == axis else ():
            units.setdefault(item.name, item.unit)
    for controller in controllers().values():
        for name, item in zip(memory_names(controller), fields(controller.State), strict=True):
            if COMMAND not in item.unit:
                units.setdefault(name, unit_along(item.unit, axis))
    return units


def units_of(run: Run) -> dict[str, str]:
    """The SI unit of every signal of a run, by name."""
    plant, controller = run.plant, run.loop.controller
    units = {item.name: item.unit for item in (*fields(plant.Inputs), *fields(plant.Signals))}
    for name, item in zip(memory_names(controller), fields(controller.State), strict=True):
        units[name] = plant.unit_for(item.unit)
    return {**{name: plant.unit_for(unit) for name, unit in SIGNAL_UNITS.items()}, **units}


def unit_of_column(column: str) -> str:
    """The unit that a metric declares for a result column, or else the one that its name ends in, "1" if none."""
    for axis in AXES:
        if (declared := columns(axis).get(column)) is not None:
            return declared.unit
    for name in sorted(BASE_UNITS, key=len, reverse=True):
        if column == name or column.endswith(f"_{name}"):
            return BASE_UNITS[name]
    return "1"


def without_unit(column: str) -> str:
    """The name of a result column without the unit that it ends in."""
    unit = unit_of_column(column)
    return column if unit == "1" else column.removesuffix(f"_{ending(unit)}")


def shown_factor(unit: str, shown: str) -> float:
    """What to multiply a value in `unit` with to show it in `shown`; "1" shows it as it is stored.

    Raises:
        QuantityError: the two do not measure the same.
    """
    return 1.0 if shown == "1" else factor(unit, shown)


def matches(columns: Mapping[str, object], where: Mapping[str, object]) -> bool:
    """Whether a case has the values that `where` asks for; numbers are compared as numbers, "460" being one."""
    return all(comparable(columns.get(key)) == comparable(value) for key, value in where.items())


def comparable(value: object) -> float | str:
    """A value such that equal ones compare equal: a number where it is one, however it is written."""
    if isinstance(value, list | dict):
        return json.dumps(value)
    if isinstance(value, str | float | int | SupportsFloat):  # SupportsFloat alone would do, slower
        with suppress(TypeError, ValueError):
            return float(value)
    return str(value)


def in_words(where: Mapping[str, object]) -> str:
    """Conditions as a message says them."""
    return ", ".join(f"{key} {value}" for key, value in where.items())
