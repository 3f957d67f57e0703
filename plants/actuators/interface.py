"""What an actuator is: what pushes a mass along, without the mass, its friction and what may turn it."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from plants.equation import Scalar
from plants.interface import Balance, unlimited
from plants.laws.interface import Nothing
from plants.laws.lugre import Bristle


@dataclass(frozen=True, eq=False, kw_only=True)
class Actuator:
    """An actuator: names and units (as NamedTuple classes) of what is its own, and the equations over them.

    force(state, inputs, parameters) -> force           on the mass, N
    rates(state, inputs, parameters) -> (rate, ...)      of its own states, in the order of `State`
    signals(state, inputs, parameters) -> (value, ...)   what is worth plotting of it, in the order of `Signals`
    pressures(state, parameters) -> (P1, P2)             what its sensors show; NaN where it has none
    stroke(parameters) -> stroke                         distance (m) between the end stops about position 0

    The equations see the whole machine: `state` has position and velocity too, `parameters` the `body`. Called once:

    equilibrium(parameters) -> (own states, own inputs)  at rest in mid-stroke, its load held
    command_limit(parameters) -> float                   the amplifier's limit, unit of the command

    The command is the first of its `Inputs`. `Contact` is LuGre's bristle, with the deflection that is typical here.
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
    pressures: Callable[[Any, Any], tuple[Scalar, Scalar]]
    stroke: Callable[[Any], Scalar]
    equilibrium: Callable[[Any], tuple[tuple[float, ...], tuple[float, ...]]]
    command_limit: Callable[[Any], float] = unlimited
    balances: Mapping[str, Balance] = field(default_factory=dict)
    Contact: type[NamedTuple] = Bristle

    @property
    def command(self) -> str:
        """The input that the position controller drives."""
        return self.Inputs._fields[0]

    def travel(self, p: Any) -> float:
        """Distance (m) between the end stops, if they are modelled."""
        return float(self.stroke(p)) if p.body.end_stop_stiffness else math.inf
