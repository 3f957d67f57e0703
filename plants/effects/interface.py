"""What an effect is: one object with its equations, parameters, signs and words, that any plant can take.

An effect changes parameters, inputs, rates or readings of a plant, each by an equation of its own. Evaluated along a
measured motion it is a candidate for what a model lacks; in `Plant.with_effects` it is simulated.
"""

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, NamedTuple

from plants import axis as axes
from plants.equation import Equation, fields
from plants.laws.interface import Nothing

FREE = 1e300
"""No bound."""

COMMAND = "command"
"""In the place of an input's name: the one that the position controller drives, whatever it is called."""


DISTURBANCE = "disturbance_force"
"""The input by which a force on the mass that is no plant's own acts, against the motion."""


class Moment(NamedTuple):
    """What the equations of an effect know of an instant.

    Pressures are NaN, spool, its gain and limit and speeds of rotation 0, and the stroke is infinite, for a plant
    without.
    """

    time: Annotated[float, "s"]
    position: Annotated[float, "m"]
    velocity: Annotated[float, "m/s"]
    surface_speed: Annotated[float, "m/s"]
    rotation_speed: Annotated[float, "rad/s"]
    pressure_1: Annotated[float, "Pa"]
    pressure_2: Annotated[float, "Pa"]
    spool_position: Annotated[float, "m"]
    stroke: Annotated[float, "m"]
    spool_gain: Annotated[float, "m/V"]
    spool_limit: Annotated[float, "m"]


class Scales(NamedTuple):
    """What is large on a machine (SI): by these a search knows which size of an effect is felt.

    The force is that of friction at rest; the travel the stroke, or where that is not known the way of a record;
    `spool` the valve's travel, `duration` the longest record's.
    """

    force: float
    travel: float
    speed: float
    pressure: float
    flow: float
    spool: float
    duration: float


def plain(scales: Scales) -> float:
    """The scale of what is the same on every machine: shares, and times of a contact or of a converter."""
    return 1.0


@dataclass(frozen=True)
class Number:
    """Between which values a parameter of an effect may lie, and a `size` that is felt, where a search starts: in
    multiples of a machine's `scale`. A size of 0 starts from the declared value, of the other direction if need be.
    """

    low: float
    high: float
    size: float
    scale: Callable[[Scales], float] = plain


Change = Equation
"""An equation (value, moment, memory, parameters, own) -> value of an effect."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Effect:
    """An effect: the balance on which it shows, its parameters, and what it changes of a plant.

    `words` say what it is to a reader who does not know its name. `numbers` are its parameters by canonical name, and
    `apart` the sets of them that may act alone, the smallest first: all together where none are given. `needs` are the
    channels without which it cannot be told, `acts_on` the signals over which it shows beyond those that are always
    looked at. A `circular` one is made of what it is to explain: the pressure carries every force that is not known.
    One that is not `sought` is declared or not there: no diagnosis looks for it.

    `Own` are those parameters that a plant has not by itself, neutral at their defaults, and `Memory` its states. With
    these, its equations change what they name, if the plant has it:

        parameters[field](value, moment, memory, parameters, own) -> value      a nested tuple of the plant's
        inputs[name](value, moment, memory, parameters, own) -> value           SI; `COMMAND` stands for the command
        rates[state](value, moment, memory, parameters, own) -> value           of the plant's states, SI
        readings[channel](value, moment, memory, parameters, own) -> value      of its sensors, SI; time is 0 there
        remember(slip, command, moment, memory, parameters, own) -> Memory      rates of its states

    `slip` (m/s) is the velocity at which the contact slides, its bristles taken off; the `command` is as the effects
    before this one, in the order of the registry, have made it. A plant can have the effect if it
    has all of the parameters' fields and inputs, and one of the rates, that are named here, and what it `requires`:
    fields of the parameters, states, or channels that the plant's sensors show.
    Its memory of a machine at rest is `at_rest(command)`, or the defaults. `axis` is that of the plants that can have
    it, "m" or "rad"; effects are written for "m", and `along` makes the others of them.
    """

    name: str
    balance: str
    words: str
    source: str
    numbers: Mapping[str, Number]
    apart: tuple[tuple[str, ...], ...] = ()
    needs: tuple[str, ...] = ()
    acts_on: tuple[str, ...] = ()
    circular: bool = False
    sought: bool = True
    requires: tuple[str, ...] = ()
    Own: type = Nothing
    Memory: type = Nothing
    parameters: Mapping[str, Change] = field(default_factory=dict)
    inputs: Mapping[str, Change] = field(default_factory=dict)
    rates: Mapping[str, Change] = field(default_factory=dict)
    readings: Mapping[str, Change] = field(default_factory=dict)
    remember: Equation | None = None
    at_rest: Callable[[float], NamedTuple] | None = None
    axis: str = axes.LINEAR

    @property
    def equations(self) -> tuple[Equation, ...]:
        """All that it has."""
        changes = (self.parameters, self.inputs, self.rates, self.readings)
        found = [change for table in changes for change in table.values()]
        return (*found, self.remember) if self.remember is not None else tuple(found)

    @property
    def meaning(self) -> str:
        """What the parameters that it brings mean, on one line; "" where their class does not say."""
        text = " ".join((self.Own.__doc__ or "").split())
        generated = text.startswith(f"{self.Own.__name__}(")
        return "" if self.Own is Nothing or generated else text

    @property
    def variants(self) -> tuple[tuple[str, ...], ...]:
        """The sets of its parameters that may act, the smallest first."""
        return self.apart or (tuple(self.numbers),)

    @property
    def signed(self) -> tuple[str, ...]:
        """Its parameters that may have either sign."""
        return tuple(name for name, number in self.numbers.items() if number.low < 0.0)

    @property
    def own_names(self) -> tuple[str, ...]:
        """The parameters that it brings."""
        return tuple(item.name for item in fields(self.Own))

    @property
    def neutral(self) -> dict[str, float]:
        """The values of the parameters that it brings at which it does nothing."""
        return {item.name: float(item.default or 0.0) for item in fields(self.Own)}

    @functools.cache  # noqa: B019 (effects are few, and live as long as the program)
    def along(self, axis: str) -> "Effect":
        """The same effect on an axis whose positions are in `axis`: its parameters have the names and units of that."""
        if axis == self.axis:
            return self
        return replace(
            self,
            words=axes.name_along(self.words, axis),
            numbers={axes.name_along(name, axis): number for name, number in self.numbers.items()},
            apart=tuple(tuple(axes.name_along(name, axis) for name in names) for names in self.apart),
            Own=axes.along(self.Own, axis),
            Memory=axes.along(self.Memory, axis),
            axis=axis,
        )
