"""What a plant is: its equations, what they are made of, and what a rig measures of them."""

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from plants.axis import name_along, unit_along
from plants.equation import fields, from_array, unmarked

if TYPE_CHECKING:
    from plants.effects.interface import Effect
    from plants.laws.interface import FrictionLaw


class Measurement(NamedTuple):
    """What a rig's sensors deliver, and all that a controller ever sees of a plant; NaN where it has none.

    `friction` is no rig's: the hypothetical gauge of `plants.friction_gauge`, NaN unless a study asks for it, and then
    for the controller of that name alone.
    """

    position: Annotated[float, "m"]
    pressure_1: Annotated[float, "Pa"]
    pressure_2: Annotated[float, "Pa"]
    rotation_speed: Annotated[float, "rad/s"]
    motor_current: Annotated[float, "A"] = math.nan
    friction: Annotated[float, "N"] = math.nan


GAUGE = "friction"
"""The channel of the hypothetical friction gauge."""

SENSORS = tuple(name for name in Measurement._fields if name != GAUGE)
"""Channels that a rig can have: the first of a `Measurement`, in its order."""


def unlimited(parameters: object) -> float:
    """The travel (m) of a plant without end stops, the limit of a rotary command without one."""
    return math.inf


class Balance(NamedTuple):
    """A physical balance: what changes these states of a plant, in the unit in which one speaks of it.

    Its residual is the measured rate of each state less that of `derivatives`, times `scale(parameters)`, one number
    for each state: the mass makes a force of an acceleration.
    """

    states: tuple[str, ...]
    unit: str
    scale: Callable[[Any], tuple[float, ...]]


@dataclass(frozen=True, eq=False)
class Plant:
    """A plant: names and units (as NamedTuple classes) and the equations over them.

    derivatives(time, state, inputs, parameters) -> State      rates of the states
    signals(time, state, inputs, parameters) -> Signals        all that is worth plotting, SI
    measure(state, parameters) -> Measurement                  noise-free readings
    equilibrium(parameters, surface_speed) -> (State, Inputs)  at rest in mid-stroke, rotating at that speed (m/s)
    command_limit(parameters) -> float                         the amplifier's limit, unit of the command
    travel(parameters) -> float                                distance (m) between the end stops about position 0
    rotary_limit(parameters) -> float                          the motor drive's limit, unit of the rotary command

    `State` holds at least `position` and `velocity`. `command` is the input that the position controller drives,
    `rotary_command` the one that rotates. `balances` are those that the equations are made of, by name; a record is
    diagnosed by them. `friction` names the friction law, and `refit` makes the plant anew with another;
    `turned(bristle, imposed)` makes it with a rod that turns, by a motor or with an imposed speed. `contact` is the
    field of the state that holds what the contact remembers, "" where there is none. `effects` are the names of
    those that the plant was given, and `bare` is the plant without.

    `delayed` names the inputs that are the command of a time ago, each with that time: delay(parameters) -> s. Nobody
    feeds them; a simulation does, exactly, whatever its sample time. `unknown` are the parameters, in either direction,
    that an identification frees where an experiment does not say which, of a plant without a friction law.
    `frozen_volumes` says that the chambers have their volumes at mid-stroke whatever the position.
    """

    name: str
    summary: str
    State: type[NamedTuple]
    Inputs: type[NamedTuple]
    Parameters: type[NamedTuple]
    Signals: type[NamedTuple]
    derivatives: Callable[..., Any]
    signals: Callable[..., Any]
    measure: Callable[..., Any]
    equilibrium: Callable[..., Any]
    command_limit: Callable[..., float]
    command: str
    balances: dict[str, Balance]
    rotary_command: str | None = None
    travel: Callable[[Any], float] = unlimited
    rotary_limit: Callable[[Any], float] = unlimited
    friction: str = ""
    turned: Callable[[str, bool], "Plant"] | None = None
    refit: Callable[["FrictionLaw"], "Plant"] | None = None
    contact: str = ""
    effects: tuple[str, ...] = ()
    bare: "Plant | None" = None
    delayed: Mapping[str, Callable[[Any], float]] = field(default_factory=dict)
    unknown: tuple[str, ...] = ()
    frozen_volumes: bool = False

    def with_friction(self, law: "FrictionLaw") -> "Plant":
        """The same plant with another friction law.

        Raises:
            ValueError: it takes no other, the law has no form for it, or is no equation.
        """
        if law.name == self.friction:
            return self
        if self.refit is None:
            raise ValueError(f'plant "{self.name}" has a friction of its own and takes no law')
        if mistake := unmarked((law.friction,)):
            raise ValueError(f'friction law "{law.name}": {mistake}')
        return self.refit(law)

    def with_turning_rod(self, bristle: str, imposed: bool = False) -> "Plant":
        """The same plant with a rod that turns, against friction with bristles of that name.

        Args:
            bristle: "helical", "isotropic" or "anisotropic", of those that the friction law has.
            imposed: whether the speed of its surface is an input; else a motor turns it.

        Raises:
            ValueError: it has no rod that turns, or the law has no such bristles.
        """
        if self.turned is None:
            raise ValueError(f'plant "{self.name}" has no rod that turns')
        return self.turned(bristle, imposed)

    def with_effects(self, *effects: "Effect") -> "Plant":
        """The same plant with effects, neutral until their parameters are given.

        They add to those that it has, and act in the order of the registry. The parameters get a field `effects`, the
        states too where an effect remembers.

        Raises:
            ValueError: the plant lacks what an effect changes, or a function of an effect is no equation.
        """
        from plants.effects.attach import with_effects  # it makes plants

        return with_effects(self, effects)

    @functools.cached_property
    def channels(self) -> tuple[str, ...]:
        """Channels that the plant's sensors show: those of `measure` that are numbers."""
        ones = [from_array(cls, [1.0] * len(fields(cls))) for cls in (self.State, self.Parameters)]
        with np.errstate(all="ignore"):  # laws divide by what is 0 for some of these numbers
            shown = self.measure(*ones)._asdict()
        return tuple(name for name, value in shown.items() if not math.isnan(value))

    @property
    def command_unit(self) -> str:
        """Unit of the command, "V" or "N"."""
        return next(field.unit for field in fields(self.Inputs) if field.name == self.command)

    @functools.cached_property
    def axis(self) -> str:
        """Unit of the position: "m" of an axis that goes straight, "rad" of one that turns (`plants.axis`)."""
        return next(field.unit for field in fields(self.State) if field.name == "position")

    def unit_for(self, unit: str) -> str:
        """What a unit of a controller is here, on this axis and with this command: "V/m" for "command/m"."""
        return unit_along(unit, self.axis).replace("command", self.command_unit)

    @property
    def disturbance(self) -> str:
        """The input by which a force (N), on a turning axis a torque (N m), acts against the motion."""
        return name_along("disturbance_force", self.axis)

    def input_index(self, name: str) -> int:
        """Place of an input among `Inputs`."""
        return [field.name for field in fields(self.Inputs)].index(name)
