"""What there is to put into a study, in words."""

import typing

from controllers.interface import Controller
from controllers.registry import CONTROLLERS
from plants.plugins import Registry
from plants.registry import PLANTS
from workbench.files import read_toml
from workbench.metrics import COLUMNS
from workbench.parameters import named_sets
from workbench.simulation.simulate import METHODS
from workbench.study.reference_tables import KINDS
from workbench.study.resolve import MODELS


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
        "references": [
            f"{kind:22} {', '.join(name for name in table.model_fields if name != 'kind')}"
            for kind, table in KINDS.items()
        ],
        "integrators": list(METHODS),
        "columns": list(COLUMNS),
    }


def _broken(registry: Registry[typing.Any]) -> list[str]:
    """Plug-ins that cannot be used, and why."""
    return [f"{name:22} {failure}" for name, failure in registry.broken().items()]


def _controller(name: str, controller: Controller) -> list[str]:
    settings: typing.Any = controller.Settings
    hints = typing.get_type_hints(settings, include_extras=True)
    defaults = settings._field_defaults
    lines = [f"{name:22} {controller.summary}"]
    for setting, hint in hints.items():
        meaning = hint.__metadata__[0] if hint.__origin__ is float else " | ".join(hint.__metadata__)
        default = f"default {defaults[setting]}" if setting in defaults else "needed"
        lines.append(f"  {setting:26} {meaning:22} {default}")
    return lines
