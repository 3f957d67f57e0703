"""A plant with effects: its equations, with what effects change of what goes in and of what comes out."""

import functools
import zlib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from plants.axis import LINEAR
from plants.effects.interface import BRISTLE, COMMAND, DISTURBANCE, FROZEN_VOLUMES, Change, Effect, Moment
from plants.effects.moment import has_bristle, memory_of, moment_of, slip_of
from plants.effects.registry import effects as registered
from plants.equation import (
    Equation,
    Scalar,
    changed,
    equation,
    extended,
    fields,
    gathered,
    members,
    named_tuple,
    retyped,
    unmarked,
)
from plants.interface import Balance, Measurement, Plant
from plants.laws.interface import Nothing

Chain = Equation
"""An equation (value, moment, memory, parameters, own) -> value: all that effects change of it."""

PASSES = 3
"""Times that an equilibrium is found with what effects make of the one before: loads, then pressures, then friction."""

OWN = "effects"
"""The field of the parameters, and of the states, that holds those of the effects, each in a field of its name."""


def acts_by_itself(plant: Plant, effect: Effect) -> bool:
    """Whether a plant has all of an effect's parameters without being given it."""
    return set(effect.numbers) <= {item.name for item in fields(plant.Parameters)}


def lacks(plant: Plant, effect: Effect) -> str:
    """What a plant has not, in words, that an effect changes; "" if it can have it."""
    if acts_by_itself(plant, effect):
        return ""
    if not effect.own_names:
        missing = sorted(set(effect.numbers) - {item.name for item in fields(plant.Parameters)})
        return f"parameter {', '.join(missing)}"
    known = {*members(plant.Parameters), *members(plant.State), *members(plant.Inputs), *plant.channels}
    known |= {FROZEN_VOLUMES} if plant.frozen_volumes else set()
    known |= {BRISTLE} if has_bristle(plant) else set()
    if effect.parameters and not set(effect.parameters) & known:
        return " or ".join(effect.parameters)
    for name in effect.requires:
        if name not in known:
            return name.replace("_", " ") if name in (FROZEN_VOLUMES, BRISTLE) else name
    for name in effect.inputs:
        if name not in (COMMAND, *members(plant.Inputs)):
            return f"input {name}"
    if effect.rates and not set(effect.rates) & set(members(plant.State)):
        return f"state {' or '.join(effect.rates)}"
    return ""


def possible(plant: Plant) -> tuple[Effect, ...]:
    """The effects that a plant can have."""
    return _possible(plant.bare or plant, tuple(registered(plant.axis).values()))


@functools.cache
def _possible(bare: Plant, effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
    return tuple(effect for effect in effects if not lacks(bare, effect))


def meant(plant: Plant, names: Collection[str]) -> tuple[Effect, ...]:
    """The effects that a plant can have and has not, and of which a parameter is among these canonical names."""
    return _meant(plant, possible(plant), frozenset(names))


@functools.cache
def _meant(plant: Plant, able: tuple[Effect, ...], names: frozenset[str]) -> tuple[Effect, ...]:
    given = names - {item.name for item in fields(plant.Parameters)}
    return tuple(effect for effect in able if not given.isdisjoint(effect.own_names))


def with_effects(plant: Plant, effects: Sequence[Effect]) -> Plant:
    """See `Plant.with_effects`."""
    if not effects:
        return plant
    bare = plant.bare or plant
    effects = [effect.along(bare.axis) for effect in effects]
    for effect in effects:
        if mistake := unmarked(effect.equations):
            raise ValueError(f'effect "{effect.name}": {mistake}')
        if missing := lacks(bare, effect):
            raise ValueError(f'plant "{bare.name}" cannot have the effect "{effect.name}": it has no {missing}')
    known = {**registered(bare.axis), **{effect.name: effect for effect in effects}}
    wanted = {*plant.effects, *(effect.name for effect in effects if not acts_by_itself(bare, effect))}
    return _attached(bare, tuple(effect for effect in known.values() if effect.name in wanted))


@functools.cache
def _attached(plant: Plant, effects: tuple[Effect, ...]) -> Plant:
    if not effects:
        return plant
    names = " ".join(effect.name for effect in effects)
    suffix = f"{OWN}_{zlib.crc32(names.encode()):08x}" + (f"_{plant.axis}" if plant.axis != LINEAR else "")
    remembering = tuple(effect for effect in effects if effect.remember is not None)
    own_class = _together(f"Own_{suffix}", {effect.name: effect.Own for effect in effects})
    memory_class = _together(f"Memory_{suffix}", {effect.name: effect.Memory for effect in remembering})
    parameters_class = retyped(plant.Parameters, suffix, **{OWN: own_class})
    state_class = retyped(plant.State, suffix, **{OWN: memory_class}) if remembering else plant.State

    at, slip, command = moment_of(plant), slip_of(plant), plant.input_index(plant.command)
    chained = functools.partial(_chained, plant, effects)
    altered, driven = chained(plant.Parameters, "parameters"), chained(plant.Inputs, "inputs")
    by_rates, by_readings = chained(plant.State, "rates"), chained(Measurement, "readings")
    remembered, kept_in = _remembered(plant, effects), memory_of(bool(remembering))
    bare_rates, bare_signals, bare_measure = plant.derivatives, plant.signals, plant.measure
    parted = _parted(plant, bool(remembering))

    @equation
    def rates_of(time: Scalar, state: Any, inputs: Any, p: Any) -> Any:
        """Rates of the plant's own states."""
        memory, own, state, p = parted(state, p)
        moment = at(time, state, inputs, p)
        into = driven(inputs, moment, memory, p, own)
        return by_rates(bare_rates(time, state, into, altered(p, moment, memory, p, own)), moment, memory, p, own)

    @equation
    def rates_with_memory(time: Scalar, state: Any, inputs: Any, p: Any) -> Any:
        """Rates of the states: the plant's own, and of what the effects remember."""
        memory, own, state, p = parted(state, p)
        moment = at(time, state, inputs, p)
        into = driven(inputs, moment, memory, p, own)
        rates = by_rates(bare_rates(time, state, into, altered(p, moment, memory, p, own)), moment, memory, p, own)
        return extended(
            state_class, rates, remembered(memory, slip(moment, rates), inputs[command], moment, memory, p, own)
        )

    @equation
    def signals(time: Scalar, state: Any, inputs: Any, p: Any) -> Any:
        """The plant's signals, as the effects make them."""
        memory, own, state, p = parted(state, p)
        moment = at(time, state, inputs, p)
        into = driven(inputs, moment, memory, p, own)
        return bare_signals(time, state, into, altered(p, moment, memory, p, own))

    @equation
    def measure(state: Any, p: Any) -> Measurement:
        """What the plant's sensors show, and the effects make of it."""
        memory, own, state, p = parted(state, p)
        moment = Moment(0.0, state.position, state.velocity, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        return by_readings(bare_measure(state, p), moment, memory, p, own)

    def rested(state: NamedTuple, inputs: NamedTuple) -> NamedTuple:
        """The state with what the effects remember of a machine that has rested for long."""
        if not remembering:
            return state
        kept = [item.at_rest(inputs[command]) if item.at_rest else item.Memory() for item in remembering]
        return state_class(*state, memory_class(*kept))

    def resting(p: Any, state: Any, inputs: Any) -> Any:
        """The parameters as effects make them of a machine at rest; what disturbs it there is a load."""
        moment, memory, own = at(0.0, state, inputs, p), kept_in(state), p.effects
        at_rest = altered(p, moment, memory, p, own)
        if "body" not in members(plant.Parameters) or DISTURBANCE not in members(plant.Inputs):
            return at_rest
        load = at_rest.body.load_force + driven(inputs, moment, memory, p, own).disturbance_force
        return at_rest._replace(body=at_rest.body._replace(load_force=load))

    def equilibrium(p: Any, surface_speed: float) -> tuple[Any, Any]:
        """At rest for long, with parameters as the effects make them there: of the pressures that hold a load, too."""
        acting = tuple(effect for effect, own, idle in zip(effects, p.effects, own_class(), strict=True) if own != idle)
        if len(acting) < len(effects):  # to go through dozens that do nothing takes most of the time
            alone = _attached(plant, acting)
            state, inputs = alone.equilibrium(_of_alone(alone, p), surface_speed)
            return rested(gathered(plant.State, state[: len(plant.State._fields)]), inputs), inputs
        state, inputs = plant.equilibrium(p, surface_speed)
        before = p
        for _ in range(PASSES):
            there = resting(p, rested(state, inputs), inputs)
            if there == before:
                break
            state, inputs = plant.equilibrium(there, surface_speed)
            before = there
        return rested(state, inputs), inputs

    def scaled(balance: Balance) -> Balance:
        """The balance of rates that effects multiply, air those of pressures: its scale is over that factor, at rest.

        Were it left out, a residual could be made small by more and more air; were it followed along a record, all
        weight would lie where a pressure is low.
        """
        places = [plant.State._fields.index(name) for name in balance.states]

        def scale(p: Any) -> tuple[float, ...]:
            state, inputs = equilibrium(p, 0.0)
            moment, memory = at(0.0, state, inputs, p), kept_in(state)
            still, going = (plant.State._make([rate] * len(plant.State._fields)) for rate in (0.0, 1.0))
            none, one = (by_rates(rates, moment, memory, p, p.effects) for rates in (still, going))
            return tuple(
                float(own / (one[place] - none[place])) for own, place in zip(balance.scale(p), places, strict=True)
            )

        changed_here = {name for effect in effects for name in effect.rates}
        return balance._replace(scale=scale) if changed_here & set(balance.states) else balance

    refit, turned = plant.refit, plant.turned
    return replace(
        plant,
        State=state_class,
        Parameters=parameters_class,
        derivatives=rates_with_memory if remembering else rates_of,
        signals=signals,
        measure=measure,
        equilibrium=equilibrium,
        refit=None if refit is None else lambda law: with_effects(refit(law), effects),
        turned=None if turned is None else lambda bristle, imposed: with_effects(turned(bristle, imposed), effects),
        effects=tuple(effect.name for effect in effects),
        bare=plant,
        balances={name: scaled(balance) for name, balance in plant.balances.items()},
    )


def _of_alone(alone: Plant, p: Any) -> Any:
    """Parameters of a plant with effects as those of the same plant with some of them."""
    if not alone.effects:
        return gathered(alone.Parameters, p[:-1])
    own = {name: getattr(p.effects, name) for name in alone.effects}
    return extended(alone.Parameters, p[:-1], alone.Parameters._field_defaults[OWN]._replace(**own))


def _together(name: str, members: Mapping[str, type]) -> type:
    """A class with a field for each effect, which has that effect's class, neutral by default."""
    return named_tuple(name, __name__, members, {effect: cls() for effect, cls in members.items()}, "Of each effect.")


def _chained(plant: Plant, effects: Sequence[Effect], cls: type[NamedTuple], changes: str) -> Chain:
    """All that effects change of a tuple of a class: an equation (value, moment, memory, parameters, own) -> value."""
    chain: Chain = _unchanged
    for index, effect in enumerate(effects):
        for name, change in getattr(effect, changes).items():
            member = members(plant.Inputs)[plant.input_index(plant.command)] if name == COMMAND else name
            if member in cls._fields:
                chain = _changing(chain, cls._fields.index(member), change, index, _memory_index(effects, effect))
    return chain


def _changing(before: Chain, place: int, change: Change, index: int, remembered: int | None) -> Chain:
    """The chain with one effect's change of the member at a place behind it; to it go what it remembers and its own
    parameters alone, and one function does it: compiled code takes all tuples apart at every call.
    """

    @equation
    def chain(value: Any, moment: Moment, memory: Any, p: Any, own: Any) -> Any:
        value = before(value, moment, memory, p, own)
        return changed(value, place, change(value[place], moment, Nothing(), p, own[index]))

    @equation
    def chain_by_memory(value: Any, moment: Moment, memory: Any, p: Any, own: Any) -> Any:
        value = before(value, moment, memory, p, own)
        return changed(value, place, change(value[place], moment, memory[remembered], p, own[index]))

    return chain if remembered is None else chain_by_memory


def _memory_index(effects: Sequence[Effect], effect: Effect) -> int | None:
    remembering = [item for item in effects if item.remember is not None]
    return remembering.index(effect) if effect in remembering else None


def _parted(plant: Plant, remembers: bool) -> Equation:
    """What the effects remember, their parameters, and the plant's own states and parameters, out of those of both."""
    state_class, parameters_class, kept_in = plant.State, plant.Parameters, memory_of(remembers)

    @equation
    def of_plain_states(state: Any, p: Any) -> Any:
        return kept_in(state), p.effects, state, gathered(parameters_class, p[:-1])

    @equation
    def of_both(state: Any, p: Any) -> Any:
        return kept_in(state), p.effects, gathered(state_class, state[:-1]), gathered(parameters_class, p[:-1])

    return of_both if remembers else of_plain_states


@equation
def _unchanged(value: Any, moment: Moment, memory: Any, p: Any, own: Any) -> Any:
    return value


def _remembered(plant: Plant, effects: Sequence[Effect]) -> Equation:
    """Rates of what the effects remember, given that: (rates, slip, command, moment, memory, p, own) -> rates."""
    arriving: Chain = _unchanged

    @equation
    def chain(rates: Any, slip: Scalar, command: Scalar, moment: Moment, memory: Any, p: Any, own: Any) -> Any:
        return rates

    for index, effect in enumerate(effects):
        place = _memory_index(effects, effect)
        if place is not None and effect.remember is not None:
            chain = _next_memory(chain, place, effect.remember, index, arriving)
        if (change := effect.inputs.get(COMMAND, effect.inputs.get(plant.command))) is not None:
            arriving = _arriving(arriving, change, index, place)
    return chain


def _arriving(before: Chain, change: Change, index: int, remembered: int | None) -> Chain:
    """The command with one effect's change behind those before it."""

    @equation
    def chain(command: Scalar, moment: Moment, memory: Any, p: Any, own: Any) -> Any:
        return change(before(command, moment, memory, p, own), moment, Nothing(), p, own[index])

    @equation
    def chain_by_memory(command: Scalar, moment: Moment, memory: Any, p: Any, own: Any) -> Any:
        return change(before(command, moment, memory, p, own), moment, memory[remembered], p, own[index])

    return chain if remembered is None else chain_by_memory


def _next_memory(before: Equation, place: int, remember: Equation, index: int, arriving: Chain) -> Equation:
    """The chain with the rates of another effect's memory, which is given the command as it arrives there."""

    @equation
    def chain(rates: Any, slip: Scalar, command: Scalar, moment: Moment, memory: Any, p: Any, own: Any) -> Any:
        rates = before(rates, slip, command, moment, memory, p, own)
        arrived = arriving(command, moment, memory, p, own)
        return changed(rates, place, remember(slip, arrived, moment, memory[place], p, own[index]))

    return chain
