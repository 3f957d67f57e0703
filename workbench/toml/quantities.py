"""Types of quantities in a study file: read with their unit, kept in SI."""

from functools import partial
from typing import Annotated

from pydantic import BeforeValidator, StrictFloat

from workbench.toml.units import QuantityError, si

Raw = StrictFloat | str
"""A quantity whose unit depends on its place; converted when the case is resolved."""

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
        raise QuantityError(f'got {value!r}, expected a speed of rotation, such as 460 or "460 rpm"') from None
    if speed < 0.0:
        raise QuantityError(f"got {value!r}, expected a speed that is not negative")
    return speed


Rotation = Annotated[float, BeforeValidator(rpm_si)]
