"""Axes that go straight, and axes that turn: what stands for a metre, a newton and a kilogram on either.

The equations of a mass that moves are those of one that turns: position in rad for m, torque for force, inertia for
mass. They are written once, for an axis that goes straight, and its units are named anew for one that turns.
"""

import functools
import re
import typing
from typing import Annotated, NamedTuple

from plants.equation import Called, from_array, leaves, named_tuple

LINEAR, ROTARY = "m", "rad"
"""The SI unit of a position along the axis, by which an axis is known."""

AXES = (LINEAR, ROTARY)

KINDS = {LINEAR: "a straight axis", ROTARY: "a turning axis"}
"""In words."""

TURNED = {"m": "rad", "N": "N m", "kg": "kg m^2", "N m": "N m"}
"""What stands on a turning axis for the units of a straight one. A torque beside a straight axis is not along it."""

RENAMED = {"force": "torque", "mass": "inertia"}
"""Words in the names of parameters, inputs and signals, and what users call the same on a turning axis."""

_NAME = re.compile(r"N m\b|[A-Za-z]+")


@functools.cache
def unit_along(unit: str, axis: str) -> str:
    """The SI unit of a quantity along an axis of positions in `axis` ("m" or "rad"), from that of a straight one.

    "N s/m" becomes "N m s/rad", "m/s^2" becomes "rad/s^2", what is neither length nor force stays.

    >>> unit_along("N s/m", "rad")
    'N m s/rad'
    """
    if axis == LINEAR:
        return unit
    return _NAME.sub(lambda name: TURNED.get(name.group(), name.group()), unit)


@functools.cache
def name_along(name: str, axis: str) -> str:
    """What users call along an axis what is called `name` on a straight one; a sentence is said anew likewise.

    >>> name_along("load_force", "rad")
    'load_torque'
    """
    if axis == LINEAR:
        return name
    return _NAME.sub(lambda word: RENAMED.get(word.group(), word.group()), name)


@functools.cache
def along(template: type[NamedTuple], axis: str) -> type:
    """The NamedTuple class `template` of a straight axis, as that of `axis`: the same fields in other units.

    Equations know the fields by their names on a straight axis, users by those of `name_along`. It is an attribute of
    the template's module, called TEMPLATE_rad.
    """
    if axis == LINEAR or not template._fields:
        return template
    hints = typing.get_type_hints(template, include_extras=True)
    members = {name: _member_along(name, hint, axis) for name, hint in hints.items()}
    defaults = {
        name: from_array(members[name], leaves(value)) if isinstance(value, tuple) else value
        for name, value in template._field_defaults.items()
    }
    return named_tuple(f"{template.__name__}_{axis}", template.__module__, members, defaults, template.__doc__)


def _member_along(name: str, hint: type, axis: str) -> type:
    if typing.get_origin(hint) is not Annotated:
        return along(hint, axis)
    kind, unit, *others = typing.get_args(hint)
    called = Called(name_along(name, axis))
    return Annotated[kind, unit_along(unit, axis), *others, called]
