"""What a reader is shown of lengths, speeds and forces along an axis: mm and N, or deg and N m where it turns."""

import math
from dataclasses import dataclass

from plants.axis import KINDS, LINEAR, ROTARY, name_along, unit_along
from workbench.publish.tables import shown_number

SMALL = 1e-4
"""m or rad. Below it a length is shown in the smaller unit."""


@dataclass(frozen=True)
class Shown:
    """The units in which an axis of positions in `axis` is shown, with what SI values are to be multiplied with."""

    axis: str
    unit: str
    factor: float
    small_unit: str

    @property
    def speed_unit(self) -> str:
        """Of speeds, which have the same factor."""
        return f"{self.unit}/s"

    @property
    def force_unit(self) -> str:
        """Of forces, or torques, which are shown in SI."""
        return unit_along("N", self.axis)

    @property
    def units(self) -> dict[str, str]:
        """The unit that is shown for an SI one along the axis."""
        return {self.axis: self.unit, f"{self.axis}/s": self.speed_unit}

    @property
    def kind(self) -> str:
        """The axis in words."""
        return KINDS[self.axis]

    def scaled(self, largest: float) -> tuple[float, str]:
        """Factor and unit for lengths up to `largest` (SI): the smaller unit where that is small."""
        return (self.factor, self.unit) if largest >= SMALL else (1e3 * self.factor, self.small_unit)

    def length(self, value: float, digits: int = 3) -> str:
        """A length (SI) as it is said."""
        return f"{shown_number(self.factor * value, digits)} {self.unit}"

    def plain(self, value: float, digits: int = 6) -> str:
        """A length that somebody chose, with as many digits as it has."""
        return f"{self.factor * value:.{digits}g} {self.unit}"

    def speed(self, value: float, digits: int = 6) -> str:
        """A speed (SI), likewise."""
        return f"{self.factor * value:.{digits}g} {self.speed_unit}"

    def said(self, name: str) -> str:
        """The name of a force, a mass, or a sentence about them, as it is said of this axis."""
        return name_along(name, self.axis)


SHOWN = {LINEAR: Shown(LINEAR, "mm", 1e3, "µm"), ROTARY: Shown(ROTARY, "deg", 180.0 / math.pi, "mdeg")}
"""By the SI unit of the axis' positions."""
