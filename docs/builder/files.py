"""The reference of study, experiment, machine and other files: every key of their schemas, with what stands beside it.

Of each key the type, unit, default and limits are those that pydantic checks; its meaning is the text below the field.
"""

import ast
import functools
import inspect
import itertools
import re
import textwrap
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from builder.markdown import cell, table
from builder.types import kind_of, models_in
from workbench.parameters.sets import ParameterFile
from workbench.records.schema import ExperimentFile
from workbench.study.layers import MachineFile, ScenarioFile
from workbench.study.reference_tables import REFERENCES
from workbench.study.report.schema import Probe
from workbench.study.schema import BeliefTable, PlantTable, SensorsTable, SimulationTable, StudyFile
from workbench.study.sections import OURS, load
from workbench.study.uncertainty_schema import UncertaintyTable
from workbench.toml.gain_file import GainFile

STUDY = {
    "[plant]": PlantTable,
    "[belief]": BeliefTable,
    "[sensors]": SensorsTable,
    "[simulation]": SimulationTable,
    "[probes.NAME]": Probe,
    "[uncertainty]": UncertaintyTable,
}
"""Tables of a study whose content is checked case by case."""


def study_page(folder: Path) -> str:
    """Every key of a study file."""
    parts = [
        "# Study files",
        "Every key of a study, as `workbench check` knows it. [How to write one](../study_files.md) says what they are "
        "for. A quantity is text with a unit, or a bare number in SI; speeds of rotation without a unit are in rpm.",
        _section("The file", StudyFile),
    ]
    seen: set[type[BaseModel]] = {*STUDY.values()}
    parts += [_section(heading, model) for heading, model in STUDY.items()]
    parts += [_nested(StudyFile, seen)]
    parts += [
        "## [references.NAME]",
        "`kind` chooses what else stands there; amplitudes are in the unit of the axis.",
    ]
    for kind in REFERENCES.working().values():
        parts += [f'### kind = "{kind.name}"', _keys(kind.table, {"kind"})]
    for name in OURS:
        section = load(name)
        heading = f"[[{name}]]" if section.several else f"[{name}]"
        parts += [_section(heading, section.table), _nested(section.table, seen)]
    return "\n\n".join(part for part in parts if part) + "\n"


def experiment_page(folder: Path) -> str:
    """Every key of an experiment file."""
    text = "Every key of an experiment. [How to write one](../experiments.md) says what they are for."
    parts = ["# Experiment files", text, _section("The file", ExperimentFile), _nested(ExperimentFile, set())]
    return "\n\n".join(parts) + "\n"


def machine_page(folder: Path) -> str:
    """Every key of the files that a study names beside it."""
    text = "Every key of the files that a study names beside it. [Machines](../machines.md) has the parameters."
    parts = ["# Machine, scenario, parameter and gain files", text]
    for heading, model in (
        ("Machines: machines/NAME.toml", MachineFile),
        ("Scenarios: scenarios/NAME.toml", ScenarioFile),
        ("Parameters", ParameterFile),
        ("Gains", GainFile),
    ):
        parts += [_section(heading, model), _nested(model, set())]
    return "\n\n".join(part for part in parts if part) + "\n"


def _nested(model: type[BaseModel], seen: set[type[BaseModel]]) -> str:
    """A section for each model that a model's keys lead to, each once."""
    parts = []
    for inner in _inner(model):
        if inner not in seen:
            seen.add(inner)
            parts += [_section(_split(inner)[0], inner), _nested(inner, seen)]
    return "\n\n".join(part for part in parts if part)


def _inner(model: type[BaseModel]) -> Iterator[type[BaseModel]]:
    for field in model.model_fields.values():
        yield from models_in(field.annotation)


def _section(heading: str, model: type[BaseModel]) -> str:
    return f"## {heading}\n\n{_split(model)[1]}\n\n{_keys(model)}"


def _split(model: type[BaseModel]) -> tuple[str, str]:
    """What the class says of itself: what it is, and the rest."""
    said = inspect.cleandoc(model.__doc__ or "")
    name, rest = re.split(r"[:;.](?:\s+|$)", said, maxsplit=1)
    return name, rest[:1].upper() + rest[1:]


def _keys(model: type[BaseModel], without: Collection[str] = ()) -> str:
    meanings = meanings_of(model)
    rows = [
        [f"`{name}`", kind_of(field), _default(field), cell(meanings[name])]
        for name, field in model.model_fields.items()
        if name not in without
    ]
    return table(["key", "value", "default", "meaning"], rows)


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "needed"
    value: Any = field.get_default(call_default_factory=True)
    if value is None or value in ("", [], {}) or isinstance(value, BaseModel):
        return ""
    return f"`{str(value).lower() if isinstance(value, bool) else value}`"


@functools.cache
def meanings_of(model: type[BaseModel]) -> dict[str, str]:
    """The text below each field of a schema, its bases' too.

    Raises:
        KeyError: a field without one is asked for.
    """
    found: dict[str, str] = {}
    for cls in reversed(model.__mro__):
        if issubclass(cls, BaseModel) and cls.__module__.startswith("workbench"):
            found |= _fields_below(cls)
    return found


def _fields_below(cls: type) -> dict[str, str]:
    (tree,) = ast.parse(textwrap.dedent(inspect.getsource(cls))).body
    body = tree.body if isinstance(tree, ast.ClassDef) else []
    return {
        first.target.id: inspect.cleandoc(second.value.value)
        for first, second in itertools.pairwise(body)
        if isinstance(first, ast.AnnAssign)
        and isinstance(first.target, ast.Name)
        and isinstance(second, ast.Expr)
        and isinstance(second.value, ast.Constant)
    }
