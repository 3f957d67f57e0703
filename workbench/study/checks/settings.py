"""Whether each setting of a case means something to its plant, and its controller."""

import functools
from collections.abc import Collection, Sequence

from controllers.settings import idle
from plants.effects.attach import possible
from plants.effects.registry import effects
from plants.equation import fields
from plants.friction import LuGre
from plants.interface import Plant
from plants.laws.registry import LAWS
from plants.registry import PLANTS
from workbench.errors import nearest
from workbench.parameters.sets import FLOW_SHARE, plain_name
from workbench.study.resolve import Resolved
from workbench.study.study import Case, named
from workbench.toml.reading import Key


def _family(case: Case, plant: Plant) -> list[Plant]:
    """The plants that the model of a case stands for."""
    table = case.tables["plant"]
    by_rpm = table.get("model") == "by_rpm"
    if not by_rpm and not table.get("turned"):
        return [plant]
    straight = PLANTS.working()["non_rotating" if by_rpm else table["model"]]
    return [straight, straight.with_turning_rod(table.get("bristle", "helical"))]


def plant_settings(case: Case, item: Resolved) -> dict[Key, str]:
    """Of each setting of a case's plant and belief: why it means nothing to it, "" if it does."""
    family = _family(case, item.setup.plant)
    known = tuple(effects())
    names = {name for plant in family for name in _counting(_with_every_effect(plant, known))} - {FLOW_SHARE}
    found = {}
    for key, applies in _applies(case, family, names).items():
        found[key] = ""
        if not applies:
            hint = nearest(str(key[-1]), sorted(names)) if len(key) > 2 else "leave it out"
            found[key] = f'plant "{family[0].name}" has no use for it; {hint}'
    return found


@functools.cache
def _with_every_effect(plant: Plant, known: tuple[str, ...]) -> Plant:
    """The plant with all of the `known` effects that it can have; of many cases few have a plant of their own."""
    return plant.with_effects(*(effect for effect in possible(plant) if effect.name in known))


def _counting(plant: Plant) -> frozenset[str]:
    """The parameters of a plant, without those for which its friction law has no use."""
    law = LAWS.working().get(plant.friction)
    return _without(plant, frozenset() if law is None else frozenset(LuGre._fields) - {*law.uses})


@functools.cache
def _without(plant: Plant, unused: frozenset[str]) -> frozenset[str]:
    return frozenset(field.name for field in fields(plant.Parameters) if plain_name(field.name) not in unused)


def controller_settings(case: Case, item: Resolved) -> dict[Key, str]:
    """Of each setting that a case's controller is given: why it changes nothing, "" if it does."""
    name = named(case, "controller")
    reasons = idle(item.setup.loop.controller, item.settings)
    table = case.tables["controllers"][name]
    return {("controllers", name, key): reasons.get(key, "") for key in table if key != "type"}


def _applies(case: Case, family: Sequence[Plant], names: Collection[str]) -> dict[Key, bool]:
    """The settings of a case's plant and belief, and whether they mean something to it."""
    table = case.tables["plant"]
    rotates = any(plant.rotary_command is not None for plant in family)
    valve = any(field.name == FLOW_SHARE for plant in family for field in fields(plant.Parameters))
    features = {"bristle": rotates, "inertia": rotates, "rotation": rotates, "start": rotates, "flow": valve}
    features |= {"motor": rotates, "motor_limits": rotates, "turned": rotates}
    features["command"] = table["model"] == "drive"
    found: dict[Key, bool] = {("plant", name): applies for name, applies in features.items() if name in table}
    for section in (("plant", "set"), ("plant", "scale"), ("belief", "set")):
        for name in case.tables[section[0]].get(section[1], {}):
            found[(*section, name)] = name in names or (section[0] == "belief" and name in LuGre._fields)
    if (sample := case.overrides.sample) is not None:
        found |= {("plant", "scale", name): name in names for name in sample.factors}
    return found
