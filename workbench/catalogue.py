"""What there is to put into a study, in words."""

import typing
from pathlib import Path

from controllers.interface import Controller
from controllers.registry import CONTROLLERS
from controllers.settings import ANY, Setting, usable
from plants.effects import EFFECTS
from plants.plugins import Registry
from plants.registry import PLANTS
from workbench.diagnose.report.names import PLAIN
from workbench.metrics import COLUMNS
from workbench.parameters.sets import named_sets
from workbench.simulation.simulate import METHODS, memory_names
from workbench.study.layers import LAYERS
from workbench.study.reference_tables import KINDS
from workbench.study.resolve import MODELS
from workbench.toml.reading import read_toml


def catalogue() -> dict[str, list[str]]:
    """Lines by section, in the order in which they are shown."""
    return {
        "plants": [
            f"{'model':22} {', '.join(MODELS)}",
            *(f"{name:22} {plant.summary}" for name, plant in PLANTS.working().items()),
            *_broken(PLANTS),
        ],
        "controllers": [
            *(line for name, controller in CONTROLLERS.working().items() for line in _controller(name, controller)),
            *_broken(CONTROLLERS),
        ],
        "parameters": [f"{name:22} {read_toml(path)[0]['title']}" for name, path in named_sets().items()],
        **{
            layer.section: [
                f"{name:22} {read_toml(path)[0].get('title', '')}" for name, path in layer.files(Path.cwd()).items()
            ]
            for layer in LAYERS.values()
        },
        "references": [
            f"{kind:22} {', '.join(name for name in table.model_fields if name != 'kind')}"
            for kind, table in KINDS.items()
        ],
        "effects": [
            f"{effect.name:28} {effect.balance:7} {PLAIN[effect.name]}; {', '.join(effect.numbers)}"
            for effect in EFFECTS.values()
        ],
        "integrators": list(METHODS),
        "columns": list(COLUMNS),
    }


def _broken(registry: Registry[typing.Any]) -> list[str]:
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
    names = memory_names(controller)
    return [*lines, f"  signals: {', '.join(names)}"] if names else lines


def _setting(setting: Setting, indent: str) -> str:
    default = "needed" if setting.default is None else f"default {setting.default or repr(setting.default)}"
    kind = setting.unit or ("name" if setting.choices == (ANY,) else "choice")
    among = setting.about.short if setting.unit else " | ".join(item for item in setting.choices if item != ANY)
    ranged = setting.tuned.short if setting.tuned is not None else ""
    said = "; ".join(words for words in (setting.about.meaning, among, ranged) if words)
    return f"{indent + setting.name:28} {kind:16} {default:16} {said}".rstrip()
