"""The machine on the bench: what it is, how its rod turns, its parameters, true and believed."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, get_args

from plants.equation import NEGATIVE, fields, named
from plants.laws.registry import LAWS
from plants.registry import PLANTS
from workbench.bench.knobs import Choice, Control, Knob, ranged
from workbench.bench.loop import BenchLoop
from workbench.errors import UserError
from workbench.parameters.sets import (
    FLOW_SHARE,
    NEUTRAL,
    WORDS,
    lacks,
    named_sets,
    parameter_path,
    plain_name,
    read_parameters,
)
from workbench.publish.words import plain_name as words_of
from workbench.records.schema import FRICTION
from workbench.study.layers import LAYERS
from workbench.study.models import MODELS
from workbench.study.schema import PlantTable
from workbench.toml import reading as files
from workbench.toml.units import QuantityError, factor, unit_written

MOST_RPM = 600.0
"""rpm. The thesis's rig turns up to 460."""


def machine_controls(loop: BenchLoop) -> list[Control]:
    """What the plant is, how its rod turns, and its parameters without those of friction and of effects."""
    tables, plant = loop.parsed.tables, loop.resolved.setup.plant
    controls: list[Control] = []
    for axis, layer in LAYERS.items():
        known = [*loop.content.get(layer.section, {}), *layer.files(loop.folder)]
        if axis in loop.content.get("axes", {}) or axis in loop.changes:
            now = str(loop.case.axes[axis])
            controls.append(Choice(axis, axis, now, [(name, words_of(name)) for name in dict.fromkeys(known)]))
    controls += [
        Choice("plant.model", "model", tables.plant.model, [(name, words_of(name)) for name in _models(loop)]),
        Choice("plant.parameters", "parameters", tables.plant.parameters, _sets(loop, tables.plant.parameters)),
    ]
    if _turns(loop):
        rpm = loop.case.rpm
        controls.append(
            Knob("rpm", "speed of rotation", rpm, "rpm", 0.0, max(MOST_RPM, rpm), tip="what is asked of the motor")
        )
    if plant.rotary_command:
        rotations = _choices_of("rotation")
        controls.append(Choice("plant.rotation", "rotation is held by", tables.plant.rotation, rotations))
        bristles = _choices_of("bristle")
        controls.append(Choice("plant.bristle", "bristles", tables.plant.bristle, bristles))
    controls += [knob for knob in _parameters(loop, "plant") if not _is_friction(knob.key)]
    return controls


def _choices_of(name: str) -> list[tuple[str, str]]:
    """What a key of [plant] may be, of those that may be one of several words."""
    annotation = PlantTable.model_fields[name].annotation
    return [(one, words_of(one)) for one in get_args(annotation)]


def _turns(loop: BenchLoop) -> bool:
    """Whether the machine has a rod that can turn."""
    table = loop.parsed.tables.plant
    return bool(loop.resolved.setup.plant.rotary_command) or table.model == "by_rpm" or table.turned is not None


def _models(loop: BenchLoop) -> list[str]:
    """Models that the parameters serve, on the same axis, the present one first."""
    values, axis = loop.parsed.values.true, loop.parsed.axis
    now = loop.parsed.tables.plant.model
    served = [name for name, plant in PLANTS.working().items() if plant.axis == axis and not lacks(plant, values)]
    general = ["by_rpm"] if "non_rotating" in served and any(name.startswith("rotating") for name in served) else []
    plain = [name for name in served if name in MODELS or not name.startswith("rotating")]
    return list(dict.fromkeys([now, *general, *plain]))


def _sets(loop: BenchLoop, now: str) -> list[tuple[str, str]]:
    """Sets that serve the plant, the present one first."""
    plant = loop.resolved.setup.plant
    served = []
    for name, path in named_sets().items():
        try:
            values = read_parameters(path, plant.axis)
        except UserError:  # of the other axis
            continue
        if not lacks(plant.bare or plant, values):
            served.append(name)
    return [(name, words_of(name)) for name in dict.fromkeys([now, *served])]


def friction_controls(loop: BenchLoop) -> list[Control]:
    """The friction law of the true plant and its parameters."""
    table = loop.parsed.tables.plant
    turning = loop.resolved.setup.plant.rotary_command is not None
    laws = [
        (name, words_of(name))
        for name, law in LAWS.working().items()
        if not turning or table.bristle in law.plane or name == table.friction
    ]
    controls: list[Control] = []
    if loop.resolved.setup.plant.friction:
        controls.append(Choice("plant.friction", "friction law", table.friction, laws))
    return [*controls, *(knob for knob in _parameters(loop, "plant") if _is_friction(knob.key))]


def belief_controls(loop: BenchLoop) -> list[Control]:
    """What controllers believe friction, masses and valve to be."""
    laws = [(name, words_of(name)) for name in LAWS.working()]
    law = Choice("belief.friction", "friction law", loop.parsed.tables.belief.friction, laws)
    return [law, *_parameters(loop, "belief")]


def _is_friction(key: str) -> bool:
    return plain_name(key.rpartition(".")[2]).startswith(FRICTION)


def _parameters(loop: BenchLoop, table: str) -> Iterator[Knob]:
    """The parameters of the plant, true or believed, with their units and sources; those of effects are not among them.

    Where both directions have the same value they are one knob.
    """
    parsed, plant = loop.parsed, loop.resolved.setup.plant
    bare = plant.bare or plant
    values = parsed.values.true if table == "plant" else parsed.values.believed
    entries = _entries(loop, table)
    source = loop.resolved.setup.parameters if table == "plant" else loop.resolved.belief
    numbers: Any = named(source)
    for item in fields(bare.Parameters):
        name = item.name
        if name == FLOW_SHARE or name in WORDS or name in NEUTRAL:
            continue
        value = values.get(name, values.get(plain_name(name), numbers.get(name, item.default)))
        if value is None or not math.isfinite(value):
            continue
        forward, other = name.removesuffix(f"_{NEGATIVE}"), f"{name}_{NEGATIVE}"
        if forward != name and values.get(name, value) == values.get(forward, value):
            continue
        if name == SECOND_AREA and value == values.get(FIRST_AREA):
            continue
        linked = (f"{table}.set.{SECOND_AREA}",) if name == FIRST_AREA and values.get(SECOND_AREA) == value else ()
        also = {f"{table}.set.{other}": values[other]} if values.get(other, value) != value else {}
        entry = entries.get(name) or entries.get(plain_name(name)) or {}
        shown, tip = unit_written(entry.get("value", "")) or "", str(entry.get("source", ""))
        words = words_of(forward) + (" (backward)" if forward != name else "")
        scale = parsed.tables.plant.scale if table == "plant" else {}
        times = scale.get(name, scale.get(forward, 1.0)) or 1.0
        key = f"{table}.set.{name}"
        knob = Knob(key, words, value * times, item.unit, tip=tip, also=also, linked=linked, times=times)
        yield ranged(replace(knob, shown=shown if _converts(shown, item.unit) else ""))


FIRST_AREA, SECOND_AREA = "piston_area_1", "piston_area_2"
"""One knob where they are the same: some plants have but one."""


def _converts(shown: str, unit: str) -> bool:
    try:
        factor(shown, unit)
    except QuantityError:
        return False
    return bool(shown) and unit != "1"


def _entries(loop: BenchLoop, table: str) -> Mapping[str, Mapping[str, object]]:
    """What the parameter file of the plant, or of the belief, says of each parameter."""
    name = loop.parsed.values.source if table == "belief" else loop.parsed.tables.plant.parameters
    data = files.read_toml(parameter_path(name, loop.case.folder))[0]
    found = data.get("parameters", {})
    return found if isinstance(found, Mapping) else {}
