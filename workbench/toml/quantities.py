"""Types of quantities in a study file: read with their unit, kept in SI."""

from functools import partial
from typing import Annotated

from pydantic import BaseModel, BeforeValidator, PlainValidator, StrictFloat

from plants.axis import KINDS, LINEAR, ROTARY
from workbench.errors import spelled
from workbench.toml.reading import Key, SchemaError
from workbench.toml.units import QuantityError, example, si

Raw = StrictFloat | str
"""A quantity whose unit depends on its place; converted when the case is resolved."""


class AxisNumber(float):
    """A length or a speed (SI) along an axis: `unit` is that of the axis for which it was written, "" for any."""

    unit: str = ""

    @classmethod
    def read(cls, value: object, per: str = "") -> "AxisNumber":
        """A quantity in m or rad, or with `per` "/s" in m/s or rad/s."""
        try:
            return cls._of(value, LINEAR, per)
        except QuantityError as error:
            try:
                return cls._of(value, ROTARY, per)
            except QuantityError:
                raise error from None

    @classmethod
    def _of(cls, value: object, axis: str, per: str) -> "AxisNumber":
        number = cls(si(value, axis + per))
        number.unit = axis + per if isinstance(value, str) else ""
        return number


def along_axis(number: float, axis: str, key: Key) -> float:
    """A number of a study, if it was written for an axis whose positions are in `axis`.

    Raises:
        SchemaError: it was written for another.
    """
    unit = getattr(number, "unit", "")
    expected = f"{axis}/s" if unit.endswith("/s") else axis
    if unit not in ("", expected):
        raise SchemaError(key, f"got a quantity in {unit}, expected {example(expected)}: {KINDS[axis]}")
    return float(number)


def check_along(table: BaseModel, axis: str, key: Key) -> None:
    """All numbers of a table that lie along the axis, likewise."""
    for name, value in table:
        for i, item in enumerate(value if isinstance(value, list) else [value]):
            place = (*key, name, i) if isinstance(value, list) else (*key, name)
            if isinstance(item, BaseModel):
                check_along(item, axis, place)
            elif isinstance(item, AxisNumber):
                along_axis(item, axis, place)


Length = Annotated[AxisNumber, PlainValidator(AxisNumber.read)]
Speed = Annotated[AxisNumber, PlainValidator(partial(AxisNumber.read, per="/s"))]
"""Along the axis of the study's plants: in m, or in rad."""

Metre = Annotated[float, BeforeValidator(partial(si, unit="m"))]
MetrePerSecond = Annotated[float, BeforeValidator(partial(si, unit="m/s"))]
Second = Annotated[float, BeforeValidator(partial(si, unit="s"))]
Hertz = Annotated[float, BeforeValidator(partial(si, unit="Hz"))]
NewtonMetre = Annotated[float, BeforeValidator(partial(si, unit="N m"))]
Radian = Annotated[float, BeforeValidator(partial(si, unit="rad"))]


def rpm_si(value: object) -> float:
    """A speed of rotation in rad/s; unlike elsewhere a bare number is in rpm, the unit of the axis' name."""
    try:
        speed = si(f"{value} rpm" if isinstance(value, int | float) and not isinstance(value, bool) else value, "rad/s")
    except QuantityError:
        raise QuantityError(f'got {spelled(value)}, expected a speed of rotation, such as 460 or "460 rpm"') from None
    if speed < 0.0:
        raise QuantityError(f"got {spelled(value)}, expected a speed that is not negative")
    return speed


Rotation = Annotated[float, BeforeValidator(rpm_si)]
