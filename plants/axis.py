"""Axes that go straight, and axes that turn: what stands for a metre, a newton and a kilogram on either.

The equations of a mass that moves are those of one that turns: position in rad for m, torque for force, inertia for
mass. They are written once, for an axis that goes straight, and its units are named anew for one that turns.
"""

import functools
import re

LINEAR, ROTARY = "m", "rad"
"""The SI unit of a position along the axis, by which an axis is known."""

TURNED = {"m": "rad", "N": "N m", "kg": "kg m^2"}
"""What stands on a turning axis for the units of a straight one."""

_NAME = re.compile(r"[A-Za-z]+")


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
