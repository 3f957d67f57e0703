"""Knobs of the bench: keys of a study as sliders, choices and switches, with units, ranges and sources."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from workbench.bench.loop import Change
from workbench.toml.units import factor, si

RPM = 30.0 / math.pi
"""Of a rad/s."""

DECADE = 10.0
"""How far a slider reaches to either side of a value of whose range nothing is said, in factors."""


@dataclass(frozen=True)
class Knob:
    """A number of the loop: `value`, `low` and `high` in SI `unit` (rpm of a speed of rotation), shown in `shown`.

    `key` is the key of the study that it sets, `linked` are others that get the same value, and `also` are those that
    keep theirs by being set with it. What the key says the study multiplies by `times`. A slider of it is
    `logarithmic`, with 0 at its left end where the number `may_be_off`.
    """

    key: str
    label: str
    value: float
    unit: str
    low: float = 0.0
    high: float = 1.0
    logarithmic: bool = False
    may_be_off: bool = False
    shown: str = ""
    tip: str = ""
    also: Change = field(default_factory=dict)
    linked: tuple[str, ...] = ()
    times: float = 1.0

    def change(self, value: float) -> Change:
        """What turning it to `value` changes of the loop."""
        said = value / self.times
        return {self.key: said, **dict.fromkeys(self.linked, said), **self.also}

    def turned(self, change: Change) -> "Knob":
        """The knob as it stands after a change that `change` made."""
        said = change.get(self.key)
        return replace(self, value=said * self.times) if isinstance(said, float) else self

    @property
    def factor(self) -> float:
        """What one of the unit that is shown is in the knob's own."""
        return 1.0 if self.shown in ("", self.unit) else factor(self.shown, self.unit)

    @property
    def text(self) -> str:
        """The value as it is shown, and may be typed."""
        unit = self.shown or self.unit
        return f"{self.value / self.factor:.6g}{'' if unit == '1' else f' {unit}'}"

    def read(self, text: str) -> float:
        """The number (SI) that was typed; without a unit it is in that which is shown.

        Raises:
            QuantityError: no number, or another unit.
        """
        try:
            return float(text) * self.factor
        except ValueError:
            return si(text, "rad/s") * RPM if self.unit == "rpm" else si(text, self.unit)

    @property
    def place(self) -> float:
        """Where the value is on the slider, from 0 to 1."""
        if not self.logarithmic:
            return min(max((self.value - self.low) / (self.high - self.low), 0.0), 1.0)
        if self.value <= self.low:
            return 0.0
        return min(math.log(self.value / self.low) / math.log(self.high / self.low), 1.0)

    def at(self, place: float) -> float:
        """The value (SI) at a place of the slider, with no more digits than tell places apart."""
        if self.logarithmic and self.may_be_off and place <= 0.0:
            return 0.0
        if self.logarithmic:
            value = self.low * (self.high / self.low) ** place
            return _rounded(value, value * math.log(self.high / self.low) / APART)
        return _rounded(self.low + place * (self.high - self.low), (self.high - self.low) / APART)


APART = 1000
"""Places of a slider that differ."""


def _rounded(value: float, step: float) -> float:
    """A value to the power of ten that is no more than `step`."""
    return round(value, -math.floor(math.log10(step)))


@dataclass(frozen=True)
class Choice:
    """One of several names: `options` are these, with what a reader is shown of each."""

    key: str
    label: str
    value: str
    options: Sequence[tuple[str, str]]
    tip: str = ""


@dataclass(frozen=True)
class Switch:
    """An effect that is on or off, and the changes by which it is turned on and off."""

    key: str
    label: str
    value: bool
    on: Change
    off: Change
    tip: str = ""


Control = Knob | Choice | Switch


def ranged(knob: Knob) -> Knob:
    """A knob of whose range nothing is said: a decade to either side of its value; from 0 to two of its unit at 0."""
    size = abs(knob.value) or knob.factor
    if knob.value > 0.0:
        return replace(knob, low=size / DECADE, high=size * DECADE, logarithmic=True)
    return replace(knob, low=-2.0 * size if knob.value else 0.0, high=2.0 * size)
