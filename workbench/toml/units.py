"""Units at the edge: text such as "2.94 MPa" to SI floats and back. Nothing else in the project knows units."""

import functools
import math
import re
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

from workbench.errors import shortened, spelled
from workbench.toml.kept import kept_with

if TYPE_CHECKING:
    import pint
    from pint.facets.plain import PlainQuantity

COMMAND = "command"
"""Stands for the unit of a plant's command in the units of controller gains."""


class QuantityError(ValueError):
    """A quantity that cannot be read, or has the wrong unit."""


class _OtherDimensionError(Exception):
    """A unit of something else than what is expected."""


@functools.cache
def _registry() -> "pint.UnitRegistry[float]":
    """Pint and its units, which take half a second; what it has said once is kept."""
    import pint

    registry: pint.UnitRegistry[float] = pint.UnitRegistry(cache_folder=None)
    registry.formatter.default_format = "~C"
    return registry


_QUANTITY = re.compile(
    r"(?P<number>[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?)(\s*(?P<unit>[^\d\s,;.+-][^,;]*)|\s+(?P<inverse>1/[^,;]*))?"
)
"""A number and a unit; one such as 1/s stands off from its number."""


LONGEST_UNIT = 60
"""Characters of a unit."""

_ENDLESS = re.compile(r"\d{4}|(\*\*|\^)[\s(+-]*[\d.]+[\s)]*(\*\*|\^)")
"""Numbers in a unit that would take for ever to raise to a power."""


@functools.cache
def _si(text: str, unit: str) -> float:
    parts = _QUANTITY.fullmatch(text)
    if parts is None:
        raise QuantityError(f'got "{shortened(text)}", which is not a number with a unit; expected {example(unit)}')
    named, number = parts["unit"] or parts["inverse"] or "", float(parts["number"])
    try:
        scale = _si_factor(named, unit)
        return number * scale if scale is not None else float(_base(number, named).magnitude)
    except _OtherDimensionError:
        got = f'got "{shortened(text)}"'
        if not named:
            got += " without a unit (write a bare number, without quotes, for SI)"
        raise QuantityError(f"{got}, expected {example(unit)}") from None
    except Exception as error:
        meant = nearest_unit(named, unit)
        hint = f'; did you mean "{shortened(parts["number"])} {meant}"?' if meant else f"; expected {example(unit)}"
        raise QuantityError(f'got "{shortened(text)}", which is not a number with a unit{hint}') from error


def _base(number: float, named: str) -> "PlainQuantity[float]":
    """A number of unit `named` in base units, which keep the radian: a frequency in Hz is no speed in rad/s."""
    registry = _registry()
    return registry.Quantity(number, registry.Unit(named)).to_base_units()


@kept_with("pint")
def _si_factor(named: str, unit: str) -> float | None:
    """What to multiply a number of unit `named` with to have it in SI `unit`; None where the two zeros differ.

    Raises:
        _OtherDimensionError: the two do not measure the same.
        Exception: pint's, for what is no unit.
    """
    if len(named) > LONGEST_UNIT or _ENDLESS.search(named):
        raise ValueError("no unit is so long, or has such powers")
    registry, one = _registry(), _base(1.0, named)
    expected = registry.Quantity(1.0, "" if unit == "1" else unit).to_base_units().units
    if one.units not in (expected, _without_radian(expected) if named else expected):
        raise _OtherDimensionError
    return float(one.magnitude) if _base(0.0, named).magnitude == 0.0 else None


def _without_radian(unit: Any) -> Any:
    """A unit that is a radian's, as people write it: a viscous friction in N m s is one in N m s/rad."""
    per_radian = dict(unit._units).get("radian", 0)
    return unit / _registry().Unit("radian") ** per_radian if per_radian < 0 else unit


@functools.cache
def base_units(unit: str) -> tuple[float, dict[str, float]]:
    """A unit as a multiple of the SI's base units and the radian: the factor, and their exponents by name ("meter").

    Raises:
        QuantityError: it is no unit.
    """
    try:
        if len(unit) > LONGEST_UNIT or _ENDLESS.search(unit):
            raise ValueError("no unit is so long, or has such powers")
        one = _base(1.0, "" if unit == "1" else unit)
    except Exception as error:
        raise QuantityError(f'"{shortened(unit)}" is no unit') from error
    powers: Any = one.units._units
    return float(one.magnitude), {str(name): float(power) for name, power in powers.items()}


def said_in(text: str, unit: str) -> float:
    """What is said on a command line in SI `unit`: a quantity with its unit, or a bare number in SI.

    Raises:
        QuantityError: neither, or a quantity of another kind.
    """
    return si(float(text) if unit_written(text) == "" else text, unit)


def unit_written(value: object) -> str | None:
    """The unit that a quantity is written with, "" of a bare number, None of what is no quantity."""
    parts = _QUANTITY.fullmatch(str(value).strip())
    if parts is None:
        return None
    unit = parts["unit"] or parts["inverse"] or ""
    return unit if not unit or _converts(unit, unit) else None


def nearest_unit(text: str, unit: str) -> str:
    """The unit that a misspelled one is taken for, of those that measure what `unit` does; empty without any."""
    close = get_close_matches(text, _SPELLED, n=len(_SPELLED), cutoff=0.75)
    return next((name for name in close if _converts(name, unit)), "")


def _converts(name: str, unit: str) -> bool:
    try:
        factor(unit, name)
    except QuantityError:
        return False
    return True


_WORDS = ("meter", "metre", "second", "pascal", "volt", "ampere", "newton", "gram", "hertz", "radian", "watt")
_SHORT = ("bar", "psi", "inch", "minute", "degree", "rpm", "mm", "cm", "um", "ms", "kPa", "MPa", "Pa", "mV", "mA", "kN")
_SPELLED = (*(prefix + name for name in _WORDS for prefix in ("", "milli", "micro", "centi", "kilo", "mega")), *_SHORT)


def example(unit: str) -> str:
    """How a quantity of this unit is written, for error messages."""
    return "a plain number" if unit == "1" else f'{_KINDS.get(unit, "a quantity")} in {unit}, such as "1 {unit}"'


_KINDS = {"N m": "a torque"}
"""What is said of a unit that a slip of the pen makes another one of: N m and N."""


def si(value: object, unit: str, command: str = "V", *, infinite: bool = False) -> float:
    """A number (already SI) or text with a unit, as an SI float.

    Args:
        value: 2940000.0 or "2.94 MPa".
        unit: what is expected, SI, such as "Pa"; `command` in it stands for the unit of the plant's command.
        command: that unit.
        infinite: whether "inf" will do.

    Raises:
        QuantityError: not a quantity, another dimension, not finite.
    """
    unit = unit.replace(COMMAND, command)
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise QuantityError(f"got {spelled(value)}, expected {example(unit)}")
    if isinstance(value, str):
        stripped = value.strip()
        number = math.inf if stripped == "inf" else _si(stripped, unit)
    else:
        number = float(value)
    if math.isnan(number):
        raise QuantityError(f"got NaN, expected {example(unit)}")
    if math.isinf(number) and not infinite:
        raise QuantityError(f"got {number}, expected a finite value")
    return number


@kept_with("pint")
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
