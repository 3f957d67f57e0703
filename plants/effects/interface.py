"""What an effect is: one object with its equations, parameters, signs and words, that any plant can take.

An effect changes parameters, inputs, rates or readings of a plant, each by an equation of its own. Evaluated along a
measured motion it is a candidate for what a model lacks; in `Plant.with_effects` it is simulated.
"""

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, NamedTuple

from plants import axis as axes
from plants.effects.scales import Scales, plain
from plants.equation import Equation, Scalar, equation, fields, select
from plants.laws.interface import Nothing

FREE = 1e300
"""No bound."""

COMMAND = "command"
"""In the place of an input's name: the one that the position controller drives, whatever it is called."""


DISTURBANCE = "disturbance_force"
"""The input by which a force on the mass that is no plant's own acts, against the motion."""

FROZEN_VOLUMES = "frozen_volumes"
"""What an effect may require of a plant: chambers that have their volumes at mid-stroke whatever the position."""

BRISTLE = "bristle"
"""The same: a contact of LuGre's law, of one level along and around the rod."""

LONGEST_STROKE, UNKNOWN_STROKE = 1e3, 2.0
"""m. A stroke beyond the first is not known; the second is taken in its place: what changes along the stroke then
changes with the position in metres."""


class Moment(NamedTuple):
    """What the equations of an effect know of an instant.

    `bend` is the deflection of the bristles in the direction of the motion, negative where they are bent against it.
    Pressures are NaN, spool, its gain and limit, bend and speeds of rotation 0, and the stroke is infinite, for a plant
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
    bend: Annotated[float, "m"]


@equation
def stroke_share(moment: Moment) -> Scalar:
    """xi = 2 x / L (1), x (m) from mid-stroke: -1 and 1 at the ends of the stroke."""
    return 2.0 * moment.position / select(moment.stroke < LONGEST_STROKE, moment.stroke, UNKNOWN_STROKE)


@dataclass(frozen=True)
class Number:
    """Between which values a parameter of an effect may lie, and a `size` that is felt, where a search starts: in
    multiples of a machine's `scale`. A size of 0 starts from the declared value, of the other direction if need be.

    A number that does not size an effect but shapes it, and does nothing while those that size it are neutral, has no
    size of its own: a search of it begins from each value of the `grid`, in the same multiples. If it is the period
    over a signal, "position" or "time", `period_of` names that, and `frequency_of` if it is the frequency: it begins
    where waves over the signal take most of what is left, of which the effect's first two numbers are the amplitudes of
    cosine and sine. What swings at its frequency, with the damping ratio that `damped_by` names, stands out of a
    periodogram of what is left over a band, and where it is moved far from there it shows none: it begins from the
    grid, too.
    """

    low: float
    high: float
    size: float
    scale: Callable[[Scales], float] = plain
    grid: tuple[float, ...] = ()
    period_of: str = ""
    frequency_of: str = ""
    damped_by: str = ""

    @property
    def shapes(self) -> bool:
        """Whether it shapes an effect that others size."""
        return bool(self.grid)


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
    has the inputs, and one of the parameters' fields and of the rates, that are named here, and what it `requires`:
    fields of the parameters, states, channels that the plant's sensors show, `FROZEN_VOLUMES` or a `BRISTLE`.
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
    def shows_alone(self) -> bool:
        """Whether it changes what sensors show, and nothing besides."""
        return bool(self.readings) and len(self.equations) == len(self.readings)

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

    @functools.cached_property
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
