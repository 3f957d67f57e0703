"""Units at the edge: text such as "2.94 MPa" to SI floats and back. Nothing else in the project knows units."""

import functools
import math
from typing import Any

import pint

COMMAND = "command"
"""Stands for the unit of a plant's command in the units of controller gains."""


class QuantityError(ValueError):
    """A quantity that cannot be read, or has the wrong unit."""


@functools.cache
def _registry() -> Any:
    registry: Any = pint.UnitRegistry(cache_folder=None)
    registry.formatter.default_format = "~C"
    return registry


@functools.cache
def _si(text: str, unit: str) -> float:
    registry = _registry()
    try:
        quantity = registry.Quantity(text)
        expected = registry.Unit(unit if unit != "1" else "dimensionless")
    except Exception as error:
        raise QuantityError(f'got "{text}", which is not a number with a unit; expected {example(unit)}') from error
    if not isinstance(quantity.magnitude, int | float) or quantity.dimensionality != expected.dimensionality:
        got = f'got "{text}"'
        if quantity.dimensionless:
            got += " without a unit (write a bare number, without quotes, for SI)"
        raise QuantityError(f"{got}, expected {example(unit)}")
    return float(quantity.to_base_units().magnitude)


def example(unit: str) -> str:
    """How a quantity of this unit is written, for error messages."""
    return "a plain number" if unit == "1" else f'a quantity in {unit}, such as "1 {unit}"'


def si(value: Any, unit: str, command: str = "V") -> float:
    """A number (already SI) or text with a unit, as an SI float.

    Args:
        value: 2940000.0 or "2.94 MPa".
        unit: what is expected, SI, such as "Pa"; `command` in it stands for the unit of the plant's command.
        command: that unit.

    Raises:
        QuantityError: not a quantity, another dimension, or NaN.
    """
    unit = unit.replace(COMMAND, command)
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise QuantityError(f"got {value!r}, expected {example(unit)}")
    if isinstance(value, str):
        stripped = value.strip()
        number = math.inf if stripped in ("inf", "+inf") else _si(stripped, unit)
    else:
        number = float(value)
    if math.isnan(number):
        raise QuantityError(f"got NaN, expected {example(unit)}")
    return number


@functools.cache
def factor(unit: str, shown: str) -> float:
    """What to multiply a value in SI `unit` with to show it in unit `shown`.

    Raises:
        QuantityError: the two do not measure the same.
    """
    registry = _registry()
    try:
        ratio = registry.Quantity(1.0, unit if unit != "1" else "").to(shown if shown != "1" else "")
    except Exception as error:
        raise QuantityError(f'"{shown}" is not a unit of what is in {unit or "no unit"}') from error
    return float(ratio.magnitude)
