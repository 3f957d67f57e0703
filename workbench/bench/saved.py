"""A loop of the bench as a study file that `workbench run` reproduces to the last digit."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomli_w

from workbench.bench.loop import BenchLoop
from workbench.bench.measured import MeasuredLoop
from workbench.bench.outcome import Outcome
from workbench.errors import UserError
from workbench.metrics.registry import names_along
from workbench.parameters.sets import named_sets
from workbench.publish.folders import write_whole
from workbench.study.layers import LAYERS
from workbench.study.names import unit_of_column
from workbench.study.report.shown_figures import FIGURES

PARAMETERS = (("plant", "parameters"), ("belief", "parameters"))
"""Tables with a key that names a parameter set or a file."""

FILE = "file"
"""The key of a recorded reference."""


def study_text(outcome: Outcome, folder: Path) -> str:
    """The study file of a loop, for a place in `folder`: the loop as it stands, and a table of its figures."""
    content = _moved(outcome.loop, folder)
    called = names_along(outcome.run.plant.axis)
    figures = [(called[name], words) for name, words in FIGURES if outcome.figures.get(called[name]) is not None]
    rows = [
        {"result": name, "label": words, "unit": unit_of_column(name), "digits": 17}
        for name, words in figures
        if isinstance(outcome.figures[name], float)
    ]
    table = {"name": "figures", "title": "Figures of the loop", "rows": rows}
    return tomli_w.dumps({**content, "tables": [table]} if rows else content)


def _moved(loop: BenchLoop, there: Path) -> dict[str, Any]:
    """The content of a loop's study with the machine, the scenario and the files that it names as they are found from
    another folder: layers are written into it, names of files are relative to that folder.
    """
    here = loop.folder.resolve()

    def path(name: object) -> object:
        return os.path.relpath((here / name).resolve(), there.resolve()) if isinstance(name, str) else name

    def parameters(name: object) -> object:
        return name if name in named_sets() else path(name)

    def tables(one: Mapping[str, Any]) -> dict[str, Any]:
        moved = dict(one)
        for section, key in PARAMETERS:
            if key in (table := moved.get(section, {})):
                moved[section] = {**table, key: parameters(table[key])}
        return moved

    moved = tables(loop.as_study)
    axes = dict(moved.get("axes", {}))
    for axis, layer in LAYERS.items():
        if axis in axes:
            known = getattr(loop.study.file, layer.section)
            moved[layer.section] = {name: tables(known[name]) for name in axes[axis]}
    if "references" in moved:
        moved["references"] = {
            name: {**table, FILE: path(table[FILE])} if FILE in table else table
            for name, table in moved["references"].items()
        }
    for key, values in axes.items():
        first, last = key.partition(".")[0], key.rpartition(".")[2]
        if (first, last) in PARAMETERS:
            axes[key] = [parameters(value) for value in values]
        elif (first, last) == ("references", FILE):
            axes[key] = [path(value) for value in values]
    return {name: value for name, value in {**moved, "axes": axes}.items() if value}


def save(outcome: Outcome, name: str, folder: Path, *, replace: bool = False) -> Path:
    """Write the study of a loop as a file below `folder`; returns its path.

    Raises:
        UserError: a name that leads out of the folder or has another ending, or a file that is there already.
    """
    if isinstance(outcome.loop, MeasuredLoop):
        raise UserError("what a record drives is no study; identify or diagnose the experiment to keep what it says")
    try:
        path = (folder / name.strip()).resolve()
        os.fsencode(path)
    except (ValueError, RuntimeError, OSError):
        raise UserError(f"{name!r} is no name of a file; expected a name such as my.toml") from None
    if not path.is_relative_to(folder.resolve()) or path == folder.resolve():
        raise UserError(
            f'"{name}" leads out of the folder in which the bench was opened; expected a name such as my.toml'
        )
    if path.suffix != ".toml":
        raise UserError(f'"{name}": expected a name that ends in .toml')
    if not path.parent.is_dir():
        raise UserError(f"{path.parent.relative_to(folder.resolve())}: no such folder")
    if path.is_dir():
        raise UserError(f"{name}: this is a folder; choose another name")
    if path.exists() and not replace:
        raise UserError(f"{name}: there is a file of this name; choose another, or allow that it is replaced")
    text = study_text(outcome, path.parent)
    write_whole(path, lambda into: into.write_text(text, encoding="utf-8"))
    return path
