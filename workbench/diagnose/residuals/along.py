"""A plant along measured motions: its states, its inputs, and what is left of each of its balances."""

import functools
import typing
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plants.effects.attach import possible
from plants.equation import fields, from_array, replaced, to_array
from plants.interface import Plant
from workbench.diagnose.residuals.holding import bent_by, hold_all
from workbench.diagnose.residuals.motion import Motion, smoothed, window_points, with_backlash, with_pressure_offset
from workbench.diagnose.residuals.shown import BOTH_PRESSURES, dependences, given_by, rate_along, shown, state_along
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.residuals.walk import NUDGE, rates_along, walk
from workbench.parameters.sets import build
from workbench.simulation.compilation import plant_addresses

ARRIVES = "command_delay"
"""The parameter by which a command comes late: a record's is shifted as a whole, where a plant of its own has a lag."""

REMEMBERED = 8
"""Machines of which the plant at rest is remembered."""

LONG = 5_000
"""Instants of a motion from which a plant goes along it with those effects alone that act: to compile such plants costs
more than that saves on shorter ones."""

SLOWEST_CREEP = 1e-9
"""m/s. At the creep of a record without noise no contact could be seen to slip."""


TAKEN_OFF = BACKLASH, OFFSET = "backlash_width", "pressure_1_offset"
"""What sensors add, and is taken off a measured motion."""


def true_motion(motion: Motion, values: Values) -> Motion:
    """The motion without what its sensors add to it, as far as `values` know that."""
    return with_pressure_offset(with_backlash(motion, values.get(BACKLASH, 0.0)), values.get(OFFSET, 0.0))


@dataclass(frozen=True, eq=False)
class Tracked:
    """A plant along a motion: `values` (instants, columns) of the states in `columns`, the others as at `rest`; inputs,
    `idle` ones, the rates that were asked for, and where the contact is still.
    """

    parameters: Any
    rest: np.ndarray
    idle: np.ndarray
    columns: np.ndarray
    values: np.ndarray
    inputs: np.ndarray
    rates: np.ndarray
    still: np.ndarray

    def states(self, rows: slice | list[int]) -> np.ndarray:
        """Whole states (rows, states)."""
        values = self.values[rows]
        states = np.tile(self.rest, (values.shape[0], 1))
        states[:, self.columns] = values
        return states


@dataclass(frozen=True, eq=False)
class Along:
    """How a plant goes along records: with what it may lack as effects, and under a flow law."""

    plant: Plant
    flow: str

    @functools.cached_property
    def names(self) -> list[str]:
        """The plant's states."""
        return [item.name for item in fields(self.plant.State)]

    @functools.cached_property
    def contact(self) -> frozenset[str]:
        """The states that the contact remembers, and on which friction depends."""
        cls = typing.get_type_hints(self.plant.State).get(self.plant.contact)
        own = {item.name for item in fields(cls)} if cls is not None else set()
        return frozenset(own & dependences(self.plant).states["velocity"])

    def parameters(self, values: Values) -> Any:
        """The plant's parameters (SI)."""
        return self.parameters_of(self.plant, values)

    def acts(self, values: Values) -> frozenset[str]:
        """The plant's effects that do something."""
        parameters = self.parameters(values)
        if self.plant.bare is None:
            return frozenset()
        idle = type(parameters.effects)()
        return frozenset(name for name, own in parameters.effects._asdict().items() if own != getattr(idle, name))

    @functools.cached_property
    def shown_alone(self) -> frozenset[str]:
        """The numbers of effects on which depends what sensors show of a simulation, and nothing of the machine, nor
        where it starts.
        """
        own = [effect.own_names for effect in possible(self.plant) if effect.shows_alone]
        return frozenset(name for names in own for name in names) - {*TAKEN_OFF}

    def having(self, acting: Collection[str], alone: bool = False) -> Plant:
        """The plant, without effects where none of them is `acting`; or with those `alone` that are: that costs half as
        much, and a tenth of a second for each set of them.
        """
        bare = self.plant.bare
        if bare is None or (acting and not alone):
            return self.plant
        return _having(bare, frozenset(acting))

    def acting(self, values: Values, alone: bool = False) -> tuple[Plant, Any]:
        """The plant that has what acts, and its parameters."""
        plant = self.having(self.acts(values), alone)
        return plant, self.parameters_of(plant, values)

    def parameters_of(self, plant: Plant, values: Values) -> Any:
        """The parameters (SI) of the plant with all its effects or with some."""
        return _built(plant, tuple(values.items()), self.flow)

    @property
    def parameter_names(self) -> frozenset[str]:
        """The parameters by which a plant goes along a record."""
        return self._own_parameters | {ARRIVES}

    @functools.cached_property
    def _own_parameters(self) -> frozenset[str]:
        return frozenset(item.name for item in fields(self.plant.Parameters))

    def hidden(self, motion: Motion, start: Collection[str]) -> frozenset[str]:
        """The states that no channel shows and on which the rates of `start` depend."""
        return _hidden(self.plant, tuple(start), frozenset(motion.channels))

    def by_input(self, motion: Motion, hidden: Collection[str]) -> frozenset[str]:
        """Those of the hidden states that recorded inputs alone drive, whatever the motion is."""
        return _by_input(self.plant, frozenset(hidden), frozenset(motion.channels))

    def tracked(
        self,
        motion: Motion,
        values: Values,
        hidden: Collection[str],
        wanted: Sequence[str] = (),
        until: int | None = None,
    ) -> Tracked:
        """A plant along a motion, or the beginning of it: the `hidden` states that are asked for, and the rates of the
        `wanted` ones; all other states that no channel shows are as at rest.
        """
        seen, parameters = true_motion(motion, values), self.parameters(values)
        rest, idle = map(to_array, self._at_rest(motion, values, parameters))
        shown_here = [name for name in self.names if shown(motion.channels, name)]
        known = np.column_stack([state_along(name, seen, values)[:until] for name in shown_here])
        inputs, contact = self.inputs(motion, values, hidden)[:until], self.contact & set(hidden)
        still = self.still(motion, values)[:until] & bool(contact)
        simulated, groups, alone = _simulated(self.plant, frozenset(hidden))
        bends, rates = walk(
            plant_addresses(self.plant)[0],
            np.ascontiguousarray(motion.time[:until]),
            rest,
            self.columns(shown_here),
            np.ascontiguousarray(known),
            np.ascontiguousarray(inputs),
            to_array(parameters),
            simulated,
            groups,
            self.columns(self.by_input(motion, hidden)),
            self.columns(contact),
            alone,
            np.array([self.names.index(name) for name in wanted], dtype=np.int64),
            self.names.index("velocity"),
            np.ascontiguousarray(still),
            np.ascontiguousarray(motion.resting[:until]),
            max(motion.creep, SLOWEST_CREEP),
            np.ascontiguousarray(seen.acceleration[:until]),
            NUDGE * self.magnitudes(motion, values),
            motion.sample_time,
        )
        columns = np.concatenate([self.columns(shown_here), simulated])
        return Tracked(parameters, rest, idle, columns, np.hstack([known, bends]), inputs, rates, still)

    def magnitudes(self, motion: Motion, values: Values) -> np.ndarray:
        """What is typical of each state, shape (states,): of a contact how far the fastest motion bends it."""
        return _magnitudes(self, motion, tuple(values.items()))

    def columns(self, states: Collection[str]) -> np.ndarray:
        """Their places among the plant's states."""
        return _places(self.plant, states)

    def starting_states(self, motion: Motion, values: Values, places: Sequence[int]) -> list[Any]:
        """Whole states at some instants, from which a simulation can start: a contact carries what the balance of
        forces leaves to it, and does not move where nothing is known to.
        """
        seen, rows, walked = true_motion(motion, values), list(places), motion.walked
        unseen = [name for name in self.names if not shown(motion.channels, name)]
        steps = [place // motion.stride for place in places]
        tracked = self.tracked(walked, values, unseen, until=steps[-1] + 1)
        states, velocity = tracked.states(steps), self.names.index("velocity")
        for place, name in enumerate(self.names):
            if name not in unseen:
                states[:, place] = state_along(name, seen, values)[rows]
        states[tracked.still[steps], velocity] = 0.0
        hold_all(
            plant_addresses(self.plant)[0],
            motion.time[rows],
            states,
            self.inputs(motion, values, [])[rows],
            to_array(tracked.parameters),
            self.columns(self.contact),
            velocity,
            max(motion.creep, SLOWEST_CREEP),
            seen.acceleration[rows],
            NUDGE * self.magnitudes(motion, values),
        )
        return [from_array(self.plant.State, row.tolist()) for row in states]

    def still(self, motion: Motion, values: Values) -> np.ndarray:
        """Where the noise of the velocity hides any motion of the contact; a rod that turns is never still."""
        seen = true_motion(motion, values)
        still = np.abs(seen.velocity) <= motion.creep
        if "rotation_speed" in motion.channels and "piston_radius" in values:
            still &= np.abs(motion.channels["rotation_speed"] * values["piston_radius"]) <= motion.creep
        return np.asarray(still)

    def at_rest(self, motion: Motion, values: Values) -> tuple[Any, Any]:
        """State and inputs of the plant at rest, turning as the record begins; no command."""
        return self._at_rest(motion, values, self.parameters(values))

    def _at_rest(self, motion: Motion, values: Values, parameters: Any) -> tuple[Any, Any]:
        surface = 0.0
        if self.plant.rotary_command is not None and "rotation_speed" in motion.channels:
            surface = float(motion.channels["rotation_speed"][0]) * values["piston_radius"]
        state, inputs = _equilibrium(self.plant, parameters, surface)
        return state, replaced(inputs, {self.plant.command: 0.0})

    def inputs(self, motion: Motion, values: Values, hidden: Collection[str]) -> np.ndarray:
        """Inputs (instants, inputs), the command as it arrives, unless the plant delays it itself; 0 where no channel
        gives them. Smoothed as all else is, but as recorded where they drive one of the `hidden` states.
        """
        late = {self.plant.command: self.late(values)}
        if self.plant.delayed:
            parameters = self.parameters(values)
            late |= {name: float(delay(parameters)) for name, delay in self.plant.delayed.items()}
        columns, driving = [], {name for state in hidden for name in dependences(self.plant).inputs[state]}
        for item in fields(self.plant.Inputs):
            series = input_along(item.name, motion, values, raw=item.name in driving)
            if delay := late.get(item.name, 0.0):
                series = np.interp(motion.time - delay, motion.time, series)
            columns.append(series)
        return np.column_stack(columns)

    def late(self, values: Values) -> float:
        """By how much (s) a record's command comes late to a plant that does not delay it itself."""
        return 0.0 if ARRIVES in self._own_parameters else values.get(ARRIVES, 0.0)

    def residuals(self, motion: Motion, values: Values, balance: str) -> list[np.ndarray]:
        """What is left of a balance at the thinned instants: measured rates less those of the plant, in its unit.

        Every measured signal is smoothed alike; what inputs as recorded make of the rates is smoothed here, behind the
        kinks of a valve. The force is 0 where the contact rests: friction is then whatever holds it.
        """
        motion = motion.walked
        if motion.time.size > LONG and (plant := self.having(self.acts(values), alone=True)) is not self.plant:
            return _going(plant, self.flow).residuals(motion, values, balance)
        chosen, seen, every = self.plant.balances[balance], true_motion(motion, values), motion.thinning
        tracked = self.tracked(motion, values, self.hidden(motion, chosen.states), chosen.states)
        made, left = self._made_by_inputs(motion, tracked, chosen.states), []
        for place, (name, scale) in enumerate(zip(chosen.states, chosen.scale(tracked.parameters), strict=True)):
            rates = tracked.rates[:, place]
            if made is not None:
                rates = rates + smoothed(made[:, place], window_points(motion.sample_time)) - made[:, place]
            with np.errstate(over="ignore", invalid="ignore"):  # of a plant that runs away
                residual = scale * (rate_along(name, seen, values) - rates)
            left.append(np.where(motion.resting & tracked.still & (name == "velocity"), 0.0, residual)[::every])
        return left

    def rates(self, time: np.ndarray, states: np.ndarray, inputs: np.ndarray, parameters: Any) -> np.ndarray:
        """Rates (instants, states) of whole states (instants, states) under inputs (instants, inputs)."""
        derivatives = plant_addresses(self.plant)[0]
        return np.asarray(rates_along(derivatives, np.ascontiguousarray(time), states, inputs, to_array(parameters)))

    def _made_by_inputs(self, motion: Motion, tracked: Tracked, states: Sequence[str]) -> np.ndarray | None:
        """What inputs as recorded make of rates (instants, states), by what they drive; None where none does."""
        by_input = self.by_input(motion, self.hidden(motion, states))
        if not by_input:
            return None
        whole, columns = tracked.states(slice(None)), self.columns(by_input)
        whole[:, columns] = tracked.rest[columns]
        idle = self.rates(motion.time, whole, np.tile(tracked.idle, (whole.shape[0], 1)), tracked.parameters)
        return np.asarray(tracked.rates - idle[:, [self.names.index(name) for name in states]])


@functools.lru_cache(REMEMBERED)
def _built(plant: Plant, values: tuple[tuple[str, float], ...], flow: str) -> Any:
    """A plant's parameters: of one simulation they are asked for more than once."""
    return build(plant.Parameters, dict(values), flow)


@functools.cache
def _having(bare: Plant, acting: frozenset[str]) -> Plant:
    """See `Along.having`."""
    return bare.with_effects(*(effect for effect in possible(bare) if effect.name in acting))


@functools.cache
def _going(plant: Plant, flow: str) -> Along:
    """A plant along records."""
    return Along(plant, flow)


def _places(plant: Plant, states: Collection[str]) -> np.ndarray:
    """See `Along.columns`."""
    return np.array([place for place, item in enumerate(fields(plant.State)) if item.name in states], dtype=np.int64)


@functools.cache
def _simulated(plant: Plant, hidden: frozenset[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The places of these states, for each the number of a group in which no state counts in another's rate, and the
    places of those in whose rates no other one counts.
    """
    depends, groups, group_of = dependences(plant).states, list[list[str]](), list[int]()
    own = [item.name for item in fields(plant.State) if item.name in hidden]
    for name in own:
        free = (g for g in groups if not any(name in depends[other] or other in depends[name] for other in g))
        group = next(free, None)
        if group is None:
            groups.append(group := [])
        group.append(name)
        group_of.append(next(place for place, one in enumerate(groups) if one is group))
    alone = [name for name in own if depends[name] & hidden <= {name}]
    return _places(plant, own), np.array(group_of, dtype=np.int64), _places(plant, alone)


@functools.cache
def _hidden(plant: Plant, start: tuple[str, ...], channels: frozenset[str]) -> frozenset[str]:
    """See `Along.hidden`."""
    known = [item.name for item in fields(plant.State) if shown(channels, item.name)]
    return dependences(plant).reached(start, known)


@functools.cache
def _by_input(plant: Plant, hidden: frozenset[str], channels: frozenset[str]) -> frozenset[str]:
    """See `Along.by_input`."""
    depends = dependences(plant)
    fed = {item.name for item in fields(plant.Inputs) if given_by(channels, item.name)}
    driven = {name for name in hidden if any(depends.inputs[each] & fed for each in depends.reached([name], []))}
    return frozenset(name for name in driven if depends.reached([name], []) <= hidden)


@functools.lru_cache(REMEMBERED)
def _magnitudes(along: Along, motion: Motion, values: tuple[tuple[str, float], ...]) -> np.ndarray:
    """See `Along.magnitudes`: of one simulation they are asked for more than once."""
    plant, (rest, idle) = along.plant, map(to_array, along.at_rest(motion, dict(values)))
    return np.asarray(
        bent_by(
            plant_addresses(plant)[0],
            rest,
            idle,
            to_array(along.parameters(dict(values))),
            along.columns(along.contact),
            along.names.index("velocity"),
            motion.top_speed,
            np.array([item.scale for item in fields(plant.State)]),
        )
    )


@functools.lru_cache(REMEMBERED)
def _equilibrium(plant: Plant, parameters: Any, surface_speed: float) -> tuple[Any, Any]:
    """At rest: the same for every record, and for simulations that differ in where they start alone."""
    return plant.equilibrium(parameters, surface_speed)


def input_deviation(name: str, motion: Motion, values: Values) -> float:
    """Standard deviation (SI) that the sensors' noise leaves in an input, smoothed."""
    before = input_along(name, motion, values, raw=False)
    squares = 0.0
    for channel, noise in motion.noise.items():
        moved = replace(motion, channels={**motion.channels, channel: motion.channels[channel] + noise})
        squares += float(input_along(name, moved, values, raw=False)[0] - before[0]) ** 2
    return motion.smooth[0] * float(np.sqrt(squares))


def input_along(name: str, motion: Motion, values: Values, *, raw: bool) -> np.ndarray:
    """An input (SI), smoothed or as a record has it; 0 where no channel gives it.

    Beside a force one pressure alone drives too, on `piston_area_1` if that is declared: the force is the rod's then.
    Where no force is measured both pressures on their areas are it.
    """
    channels, series = given_by(motion.channels, name), motion.measured if raw else motion.channels
    if channels == BOTH_PRESSURES:
        area_2 = values["piston_area_2"] * values.get("area_ratio", 1.0)
        pressure_1 = series["pressure_1"] - values.get("pressure_1_offset", 0.0)
        return np.asarray(pressure_1 * values["piston_area_1"] - series["pressure_2"] * area_2)
    if not channels:
        return np.zeros(motion.time.size)
    (channel,) = channels
    if name == "surface_speed":
        return np.asarray(motion.channels[channel] * values["piston_radius"])
    if channel == "force" and motion.has("pressure_1") and not motion.has("pressure_2") and "piston_area_1" in values:
        return np.asarray(series[channel] + series["pressure_1"] * values["piston_area_1"])
    return series[channel]
