"""What there is to put into a study, in words."""

from collections.abc import Callable, Mapping
from pathlib import Path

from controllers.interface import Controller
from controllers.registry import CONTROLLERS
from controllers.settings import ANY, Setting, usable
from plants.axis import ROTARY, name_along
from plants.effects.attach import lacks
from plants.effects.curves import nodes_of
from plants.effects.interface import FREE, Effect, Number, plain
from plants.equation import fields
from plants.laws.interface import FrictionLaw
from plants.plugins import Registry
from plants.registry import PLANTS
from workbench.metrics.interface import Column


def _plants() -> list[str]:
    from workbench.study.models import MODELS

    return [
        f"{'model':22} {', '.join(MODELS)}",
        *(f"{name:22} {plant.summary}" for name, plant in PLANTS.working().items()),
        *_broken(PLANTS),
    ]


def _friction_laws() -> list[str]:
    from plants.laws.registry import LAWS

    return [*(f"{name:22} {_law(law)}" for name, law in LAWS.working().items()), *_broken(LAWS)]


def _law(law: FrictionLaw) -> str:
    """A friction law, the bristles with which it has a form for a rod that turns, and parameters of its own."""
    own = ", ".join(f"{item.name} ({item.unit}, default {item.default:g})" for item in fields(law.Extra))
    parts = [law.summary, f"turning rods: {', '.join(law.plane) or 'none'}", f"own parameters: {own}" if own else ""]
    return "; ".join(part for part in parts if part)


def _controllers() -> list[str]:
    working = CONTROLLERS.working()
    return [
        *(line for name, controller in working.items() for line in _controller(name, controller)),
        *_broken(CONTROLLERS),
    ]


def _parameters() -> list[str]:
    from workbench.parameters.sets import named_sets
    from workbench.toml.reading import read_toml

    return [f"{name:22} {read_toml(path)[0]['title']}" for name, path in named_sets().items()]


def _layers(axis: str) -> list[str]:
    """The machines or scenarios that a study in this folder can name."""
    from workbench.study.layers import LAYERS
    from workbench.toml.reading import read_toml

    files = LAYERS[axis].files(Path.cwd())
    return [f"{name:22} {read_toml(path)[0].get('title', '')}" for name, path in files.items()]


def _references() -> list[str]:
    from workbench.study.reference_tables import REFERENCES

    return [
        *(
            f"{name:22} {', '.join(field for field in kind.table.model_fields if field != 'kind')}"
            for name, kind in REFERENCES.working().items()
        ),
        *_broken(REFERENCES),
    ]


def _effects() -> list[str]:
    from plants.effects.registry import EFFECTS

    return [*(line for effect in EFFECTS.working().values() for line in _effect(effect)), *_broken(EFFECTS)]


def _effect(effect: Effect) -> list[str]:
    """An effect, and its parameters: unit, default, at which it does nothing, and where a diagnosis searches."""
    from workbench.parameters.sets import known_units

    units = known_units() | {item.name: item.unit for item in fields(effect.Own)}
    turning = known_units(ROTARY) if _of_turning(effect) else {}
    lines = [f"{effect.name:28} {effect.balance:7} {effect.words}", *[f"  {effect.meaning}"] * bool(effect.meaning)]
    turned = []
    nodes = nodes_of(effect.name)
    for name, number in effect.numbers.items():
        if name in nodes[1:-1]:
            continue
        default = f"default {effect.neutral[name]:g}" if name in effect.neutral else "the plant's own"
        lines.append(
            f"{'  ' + name:28} {units.get(name, ''):16} {default:16} {_searched(number) if effect.sought else GIVEN}"
        )
        other = name_along(name, ROTARY)
        if other in turning and (other, turning[other]) != (name, units.get(name)):
            turned.append(f"{other} in {turning[other]}")
    lines += [f"  on a turning axis {', '.join(turned)}"] * bool(turned)
    return lines


def _of_turning(effect: Effect) -> bool:
    """Whether some plant whose axis turns can have it."""
    return any(not lacks(plant, effect.along(ROTARY)) for plant in PLANTS.working().values() if plant.axis == ROTARY)


GIVEN = "given, not searched"

SCALED = " times the machine's own scale"


def _searched(number: Number) -> str:
    """Between which values a diagnosis looks for a parameter, in its unit or in a scale of the machine's."""
    low = "any value" if number.low <= -FREE else f"{number.low:g}"
    reach = f"from {low} up" if number.high >= FREE else f"from {low} to {number.high:g}"
    return f"searched {reach}{'' if number.scale is plain else SCALED}"


def _integrators() -> list[str]:
    from workbench.simulation.integrators.registry import INTEGRATORS

    methods = INTEGRATORS.working().items()
    return [*(f"{name:22} {method.summary}" for name, method in methods), *_broken(INTEGRATORS)]


def _formats() -> list[str]:
    from workbench.records.formats.registry import FORMATS

    formats = FORMATS.working().items()
    return [*(f"{name:22} {', '.join(one.endings)}: {one.summary}" for name, one in formats), *_broken(FORMATS)]


def _columns() -> list[str]:
    from workbench.metrics.registry import METRICS, columns

    found = zip(columns().values(), columns(ROTARY).values(), strict=True)
    return [
        *(f"{item.name:28} {item.unit:8} {item.meaning}{_turned(item, other)}" for item, other in found),
        *_broken(METRICS),
    ]


def _turned(item: Column, other: Column) -> str:
    """What a column is called on an axis that turns, where that is another name."""
    return "" if other.name == item.name else f"; on a turning axis {other.name}, in {other.unit}"


CATALOGUE: Mapping[str, Callable[[], list[str]]] = {
    "plants": _plants,
    "friction_laws": _friction_laws,
    "controllers": _controllers,
    "parameters": _parameters,
    "machines": lambda: _layers("machine"),
    "scenarios": lambda: _layers("scenario"),
    "references": _references,
    "effects": _effects,
    "integrators": _integrators,
    "formats": _formats,
    "columns": _columns,
}
"""What gives the lines of each section, in the order in which they are shown; each imports what it alone needs."""


def _broken(registry: Registry[object]) -> list[str]:
    """Plug-ins that cannot be used, and why."""
    return [f"{name:22} {failure}" for name, failure in registry.broken().items()]


def _controller(name: str, controller: Controller) -> list[str]:
    """A controller, its settings under what they need in order to count, and the signals that its state gives."""
    groups: dict[str, list[Setting]] = {"": []}
    for setting in usable(controller).values():
        groups.setdefault(str(setting.needs or ""), []).append(setting)
    lines = [f"{name:22} {controller.summary}"]
    for needs, settings in groups.items():
        lines += [f"  with {needs}"] * bool(needs)
        lines += [_setting(setting, "    " if needs else "  ") for setting in settings]
    from workbench.simulation.setup import memory_names

    names = memory_names(controller)
    return [*lines, f"  signals: {', '.join(names)}"] if names else lines


def _setting(setting: Setting, indent: str) -> str:
    default = "needed" if setting.default is None else f"default {setting.default or repr(setting.default)}"
    kind = setting.unit or ("name" if setting.choices == (ANY,) else "choice")
    among = setting.about.short if setting.unit else " | ".join(item for item in setting.choices if item != ANY)
    ranged = setting.tuned.short if setting.tuned is not None else ""
    said = "; ".join(words for words in (setting.about.meaning, among, ranged) if words)
    return f"{indent + setting.name:28} {kind:16} {default:16} {said}".rstrip()
