"""Friction after a long time at constant speed, of a law with one level over the speed: on a line, and in the plane."""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from plants.equation import Equation, Scalar, equation
from plants.friction import LuGre, blended, directed, helical_speed

Level: TypeAlias = Callable[[Scalar, LuGre], Scalar]
"""The level g (N) of friction at a speed (m/s), without the viscous part: an equation."""


def steady_along(level: Level) -> Equation:
    """The friction (N) on a line: (velocity, parameters) -> g(v) sgn(v) + a2 v."""

    @equation
    def steady(velocity: Scalar, p: Any) -> Scalar:
        own = directed(velocity, velocity, p.friction)
        return level(velocity, own) * np.sign(velocity) + own.viscous * velocity

    return steady


def steady_in_plane(level: Level) -> Equation:
    """The friction (N) along and around: (axial, rotary, parameters) -> (g(v_h) / v_h + a2) times each speed."""

    @equation
    def steady(axial: Scalar, rotary: Scalar, p: Any) -> tuple[Scalar, Scalar]:
        speed = helical_speed(axial, rotary)
        own = blended(axial / speed, axial / speed, p.friction)
        slope = level(speed, own) / speed + own.viscous
        return slope * axial, slope * rotary

    return steady
