"""What an actuator is: what pushes a mass along, without the mass, its friction and what may turn it."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.equation import Scalar, equation
from plants.interface import Balance, unlimited
from plants.laws.interface import Nothing
from plants.laws.lugre import Bristle


class Motion(NamedTuple):
    """States of every machine, with the magnitudes that are typical of a cylinder's."""

    position: Annotated[float, "m", 1e-2]
    velocity: Annotated[float, "m/s", 1e-1]


@equation
def own_position(state: Any, p: Any) -> Scalar:
    """The position (m) of the mass itself."""
    return state.position


@equation
def own_stroke(p: Any) -> Scalar:
    """Distance (m) between the end stops, a parameter of the machine itself."""
    return p.stroke


@equation
def no_pressures(state: Any, p: Any) -> tuple[Scalar, Scalar]:
    """Of what has no fluid."""
    return np.nan, np.nan


@dataclass(frozen=True, eq=False, kw_only=True)
class Actuator:
    """An actuator: names and units (as NamedTuple classes) of what is its own, and the equations over them.

    force(state, inputs, parameters) -> force           on the mass, N
    rates(state, inputs, parameters) -> (rate, ...)      of its own states, in the order of `State`
    signals(state, inputs, parameters) -> (value, ...)   what is worth plotting of it, in the order of `Signals`
    pressures(state, parameters) -> (P1, P2)             what its sensors show, Pa; NaN where it has none
    position(state, parameters) -> position              and of the position, m
    stroke(parameters) -> stroke                         distance (m) between the end stops about position 0

    The equations see the whole machine: `state` has position and velocity too, `parameters` the `body`. Called once:

    equilibrium(parameters) -> (own states, own inputs)  at rest in mid-stroke, its load held
    command_limit(parameters) -> float                   the amplifier's limit, unit of the command

    The command is the first of its `Inputs`. `Motion` and `Contact` are position and velocity, and LuGre's bristle,
    with the magnitudes that are typical here; `rotation` is what sensors show of the rotation of a rod that does not
    turn, NaN where nobody has such. `frozen_volumes` says that chambers have their volumes at mid-stroke always.
    """

    name: str
    summary: str
    State: type[NamedTuple] = Nothing
    Inputs: type[NamedTuple]
    Parameters: type[NamedTuple]
    Signals: type[NamedTuple]
    force: Callable[[Any, Any, Any], Scalar]
    rates: Callable[[Any, Any, Any], tuple[Scalar, ...]]
    signals: Callable[[Any, Any, Any], tuple[Scalar, ...]]
    stroke: Callable[[Any], Scalar]
    equilibrium: Callable[[Any], tuple[tuple[float, ...], tuple[float, ...]]]
    pressures: Callable[[Any, Any], tuple[Scalar, Scalar]] = no_pressures
    position: Callable[[Any, Any], Scalar] = own_position
    command_limit: Callable[[Any], float] = unlimited
    balances: Mapping[str, Balance] = field(default_factory=dict)
    Motion: type[NamedTuple] = Motion
    Contact: type[NamedTuple] = Bristle
    rotation: float = 0.0
    frozen_volumes: bool = False

    @property
    def command(self) -> str:
        """The input that the position controller drives."""
        return self.Inputs._fields[0]

    def travel(self, p: Any) -> float:
        """Distance (m) between the end stops, if they are modelled."""
        return float(self.stroke(p)) if p.body.end_stop_stiffness else math.inf
