"""What there is to put into a study, in words."""

import typing

from controllers.registry import controllers
from plants.registry import plants
from workbench.files import read_toml
from workbench.metrics import COLUMNS
from workbench.parameters import named_sets
from workbench.simulation.simulate import METHODS
from workbench.study.reference_tables import KINDS
from workbench.study.resolve import MODELS


def catalogue() -> dict[str, list[str]]:
    """Lines by section, in the order in which they are shown."""
    return {
        "plants": [f"{'model':22} {', '.join(MODELS)}", *(f"{p.name:22} {p.summary}" for p in plants().values())],
        "controllers": [line for controller in controllers().values() for line in _controller(controller)],
        "parameters": [f"{name:22} {read_toml(path)[0]['title']}" for name, path in named_sets().items()],
        "references": [
            f"{kind:22} {', '.join(name for name in table.model_fields if name != 'kind')}"
            for kind, table in KINDS.items()
        ],
        "integrators": list(METHODS),
        "columns": list(COLUMNS),
    }


def _controller(controller: typing.Any) -> list[str]:
    hints = typing.get_type_hints(controller.Settings, include_extras=True)
    defaults = controller.Settings._field_defaults
    lines = [f"{controller.name:22} {controller.summary}"]
    for name, hint in hints.items():
        meaning = hint.__metadata__[0] if hint.__origin__ is float else " | ".join(hint.__metadata__)
        default = f"default {defaults[name]}" if name in defaults else "needed"
        lines.append(f"  {name:26} {meaning:22} {default}")
    return lines
