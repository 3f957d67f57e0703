"""What is tuned of a controller, and between which limits."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from controllers.interface import Controller
from controllers.settings import Setting, Tuned, idle, settings_of
from plants.interface import Plant
from workbench.errors import nearest, spelled
from workbench.toml.reading import SchemaError
from workbench.toml.units import QuantityError, si
from workbench.tune.schema import BoundTable, TuneTable

RPM, THRESHOLD = "rpm", "minimum_helical_speed"
"""Names of what is tuned of the rotation (rad/s, m/s); all others are settings of the controller."""

SHORT = 5
"""Significant digits with which a point is tried: what a gain file holds is what was tried."""

Point = Mapping[str, float]
"""Values (SI) of all that is tuned, by name."""


@dataclass(frozen=True)
class Dimension:
    """One tuned number (SI): its limits, the scale on which it is looked for, and where the study has it."""

    name: str
    unit: str
    low: float
    high: float
    logarithmic: bool
    start: float

    def share(self, value: float) -> float:
        """Where a value lies between the limits, 0 to 1, on the scale on which it is looked for."""
        if self.logarithmic:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def at(self, share: float) -> float:
        """The value at a share of the way between the limits, as it is tried."""
        if self.logarithmic:
            return self.shortened(self.low * (self.high / self.low) ** share)
        return self.shortened(self.low + share * (self.high - self.low))

    def shortened(self, value: float) -> float:
        """A value with as many digits as are tried, within the limits."""
        return min(max(float(f"{value:.{SHORT}g}"), self.low), self.high)


def space_of(
    name: str, controller: Controller, settings: NamedTuple, table: TuneTable, plant: Plant
) -> list[Dimension]:
    """The dimensions of a controller's gains.

    Without a table of its own under `gains` all settings are tuned that have a documented range, count, and are not 0:
    a term that the study leaves out stays out.

    Raises:
        SchemaError: a gain that the controller lacks, limits upside down, outside the admissible range or without any;
            nothing to tune.
    """
    declared, unused = settings_of(controller.Settings), idle(controller, settings)
    asked = table.gains.get(name)
    key = ("tune", "gains", name)
    if asked is None:
        chosen = {
            each.name: BoundTable()
            for each in declared.values()
            if each.tuned is not None and each.name not in unused and getattr(settings, each.name) != 0.0
        }
    else:
        chosen = dict(asked)
        for gain in chosen:
            numbers = [each.name for each in declared.values() if each.unit and each.name not in unused]
            if gain not in declared or not declared[gain].unit:
                raise SchemaError((*key, gain), f'"{controller.name}" has no such gain; {nearest(gain, numbers)}')
            if gain in unused:
                raise SchemaError((*key, gain), unused[gain])
    dimensions = [
        _dimension(declared[gain], getattr(settings, gain), bound, plant.unit_for(declared[gain].unit), (*key, gain))
        for gain, bound in chosen.items()
    ]
    if not dimensions:
        raise SchemaError(key, f'"{controller.name}" has nothing to tune here; name a gain with min and max')
    return dimensions


def _dimension(setting: Setting, value: float, bound: BoundTable, unit: str, key: tuple[str, ...]) -> Dimension:
    """Limits as the study gives them, else as documented."""
    documented = setting.tuned
    low, high = _documented(documented, value)
    for side in ("min", "max"):
        given = getattr(bound, side)
        if given is None:
            continue
        try:
            number = si(given, unit)
        except QuantityError as error:
            raise SchemaError((*key, side), str(error)) from None
        if not setting.about.admits(number):
            raise SchemaError((*key, side), f"got {spelled(given)}, expected {setting.about.expected}")
        low, high = (number, high) if side == "min" else (low, number)
    if math.isnan(low) or math.isnan(high):
        raise SchemaError(key, "has no documented range here; give it min and max")
    if not low < high:
        raise SchemaError(key, f"min {low:g} is not below max {high:g} (SI); turn the limits round")
    logarithmic = bound.scale == "log" if bound.scale else (documented is not None and documented.logarithmic)
    if logarithmic and low <= 0.0:
        if bound.scale:
            raise SchemaError(key, f'min {low:g} has no logarithm; give it a min above 0, or scale = "linear"')
        logarithmic = False
    return Dimension(setting.name, unit, low, high, logarithmic, value)


def _documented(tuned: Tuned | None, value: float) -> tuple[float, float]:
    """The documented limits (SI), nan where there are none."""
    if tuned is None or (tuned.by_factor and value == 0.0):
        return math.nan, math.nan
    factor = value if tuned.by_factor else 1.0
    return tuned.low * factor, tuned.high * factor


def rotation_of(table: TuneTable, rpm: float, threshold: float | None) -> list[Dimension]:
    """What is tuned of the rotation, which the study has at `rpm` (rpm), or beyond a `threshold` (m/s)."""
    if table.rotation is None:
        return []
    if (speeds := table.rotation.rpm) is not None:
        return [Dimension(RPM, "rad/s", speeds.min, speeds.max, False, rpm * math.pi / 30.0)]
    speed = table.rotation.minimum_helical_speed
    assert speed is not None  # the schema wants one of them
    return [Dimension(THRESHOLD, "m/s", speed.min, speed.max, True, speed.max if threshold is None else threshold)]
