"""The balances that an experiment's records allow, each with its floor and with what may be fitted on it."""

from collections.abc import Collection, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from plants.axis import name_along
from plants.effects.attach import lacks, possible
from plants.effects.interface import COMMAND, Effect
from plants.effects.registry import effects
from plants.equation import NEGATIVE, ROTARY, fields
from plants.interface import Plant
from plants.registry import CHAMBERS, THESIS, pressed
from workbench.diagnose.residuals import pump
from workbench.diagnose.residuals.along import ARRIVES, Along, input_deviation
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.scales import scales_of
from workbench.diagnose.residuals.shown import balances_shown, dependences, deviation, given_by, shown
from workbench.diagnose.residuals.unknowns import Values
from workbench.parameters.sets import EITHER_SIGN, FLOW_SHARE
from workbench.records.experiment import Experiment
from workbench.records.schema import FLOWING, FRICTION

FORCE, FLOW = "force", "flow"

OWN: Mapping[str, tuple[str, ...]] = {
    FORCE: FRICTION,
    FLOW: FLOWING,
    "rotation": tuple(f"{name}_{ROTARY}" for name in FRICTION),
}
"""What the baseline may move on each balance where an experiment does not say."""

OWN_OF_PUMP = ("pump_displacement",)
"""The same on the flow of a pump: the oil's compression counts little on plateaus of its speed."""

AREA = "piston_area_1"
AREAS = (AREA, "piston_area_2", "area_ratio")
"""On which measured pressures drive: no parameters of a mass that a force moves."""

LOAD_PRESSURE = "load_pressure"

KINDS: Mapping[str, tuple[str, ...]] = {FLOW: (FLOW, "valve"), "velocity": ("velocity", "valve")}
"""The balances whose effects show on one; else its own."""

SHOWS_ON_FLOW = "backlash"
"""An effect of a sensor that hides a part of the flow."""

PUMP_EFFECTS = ("unequal_areas", "internal_leakage")
"""What a pump without a valve may have that shows while its speed is steady."""


class Diagnosed(NamedTuple):
    """A balance by name, and the plant along which it is taken."""

    name: str
    along: Along


def richest(plant: Plant) -> Plant:
    """The plant that tells most of the same machine: for a valve's actuator the one with a pressure in each chamber."""
    bare = plant.bare or plant
    return CHAMBERS if bare is THESIS else bare


def diagnosed_plant(plant: Plant, flow: str, channels: Collection[str]) -> Along:
    """How a declared plant goes along records with these channels."""
    return Along(with_possible_effects(richest(plant), channels, plant.effects), flow)


def with_possible_effects(plant: Plant, channels: Collection[str], declared: Collection[str] = ()) -> Plant:
    """The plant with the effects that it is `declared` with, and all that it can have and that these channels can tell.

    A delay is no part of it, since a record's command is shifted as a whole.
    """
    wanted = {*declared, *effects_told(plant, channels)}
    had = (effect for effect in possible(plant) if effect.name in wanted and ARRIVES not in effect.numbers)
    return (plant.bare or plant).with_effects(*had)


def can_be_told(effect: Effect, plant: Plant, channels: Collection[str]) -> bool:
    """Whether an effect is looked for at all, and a record has the channels that it needs."""
    return effect.sought and all(
        bool(given_by(channels, plant.command)) if name == COMMAND else name in channels for name in effect.needs
    )


def allowed(plant: Plant, flow: str, channels: Collection[str]) -> list[Diagnosed]:
    """The balances that channels allow.

    That of forces is that of a mass under what drives it, where this is measured: a force, or both pressures of a plant
    that has but their difference, and does not turn.
    """
    whole = diagnosed_plant(plant, flow, channels)
    balances = [Diagnosed(name, whole) for name in balances_shown(whole.plant, channels)]
    names = [item.name for item in fields(whole.plant.State)]
    both = shown(channels, LOAD_PRESSURE) and LOAD_PRESSURE in names and whole.plant.rotary_command is None
    if FORCE not in channels and not both:
        return balances
    mass = Along(with_possible_effects(pressed(plant.axis), channels), flow)
    others = [item for item in balances if item.name != FORCE]
    return [*others, *(Diagnosed(name, mass) for name in balances_shown(mass.plant, channels))]


def effects_told(plant: Plant, channels: Collection[str]) -> tuple[str, ...]:
    """All effects that a plant can have and that these channels can tell, in their order."""
    return tuple(effect.name for effect in possible(plant) if can_be_told(effect, plant, channels))


def own_parameters(
    balances: Sequence[Diagnosed], free: Sequence[str] | None, values: Values, uncertain: Collection[str] = ()
) -> dict[str, list[str]]:
    """The plant's parameters that a fit of each balance may move: its own, in each direction that has a value of its
    own, unless an experiment says which are `free`; and beside these the `uncertain` ones, which are declared with a
    deviation.

    A free one is moved on the balance whose own it is, else on that of forces, else on the first that it counts in.
    """
    chosen: dict[str, list[str]] = {item.name: [] for item in balances}
    own = {item.name: _own(item) for item in balances}
    counting = {item.name: _counting(item) for item in balances}
    order = sorted(chosen, key=lambda name: name != FORCE)
    named = [each for item in balances for name in own[item.name] for each in (name, f"{name}_{NEGATIVE}")]
    wanted = [name for name in named if name in values] if free is None else free
    for name in dict.fromkeys([*wanted, *uncertain]):
        plain = name.removesuffix(f"_{NEGATIVE}")
        if not (values.get(name, 0.0) > 0.0 or name in EITHER_SIGN):
            continue
        places = [balance for balance in order if name in counting[balance]]
        place = next((balance for balance in places if plain in own[balance]), places[0] if places else None)
        if place is not None:
            chosen[place].append(name)
    return chosen


def _own(item: Diagnosed) -> tuple[str, ...]:
    is_pump = item.name == FLOW and item.along.plant.command == pump.SPEED
    return OWN_OF_PUMP if is_pump else OWN.get(item.name, item.along.plant.unknown)


def _counting(item: Diagnosed) -> set[str]:
    """The parameters on which a balance depends, by itself or by what it makes of states that nothing shows."""
    plant = item.along.plant
    depends, states = dependences(plant), plant.balances[item.name].states
    reached = {*states, *depends.reached(states, [])}
    names = {name for state in reached for name in depends.parameters[state]} - {FLOW_SHARE}
    return names | (set(AREAS) if (plant.bare or plant) is pressed(plant.axis) else set())


def priors_of(experiment: Experiment, channels: Collection[str]) -> dict[str, tuple[float, float]]:
    """What is declared, with its deviation, of parameters that count in a balance and that an experiment would hold."""
    values = {**experiment.known_values(), **experiment.values}
    balances = allowed(experiment.plant, experiment.flow, channels)
    free = {name for own in own_parameters(balances, experiment.free, values).values() for name in own}
    every = own_parameters(balances, experiment.free, values, experiment.deviations)
    held = [name for own in every.values() for name in own if name not in free]
    return {name: (values[name], experiment.deviations[name]) for name in held}


def balances_of(experiment: Experiment, motions: Sequence[Motion], values: Values) -> list[Balance]:
    """The balances that the channels of the records allow."""
    plant, channels = experiment.plant, motions[0].channels
    balances, priors = allowed(plant, experiment.flow, channels), priors_of(experiment, channels)
    own, scales = own_parameters(balances, experiment.free, values, priors), scales_of(motions, values)
    made = []
    for item in balances:
        floor = float(np.sqrt(np.mean([noise(item, motion, values) ** 2 for motion in motions])))
        chosen = item.along.plant.balances[item.name]
        made.append(
            Balance(
                item.name,
                motions,
                partial(residuals_of, item),
                max(floor, 1e-30),
                chosen.unit,
                tuple(own[item.name]),
                scales,
                _effects_on(item, motions[0].channels, values, own[item.name]),
                parts=len(chosen.states),
                contact=bool(item.along.hidden(motions[0], chosen.states) & item.along.contact),
                axis=plant.axis,
                priors=priors,
            )
        )
    return made


def residuals_of(item: Diagnosed, motion: Motion, values: Values) -> list[np.ndarray]:
    """A balance's residuals of a motion (`Along.residuals`); a pump's flow is known on plateaus of its speed alone."""
    residuals = item.along.residuals(motion, values, item.name)
    if item.name != FLOW or item.along.plant.command != pump.SPEED:
        return residuals
    steady = pump.on_plateau(motion)[:: motion.thinning]
    return [np.where(steady, residual, 0.0) for residual in residuals]


def _effects_on(item: Diagnosed, channels: Collection[str], values: Values, own: Collection[str]) -> tuple[str, ...]:
    """The effects that may show on a balance, without which the plant is declared."""
    plant, kinds = item.along.plant, KINDS.get(item.name, (item.name,))
    shown_here = [
        effect
        for effect in effects(plant.axis).values()
        if (effect.balance in kinds or (item.name == FLOW and effect.name == SHOWS_ON_FLOW))
        and not lacks(plant.bare or plant, effect)
        and can_be_told(effect, plant, channels)
    ]
    if _own(item) is OWN_OF_PUMP:
        shown_here = [effect for effect in shown_here if effect.name in PUMP_EFFECTS]
    return tuple(effect.name for effect in shown_here if _is_new(effect, values, own))


def _is_new(effect: Effect, values: Values, free: Collection[str]) -> bool:
    """Whether the plant is declared without the effect, with what it would change, and the baseline has it not."""
    names = effect.numbers
    return (
        not any(name in free for name in names)
        and all(
            values.get(name, 0.0) in (0.0, 1.0)
            or name.endswith(NEGATIVE)
            or name == name_along("load_force", effect.axis)
            for name in names
        )
        and not any(name.endswith(NEGATIVE) and name in values for name in names)
    )


def noise(item: Diagnosed, motion: Motion, values: Values) -> float:
    """Standard deviation that the sensors' noise alone leaves in a residual where the machine moves, to first order in
    it, in the balance's unit; of several states the mean square.
    """
    motion = motion.walked
    along, balance, every = item.along, item.along.plant.balances[item.name], motion.thinning
    depends = dependences(along.plant)
    tracked = along.tracked(motion, values, along.hidden(motion, balance.states))
    moving = (motion.valid & ~motion.resting)[::every]
    rows = np.flatnonzero(moving if np.any(moving) else motion.valid[::every]) * every
    states, inputs = tracked.states(rows.tolist()), tracked.inputs[rows]

    def rates(name: str, moved: np.ndarray, fed: np.ndarray) -> np.ndarray:
        return along.rates(motion.time[rows], moved, fed, tracked.parameters)[:, along.names.index(name)]

    squares = []
    for name, scale in zip(balance.states, balance.scale(tracked.parameters), strict=True):
        base, off = rates(name, states, inputs), [deviation(name, motion, values, rate=True)]
        for other in sorted(depends.states[name]):  # sums in one order, whatever the order of a set
            if shown(motion.channels, other):
                moved = states.copy()
                moved[:, along.names.index(other)] += deviation(other, motion, values)
                off.append(_change(rates(name, moved, inputs), base))
        for given in sorted(depends.inputs[name]):
            if given_by(motion.channels, given):
                fed = inputs.copy()
                fed[:, along.plant.input_index(given)] += input_deviation(given, motion, values)
                off.append(_change(rates(name, states, fed), base))
        squares.append(scale**2 * sum(each**2 for each in off))
    return float(np.sqrt(np.mean(squares)))


def _change(moved: np.ndarray, base: np.ndarray) -> float:
    return float(np.sqrt(np.mean((moved - base) ** 2)))
