"""The reference of the Python interface: the docstrings of `workbench.api`, read by autodoc."""

import inspect
from pathlib import Path

from controllers.registry import CONTROLLERS
from workbench import api


def page(folder: Path) -> str:
    """Every public name, under what it is for; functions of controllers last."""
    types = [name for name in CONTROLLERS.working() if name in api.__all__]
    kinds = {
        "Functions": [name for name in api.__all__ if inspect.isfunction(getattr(api, name)) and name not in types],
        "Classes": [name for name in api.__all__ if inspect.isclass(getattr(api, name))],
        "Controllers": types,
    }
    parts = ["# Python names", _rest(".. automodule:: workbench.api")]
    for heading, names in kinds.items():
        parts += [f"## {heading}", *(_rest(_directive(name)) for name in names)]
    return "\n\n".join(parts) + "\n"


def _directive(name: str) -> str:
    if inspect.isclass(getattr(api, name)):
        return f".. autoclass:: workbench.api.{name}\n   :members:"
    return f".. autofunction:: workbench.api.{name}"


def _rest(text: str) -> str:
    return f"```{{eval-rst}}\n{text}\n```"
