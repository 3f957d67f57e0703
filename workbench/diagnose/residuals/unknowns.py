"""Parameters as a search sees them: logarithms of what is positive, multiples of a size of what has either sign."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plants.axis import AXES
from plants.effects.interface import FREE, Number, Scales
from plants.effects.registry import effects
from plants.equation import NEGATIVE
from workbench.parameters.sets import EITHER_SIGN, NEUTRAL

WIDEST = 10.0
"""A positive parameter stays within this factor of its start."""

Values = Mapping[str, float]
Bounds = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Unknown:
    """A parameter as a search sees it: log(value / start), or value / size."""

    name: str
    start: float
    size: float
    logarithmic: bool
    low: float
    high: float

    def value(self, x: float) -> float:
        return self.start * float(np.exp(x)) if self.logarithmic else self.size * x

    def slope(self, x: float) -> float:
        return self.value(x) if self.logarithmic else self.size

    def place(self, value: float) -> float:
        """Where a value is, as the search sees it."""
        return float(np.log(value / self.start)) if self.logarithmic else value / self.size

    @property
    def first(self) -> float:
        return self.place(self.start)


def unknown(name: str, values: Values, bounds: Bounds, scales: Scales) -> Unknown:
    """A parameter as a search sees it that starts at these values, on a machine of these scales."""
    plain = name.removesuffix(f"_{NEGATIVE}")
    start = values.get(name, values.get(plain, NEUTRAL.get(name, 0.0)))
    low, high = bounds.get(name, (-np.inf, np.inf))
    number = _number_of(name)
    if number is not None and number.size:
        unit = number.scale(scales)
        least, most, size = number.low * unit, number.high * unit, number.size * unit
        if start == NEUTRAL.get(name, 0.0) or name not in values:
            start = size if least == 0.0 else NEUTRAL.get(name, 0.0)
        elif NEUTRAL.get(name, 0.0) == 0.0:
            size = min(size, abs(start))  # by that much it is moved
        return Unknown(name, start, size, False, max(low, least) / size, min(high, most, FREE) / size)
    if start > 0.0 and plain not in EITHER_SIGN:
        widest = float(np.log(WIDEST))
        least = float(np.log(low / start)) if low > 0.0 else -widest
        most = float(np.log(high / start)) if np.isfinite(high) else widest
        return Unknown(name, start, start, True, least, most)
    least = low if plain in EITHER_SIGN else max(low, 0.0)
    return Unknown(name, start, max(abs(start), 1.0), False, least, high)


def values_at(values: Values, unknowns: Sequence[Unknown], places: np.ndarray) -> dict[str, float]:
    """The values with the unknowns where they are elsewhere, as a search sees them."""
    return {**values, **{u.name: u.value(float(place)) for u, place in zip(unknowns, places, strict=True)}}


def _number_of(name: str) -> Number | None:
    return next(
        (effect.numbers[name] for axis in AXES for effect in effects(axis).values() if name in effect.numbers), None
    )
