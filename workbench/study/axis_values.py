"""Values of an axis, or of a column of the results, as numbers in the unit in which they are shown."""

import math
from collections.abc import Sequence

from workbench.study.names import unit_of_column
from workbench.toml.quantities import rpm_si
from workbench.toml.units import QuantityError, factor, si, unit_written

RPM = "rpm"


def are_names(values: Sequence[object]) -> bool:
    """Whether values are names, such as those of controllers, and neither numbers nor quantities with a unit."""
    return any(isinstance(value, bool) or unit_written(value) is None for value in values)


def shown_unit(axis: str, values: Sequence[object], unit: str | None) -> str:
    """The unit in which an axis is shown: `unit` if it is given, else that of its values; "1" where none is known.

    Raises:
        QuantityError: a unit is given, and the values are names or measure something else.
    """
    if are_names(values):
        if unit not in (None, "1"):
            named = next(value for value in values if are_names([value]))
            raise QuantityError(f'got a unit for "{axis}", whose value "{named}" is a name; leave it out')
        return "1"
    if unit is None:
        unit = _own_unit(axis) or next((found for found in map(unit_written, values) if found), "1")
    numbers(axis, values, unit)
    return unit


def numbers(axis: str, values: Sequence[object], unit: str) -> list[float]:
    """Values in `unit`; bare numbers are in rpm on the axis of that name, else in the unit of a column or in SI.

    Raises:
        QuantityError: one that measures something else.
    """
    own = _own_unit(axis)
    if axis == RPM:
        speeds = [round(rpm_si(_number(value)) * 30.0 / math.pi, 6) for value in values]  # as those of the cases
        return [speed * _factor(RPM, unit) for speed in speeds]
    if own:
        return [float(str(value)) * _factor(own, unit) for value in values]
    if unit == "1":
        return [si(_number(value), unit_written(value) or "1") for value in values]
    return [si(_number(value), unit) / si(f"1 {unit}", unit) for value in values]


def _factor(unit: str, shown: str) -> float:
    return 1.0 if shown == "1" else factor(unit, shown)


def _own_unit(axis: str) -> str:
    """The unit that the name of a column says; "" where it says none, as that of a dotted key of the file."""
    unit = unit_of_column(axis)
    return "" if "." in axis or unit == "1" else unit


def _number(value: object) -> object:
    """A bare number as one, although it is text; text with a unit as it is."""
    return float(str(value)) if unit_written(value) == "" else value
