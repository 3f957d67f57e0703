"""Effects on the bench: a switch for each that the plant can have, and the numbers of those that are on."""

from collections.abc import Mapping

from plants.effects.attach import possible
from plants.effects.interface import FREE, Effect, Number
from plants.effects.scales import Scales
from plants.equation import fields
from plants.interface import Plant
from workbench.bench.knobs import DECADE, Control, Knob, Switch
from workbench.bench.outcome import Outcome
from workbench.diagnose.residuals.scales import Moved, scales_from
from workbench.parameters.sets import NEUTRAL
from workbench.publish.words import plain_name as words_of
from workbench.toml.units import si


def effect_controls(outcome: Outcome) -> list[Control]:
    """A switch for each effect that the plant can have, and the numbers of those that are on."""
    loop = outcome.loop
    plant = loop.resolved.setup.plant
    scales = _scales(outcome)
    given = {
        name: value
        for name, value in {**loop.parsed.values.true, **loop.parsed.tables.plant.set}.items()
        if name in loop.parsed.tables.plant.set or value != NEUTRAL.get(name, value)
    }
    controls: list[Control] = []
    for effect in possible(plant.bare or plant):
        if not effect.sought or not set(effect.own_names) >= set(effect.numbers):
            continue  # what is not its own is among the machine's parameters
        keys = {name: f"plant.set.{name}" for name in effect.numbers}
        on = any(name in given for name in effect.numbers)
        first = _first(effect, scales)
        turned_on = {keys[name]: value for name, value in first.items()}
        controls.append(
            Switch(
                keys[next(iter(keys))], words_of(effect.name), on, turned_on, dict.fromkeys(keys.values()), effect.words
            )
        )
        if on:
            controls += [
                _effect_knob(keys[name], name, number, effect, given, scales, plant)
                for name, number in effect.numbers.items()
                if name in given
            ]
    return controls


FELT = 4.0
"""Sizes with which a search of an effect starts, that an effect has when it is turned on: one shows in a likelihood
only."""


def _first(effect: Effect, scales: Scales) -> dict[str, float]:
    """Numbers of an effect that are felt: of the smallest set that may act alone, and of those that shape it."""
    sizing = effect.apart[0] if effect.apart else tuple(effect.numbers)
    found = {}
    for name, number in effect.numbers.items():
        scale = number.scale(scales)
        if number.shapes:
            found[name] = number.grid[len(number.grid) // 2] * scale
        elif name in sizing:
            found[name] = (FELT * number.size * scale) or effect.neutral[name]
    return {name: _within(value, effect.numbers[name], scales) for name, value in found.items()}


def _within(value: float, number: Number, scales: Scales) -> float:
    scale = number.scale(scales)
    return min(max(value, number.low * scale), number.high * scale)


def _effect_knob(
    key: str,
    name: str,
    number: Number,
    effect: Effect,
    given: Mapping[str, object],
    scales: Scales,
    plant: Plant,
) -> Knob:
    unit = next(item.unit for item in fields(effect.Own) if item.name == name)
    value = si(given[name], unit)
    scale = number.scale(scales)
    if number.shapes:
        grid = [scale * one for one in number.grid]
        low, high = min([*grid, abs(value) or grid[0]]) / 3.0, max([*grid, abs(value)]) * 3.0
        return Knob(key, words_of(name), value, unit, max(low, 1e-300), high, True)
    reach = max(DECADE * abs(number.size) * scale, 2.0 * abs(value)) or 1.0
    low = -reach if number.low <= -FREE or number.low < 0.0 else number.low * scale
    high = reach if number.high >= FREE else min(reach, number.high * scale)
    return Knob(key, words_of(name), value, unit, low, high)


def _scales(outcome: Outcome) -> Scales:
    """What is large on the machine, as it moves here."""
    run, loop = outcome.run, outcome.loop
    signals = run.signals
    moved = Moved(
        speed=float(abs(signals["velocity"]).max()) or 1e-3,
        way=float(signals["position"].max() - signals["position"].min()) or 1e-3,
        acceleration=float(signals["acceleration"].std()),
        duration=float(run.time[-1]) or 1.0,
        sample_time=loop.resolved.setup.sample_time,
        pressure=float(
            max((abs(signals[name]).max() for name in ("pressure_1", "pressure_2") if name in signals), default=0.0)
        ),
        command=float(abs(run.command).max()),
    )
    return scales_from(moved, loop.parsed.values.true)
