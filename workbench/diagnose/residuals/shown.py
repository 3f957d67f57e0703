"""What channels show of a plant's states and inputs, and which of its balances they allow."""

import functools
from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from plants.equation import fields, from_array, leaves
from plants.interface import Plant
from workbench.diagnose.residuals.motion import Motion, load_pressure
from workbench.diagnose.residuals.unknowns import Values
from workbench.recording.symbols import Recording, needed

SHOWN_BY: Mapping[str, tuple[str, ...]] = {
    "position": ("position",),
    "velocity": ("position",),
    "pressure_1": ("pressure_1",),
    "pressure_2": ("pressure_2",),
    "load_pressure": ("pressure_1", "pressure_2"),
    "surface_speed": ("rotation_speed",),
    "motor_current": ("motor_current",),
    "spool_position": ("spool_position",),
    "rotation_angle": ("rotation_angle",),
}
"""The channels that show a state of that name, in any plant."""

ORDER: Mapping[str, int] = {"flow": 0, "force": 1}
"""Of the balances that come first."""

FOLLOWS = ("spool_position", "rotation_angle")
"""States that may as well be simulated where no channel shows them. Any other that a rig could measure may not: a
pressure that is simulated beside a measured motion runs away from it."""

BOTH_PRESSURES = ("pressure_1", "pressure_2")

GIVEN_BY: Mapping[str, tuple[tuple[str, ...], ...]] = {
    "valve_voltage": (("command",),),
    "arriving_voltage": (("valve_voltage",), ("command",)),
    "arriving_voltage_negative": (("valve_voltage",), ("command",)),
    "pump_speed": (("command",),),
    "drive_voltage": (("command",),),
    "drive_force": (("force",), ("command",), BOTH_PRESSURES),
    "drive_torque": (("force",), ("command",)),
    "drive_current": (("command",), ("motor_current",)),
    "surface_speed": (("rotation_speed",),),
}
"""The channels that give an input of that name where none is called so: the first of these that are all there."""


def shown(channels: Collection[str], state: str) -> bool:
    """Whether the channels show a state."""
    return state in SHOWN_BY and all(name in channels for name in SHOWN_BY[state])


def given_by(channels: Collection[str], name: str) -> tuple[str, ...]:
    """The channels that give an input; none where it is not recorded."""
    ways = ((name,), *GIVEN_BY.get(name, ()))
    return next((way for way in ways if all(channel in channels for channel in way)), ())


class Dependences(NamedTuple):
    """On which states, inputs and parameters the rate of each state depends, by name."""

    states: Mapping[str, frozenset[str]]
    inputs: Mapping[str, frozenset[str]]
    parameters: Mapping[str, frozenset[str]]

    def reached(self, start: Collection[str], known: Collection[str]) -> frozenset[str]:
        """The states that are not `known` on which these rates depend, through each other's rates too."""
        hidden: set[str] = set()
        waiting = [name for state in start for name in self.states[state]]
        while waiting:
            name = waiting.pop()
            if name not in known and name not in hidden:
                hidden.add(name)
                waiting.extend(self.states[name])
        return frozenset(hidden)


@functools.cache
def dependences(plant: Plant) -> Dependences:
    """The structure of a plant's equations, whatever its parameters."""
    recording, classes = Recording(), (plant.State, plant.Inputs, plant.Parameters)
    names = [[item.name for item in fields(cls)] for cls in classes]
    symbols = [[recording.input(f"{argument}.{name}") for name in own] for argument, own in enumerate(names)]
    given = [from_array(cls, own) for cls, own in zip(classes, symbols, strict=True)]
    rates = plant.derivatives(recording.input("time"), *given)
    places = {
        state: set(needed(recording, [recording.number_place(rate)]))
        for state, rate in zip(names[0], leaves(rates), strict=True)
    }
    tables = [
        {
            state: frozenset(name for name, symbol in zip(own, those, strict=True) if symbol.place in on)
            for state, on in places.items()
        }
        for own, those in zip(names, symbols, strict=True)
    ]
    return Dependences(*tables)


def balances_shown(plant: Plant, channels: Collection[str]) -> Iterator[str]:
    """The balances of a plant whose residual these channels give, in the order in which they are looked at: what is
    wrong with the flow disturbs the motion, not the other way round, and friction is found along the rod before what
    it does around it.
    """
    structure = dependences(plant)
    commands = {plant.command, plant.rotary_command, *plant.delayed}
    known = [state for state in structure.states if shown(channels, state)]
    for name, balance in sorted(plant.balances.items(), key=lambda item: ORDER.get(item[0], len(ORDER))):
        if not all(shown(channels, state) for state in balance.states) or balance.states[0] in FOLLOWS:
            continue
        hidden = structure.reached(balance.states, known)
        inputs = {each for state in (*balance.states, *hidden) for each in structure.inputs[state]}
        simulated = all(state in FOLLOWS or state not in SHOWN_BY for state in hidden)
        if simulated and all(given_by(channels, each) for each in inputs & commands):
            yield name


def state_along(name: str, motion: Motion, values: Values) -> np.ndarray:
    """A state (SI) that channels show, at every instant of a motion."""
    channels = motion.channels
    if name in ("position", "velocity"):
        return np.asarray(getattr(motion, name))
    if name == "load_pressure":
        return load_pressure(motion)
    if name == "surface_speed":
        return np.asarray(channels["rotation_speed"] * values["piston_radius"])
    return channels[name]


def rate_along(name: str, motion: Motion, values: Values) -> np.ndarray:
    """The rate of a state (SI) that channels show."""
    rates = motion.rates
    if name == "velocity":
        return motion.acceleration
    if name == "load_pressure":
        return np.asarray(rates["pressure_1"] - rates["pressure_2"])
    if name == "surface_speed":
        return np.asarray(rates["rotation_speed"] * values["piston_radius"])
    return rates[name]


def deviation(name: str, motion: Motion, values: Values, *, rate: bool = False) -> float:
    """Standard deviation (SI) that the sensors' noise leaves in a state that channels show, or in its rate."""
    order = (name == "velocity") + rate
    noise = float(np.linalg.norm([motion.noise[channel] for channel in SHOWN_BY[name]]))
    return motion.smooth[order] * noise * (values["piston_radius"] if name == "surface_speed" else 1.0)
