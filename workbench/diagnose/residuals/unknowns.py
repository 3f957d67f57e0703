"""Parameters as a search sees them: logarithms of what is positive, multiples of a size of what has either sign."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plants.axis import AXES
from plants.effects.interface import FREE, Number, Scales
from plants.effects.registry import effects
from plants.equation import NEGATIVE
from workbench.parameters.sets import EITHER_SIGN, NEUTRAL

WIDEST = 10.0
"""A positive parameter stays within this factor of its start."""

VAGUE = 0.5 * float(np.log(WIDEST))
"""Standard deviation of the logarithm of a positive parameter about its start, before any record: two that records
cannot tell apart do not run away together."""

SURELY = 5.0
"""Standard deviations from what is declared, beyond which no search takes a parameter that is declared with one."""

Values = Mapping[str, float]
Priors = Mapping[str, tuple[float, float]]
"""What is declared of parameters with a deviation: value and standard deviation."""

Bounds = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Unknown:
    """A parameter as a search sees it: log(value / start), or value / size; where it is before any record, and the
    standard deviation of that, without bound if nothing is known.
    """

    name: str
    start: float
    size: float
    logarithmic: bool
    low: float
    high: float
    centre: float = 0.0
    deviation: float = np.inf

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


def idle(name: str, values: Values) -> float:
    """What a parameter is, or if it is not given, in the other direction, or where it does nothing."""
    return values.get(name, values.get(name.removesuffix(f"_{NEGATIVE}"), NEUTRAL.get(name, 0.0)))


def unknown(name: str, values: Values, bounds: Bounds, scales: Scales) -> Unknown:
    """A parameter as a search sees it that starts at these values, on a machine of these scales."""
    plain = name.removesuffix(f"_{NEGATIVE}")
    start = idle(name, values)
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
    if name in EITHER_SIGN and number is not None and number.shapes:  # beyond its neighbours in the grid another begins
        unit = number.scale(scales)
        size = unit * float(np.min(np.diff(number.grid)))
        least, most = max(low, min(number.low * unit, start)), min(high, max(number.high * unit, start))
        least, most = max(least, start - size), min(most, start + size)
        return Unknown(name, start, size, False, least / size, most / size)
    if number is not None and number.period_of:  # of what is longer than the way a piece is seen, as a spring's is
        high = min(high, number.high * number.scale(scales), WIDEST * start)
    if start > 0.0 and plain not in EITHER_SIGN:
        widest = float(np.log(WIDEST))
        least = float(np.log(low / start)) if low > 0.0 else -widest
        most = float(np.log(high / start)) if np.isfinite(high) else widest
        return Unknown(name, start, start, True, least, most, 0.0, VAGUE)
    least = low if plain in EITHER_SIGN else max(low, 0.0)
    return Unknown(name, start, max(abs(start), 1.0), False, least, high)


def declared_with(of: Unknown, value: float, std: float) -> Unknown:
    """The same of a parameter that is declared with a standard deviation."""
    centre, deviation = of.place(value), std / (value if of.logarithmic else of.size)
    low, high = (centre + side * SURELY * deviation for side in (-1.0, 1.0))
    return replace(of, low=max(of.low, low), high=min(of.high, high), centre=centre, deviation=deviation)


def values_at(values: Values, unknowns: Sequence[Unknown], places: np.ndarray) -> dict[str, float]:
    """The values with the unknowns where they are elsewhere, as a search sees them."""
    return {**values, **{u.name: u.value(float(place)) for u, place in zip(unknowns, places, strict=True)}}


def _number_of(name: str) -> Number | None:
    return next(
        (effect.numbers[name] for axis in AXES for effect in effects(axis).values() if name in effect.numbers), None
    )
