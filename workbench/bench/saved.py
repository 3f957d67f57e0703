"""A loop of the bench as a study file that `workbench run` reproduces to the last digit."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomli_w

from workbench.bench.figures_table import COLUMNS
from workbench.bench.measured import MeasuredLoop
from workbench.bench.outcome import Outcome
from workbench.errors import UserError
from workbench.metrics.registry import names_along
from workbench.parameters.sets import named_sets
from workbench.publish.folders import write_whole
from workbench.study.names import unit_of_column

FILES = (("plant", "parameters"), ("belief", "parameters"))
"""Keys of tables that may name a file."""


def study_text(outcome: Outcome, folder: Path) -> str:
    """The study file of a loop, for a place in `folder`: the loop as it stands, and a table of its figures."""
    loop = outcome.loop
    content = _moved(loop.as_study, loop.folder, folder)
    called = names_along(outcome.run.plant.axis)
    figures = [(called[name], words) for name, words in COLUMNS if outcome.figures.get(called[name]) is not None]
    rows = [
        {"result": name, "label": words, "unit": unit_of_column(name), "digits": 17}
        for name, words in figures
        if isinstance(outcome.figures[name], float)
    ]
    table = {"name": "figures", "title": "Figures of the loop", "rows": rows}
    return tomli_w.dumps({**content, "tables": [table]} if rows else content)


def _moved(content: Mapping[str, Any], here: Path, there: Path) -> dict[str, Any]:
    """A study's content with the files that it names as they are found from another folder."""

    def path(name: object) -> object:
        if not isinstance(name, str) or name in named_sets():
            return name
        return os.path.relpath(here / name, there)

    def tables(one: Mapping[str, Any]) -> dict[str, Any]:
        moved = dict(one)
        for section, key in FILES:
            if key in (table := moved.get(section, {})):
                moved[section] = {**table, key: path(table[key])}
        return moved

    moved = tables(content)
    for layer in ("machines", "scenarios"):
        if layer in moved:
            moved[layer] = {name: tables(table) for name, table in moved[layer].items()}
    if "references" in moved:
        moved["references"] = {
            name: {**table, "file": path(table["file"])} if "file" in table else table
            for name, table in moved["references"].items()
        }
    axes = moved.get("axes", {})
    moved["axes"] = {
        key: [path(value) for value in values] if tuple(key.split(".")) in FILES else values
        for key, values in axes.items()
    }
    return {name: value for name, value in moved.items() if value}


def save(outcome: Outcome, name: str, folder: Path, *, replace: bool = False) -> Path:
    """Write the study of a loop as a file below `folder`; returns its path.

    Raises:
        UserError: a name that leads out of the folder or has another ending, or a file that is there already.
    """
    if isinstance(outcome.loop, MeasuredLoop):
        raise UserError("what a record drives is no study; identify or diagnose the experiment to keep what it says")
    path = (folder / name.strip()).resolve()
    if not path.is_relative_to(folder.resolve()) or path == folder.resolve():
        raise UserError(
            f'"{name}" leads out of the folder in which the bench was opened; expected a name such as my.toml'
        )
    if path.suffix != ".toml":
        raise UserError(f'"{name}": expected a name that ends in .toml')
    if not path.parent.is_dir():
        raise UserError(f"{path.parent.relative_to(folder.resolve())}: no such folder")
    if path.exists() and not replace:
        raise UserError(f"{name}: there is a file of this name; choose another, or allow that it is replaced")
    text = study_text(outcome, path.parent)
    write_whole(path, lambda into: into.write_text(text, encoding="utf-8"))
    return path
