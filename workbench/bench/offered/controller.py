"""The controller on the bench: its type, and those of its settings that count."""

import math
from collections.abc import Iterator
from typing import Any

from controllers.open_loop import OPEN_LOOP
from controllers.registry import CONTROLLERS
from controllers.settings import Setting, idle, settings_of
from plants.interface import Plant
from workbench.bench.knobs import Choice, Control, Knob, ranged
from workbench.bench.loop import BenchLoop
from workbench.publish.words import plain_name as words_of
from workbench.toml.units import COMMAND


def controller_controls(loop: BenchLoop) -> list[Control]:
    """The type of the controller, and those of its settings that count."""
    own = [*loop.content.get("controllers", {})]
    options = [(name, words_of(name)) for name in own]
    options += [
        (name, words_of(name))
        for name, one in CONTROLLERS.working().items()
        if name not in own and one is not OPEN_LOOP  # whose reference is of another unit
    ]
    controls: list[Control] = [Choice("controller", "controller", loop.controller_name, options)]
    settings, plant = loop.resolved.settings, loop.resolved.setup.plant
    declared: Any = type(settings)
    useless = idle(loop.resolved.setup.loop.controller, settings)
    for name, item in settings_of(declared).items():
        key, value = f"controllers.{loop.controller_name}.{name}", getattr(settings, name)
        if name in useless:
            continue
        if item.unit:
            knob = _setting_knob(key, item, value, settings, plant)
            if value or loop.changed(knob.change(knob.at(0.5))).serves:  # else it needs what the plant has not
                controls.append(knob)
        elif len(item.choices) > 1:
            choices = [(one, words_of(one)) for one in item.choices]
            controls.append(Choice(key, words_of(name), str(value), choices, item.about.meaning))
    return controls


def starting_tables(loop: BenchLoop, kind: str) -> Iterator[dict[str, object]]:
    """Tables for a controller of another type, the first that serves to be taken: with all that it has in common with
    the present one, without its feed-forward, which needs a valve, and with what it needs alone; each by every law by
    which it may reach the actuator.
    """
    controller = CONTROLLERS.working().get(kind)
    if controller is None:
        yield {}  # one of the study's own
        return
    now, declared = loop.resolved.settings, settings_of(controller.Settings)
    present: Any = type(now)
    alike = {
        name: value
        for name, item in settings_of(present).items()
        if isinstance(value := getattr(now, name), float) and item.tuned is not None
        if name in declared and declared[name].unit == item.unit
    }
    needed = {name: _typical(loop, item) for name, item in declared.items() if item.default is None and item.unit}
    laws = [{LAW: law} for law in declared[LAW].choices] if LAW in declared else [{}]
    unfed = {FED: 0.0} if FED in declared else {}
    for values in ({**needed, **alike}, {**needed, **alike, **unfed}, {**needed, **unfed}):
        for law in laws:
            yield {"type": kind, **values, **law}


LAW, FED = "law", "feedforward"


def _typical(loop: BenchLoop, item: Setting) -> float:
    """A value for a setting that has no default: a tenth of the command's limit, or the gain of the thesis."""
    limit = float(loop.resolved.setup.plant.command_limit(loop.resolved.belief))
    return 0.1 * limit if item.unit == COMMAND and math.isfinite(limit) else TYPICAL


TYPICAL = 500.0
"""Of a proportional gain that nothing tells: that of the thesis's simulations, in V/m."""


def _setting_knob(key: str, item: Setting, value: float, settings: object, plant: Plant) -> Knob:
    unit = plant.unit_for(item.unit)
    tip = item.about.meaning
    tuned = item.tuned
    if tuned is not None and tuned.by_factor:
        size = value or _proportional(item, settings)
        return Knob(key, words_of(item.name), value, unit, size / 30.0, size * 30.0, True, item.default == 0.0, tip=tip)
    if tuned is not None:
        low, high = min(tuned.low, value), max(tuned.high, value)
        logarithmic = tuned.logarithmic and low > 0.0
        if tuned.logarithmic and low <= 0.0:
            return Knob(key, words_of(item.name), value, unit, tuned.low, high, True, True, tip=tip)
        return Knob(key, words_of(item.name), value, unit, low, high, logarithmic, tip=tip)
    return ranged(Knob(key, words_of(item.name), value, unit, tip=tip))


TIME_SCALES = {"command/(m s)": 1.0, "command s/m": 0.01, "command s^2/m": 1e-4}
"""What stands between a proportional gain and one on the error's integral, its derivative and its second one, where
that is off: an integral time of a second, a derivative time of 10 ms."""


def _proportional(item: Setting, settings: object) -> float:
    return float(getattr(settings, "kp", 1.0) or 1.0) * TIME_SCALES.get(item.unit, 1.0)
