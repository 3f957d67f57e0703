"""A study file, and the cases that it unfolds into: its cases, times the product of its axes."""

import copy
import functools
import hashlib
import itertools
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from workbench import files
from workbench.errors import UserError, nearest
from workbench.study.gain_file import KEY, GainFile, read_gain_file, with_gains
from workbench.study.layers import LAYERS, MACHINE, Layer
from workbench.study.quantities import rpm_si
from workbench.study.schema import OVERRIDES, StudyFile

NAMED_AXES = ("rpm", "controller", "reference", *LAYERS)
"""Axes that are not dotted keys of the file."""

CASE = "case"
"""The column that names which of [cases] a row belongs to."""


REPORTED = {"title", "source", "question", "tables", "figures", "break_even", "comparison", "friction_curves"}
"""What a study says of its report: no result depends on it."""

TUNED = {"uncertainty", "tune", "decide"}
"""What a study says of other commands than `run`."""


@dataclass(frozen=True)
class Study:
    """A study file as read. `file.machines` and `file.scenarios` hold those of files too, whose path and text are in
    `sources`, by section and name.
    """

    path: Path
    text: str
    file: StudyFile
    sources: Mapping[files.Key, tuple[Path, str]] = field(default_factory=dict)

    def error(self, key: files.Key, message: str) -> UserError:
        """The error for a mistake at `key`, in the file of a machine or scenario where that is what holds it."""
        if key[:2] in self.sources:
            return files.at(*self.sources[key[:2]], key[2:], message)
        return files.at(self.path, self.text, key, message)

    @property
    def fingerprint(self) -> str:
        """A hash of what the study computes: of all but what it says of its report."""
        content = self.file.model_dump(exclude=REPORTED | TUNED)
        return hashlib.sha256(json.dumps(content, sort_keys=True, default=str).encode()).hexdigest()


@dataclass(frozen=True)
class Case:
    """One point of a study, before anything is built: `tables` is what the file says there.

    `axes` are its columns in the results; `declared` is the plant table of its machine, without what scenario and axes
    changed: what a controller may believe. Plain data, so that it can travel to another process. `tells_solver_error`
    is false on all draws but the first: what the integration adds is the loop's own, and costs more than the run.
    """

    index: int
    name: str | None
    axes: Mapping[str, Any]
    tables: dict[str, Any]
    declared: dict[str, Any]
    folder: Path
    tells_solver_error: bool = True

    @property
    def columns(self) -> dict[str, Any]:
        """The columns that tell this case from the others."""
        return {**({CASE: self.name} if self.name is not None else {}), **self.axes}

    @property
    def rpm(self) -> float:
        """The speed of rotation that the case asks for (rpm), in whole millionths."""
        return rpm_of(self.tables)

    @property
    def label(self) -> str:
        """The case in words."""
        return ", ".join(f"{name} {value}" for name, value in self.columns.items()) or "the only case"


def read_study(path: Path) -> Study:
    """Read and check a study file (not yet its cases).

    Raises:
        UserError: unreadable, not TOML, unknown or missing keys.
    """
    data, text = files.read_toml(path)
    study = Study(path, text, files.validate(StudyFile, data, path, text))
    file = study.file
    sections = [layer.section for layer in LAYERS.values()]
    for section in ("cases", *sections):
        for name, overrides in getattr(file, section).items():
            allowed = [key for key in OVERRIDES if not (section in sections and key == "axes")]
            for key in overrides:
                if key not in allowed:
                    raise study.error((section, name, key), f"unknown key; {nearest(key, allowed)}")
    for layer in LAYERS.values():
        beside, own = layer.files(path.parent), getattr(file, layer.section)
        wanted = [name for name in _named_on(file, layer.axis) if name in beside and name not in own]
        study = _with_files(study, layer, {name: beside[name] for name in wanted})
    return study if file.decide is None or file.decide.machine is None else deciding_on(study, file.decide.machine)


def deciding_on(study: Study, machine: str) -> Study:
    """The study with its [decide] on the machine of that name, whose file is read where the study has no such table.

    Raises:
        UserError: there is no such machine, or no [decide].
    """
    decide, beside = study.file.decide, MACHINE.files(study.path.parent)
    if decide is None:
        raise UserError(f"{study.path}: has no [decide] that could be on a machine")
    known = {*study.file.machines, *beside}
    if machine not in known:
        raise study.error(("decide", "machine"), f'unknown machine "{machine}"; {nearest(machine, sorted(known))}')
    if machine not in study.file.machines:
        study = _with_files(study, MACHINE, {machine: beside[machine]})
    asked = decide.model_copy(update={"machine": machine})
    return replace(study, file=study.file.model_copy(update={"decide": asked}))


def only_decides(study: Study) -> bool:
    """Whether a study has a question for `decide` and nothing to run: a decision makes its own reference."""
    return study.file.decide is not None and not study.file.references and not study.file.cases


def _named_on(file: StudyFile, axis: str) -> list[str]:
    """What all axes of that name say, in whatever shape they are."""
    tables = [file.axes, *(overrides.get("axes") for overrides in file.cases.values())]
    lists = [table.get(axis) for table in tables if isinstance(table, dict)]
    return [value for values in lists if isinstance(values, list) for value in values if isinstance(value, str)]


def _with_files(study: Study, layer: Layer, paths: Mapping[str, Path]) -> Study:
    """The study with the machines or scenarios of these files beside its own."""
    known, sources = dict(getattr(study.file, layer.section)), dict(study.sources)
    for name, path in paths.items():
        content, text = layer.read(path)
        known[name], sources[layer.section, name] = content.overrides, (path, text)
    return replace(study, file=study.file.model_copy(update={layer.section: known}), sources=sources)


def layer_trial(layer: Layer, path: Path) -> Study:
    """A study of one case that takes the machine or scenario at `path`: what it would do to the thesis's actuator.

    Raises:
        UserError: unreadable, not TOML, unknown or missing keys.
    """
    content = {
        "title": path.stem,
        "plant": {"model": "non_rotating", "parameters": "owen2001_simulation"},
        "controllers": {"p": {"type": "pid", "kp": "500 V/m"}},
        "references": {"step": {"kind": "steps", "levels": ["5 mm"], "dwell": "1 s"}},
        "simulation": {"duration": "1 s"},
        "axes": {layer.axis: [path.stem]},
    }
    beside = path.resolve().parent.parent / path.name  # where a study that names it stands
    return _with_files(Study(beside, "", StudyFile.model_validate(content)), layer, {path.stem: path})


def rpm_of(tables: Mapping[str, Any]) -> float:
    """The speed of rotation (rpm) that the tables of a case ask for, in whole millionths."""
    return round(rpm_si(tables.get("rpm", 0.0)) * 30.0 / math.pi, 6)


def named(case: Case, kind: str) -> str:
    """The name of a case's "controller" or "reference": what an axis says, else the only one; "" if there is none."""
    return case.tables.get(kind) or next(iter(case.tables[f"{kind}s"]), "")


def unfold(study: Study) -> list[Case]:
    """All cases, in order: [cases] first, then the axes as they stand, the last one changing fastest.

    Raises:
        UserError: an axis that is empty, unknown, or names something that the file does not hold.
    """
    file = study.file
    base = {name: copy.deepcopy(getattr(file, name)) for name in OVERRIDES}
    cases: list[Case] = []
    read = functools.cache(read_gain_file)
    named: list[tuple[str | None, dict[str, Any]]] = [*file.cases.items()] or [(None, {})]
    for name, overrides in named:
        tables = merged(base, {key: value for key, value in overrides.items() if key != "axes"})
        axes = overrides.get("axes", tables.pop("axes"))
        tables.pop("axes", None)
        _check_axes(study, name, axes, tables)
        for values in itertools.product(*axes.values()):
            point = dict(zip(axes, values, strict=True))
            filled, declared = _at_point(study, name, tables, point, read)
            cases.append(Case(len(cases), name, point, filled, declared, study.path.parent))
    return cases


def merged(base: Mapping[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with `overrides` laid over it, table by table; lists and values are replaced."""
    result = dict(copy.deepcopy(dict(base)))
    for key, value in overrides.items():
        if isinstance(value, Mapping) and isinstance(result.get(key), Mapping):
            result[key] = merged(result[key], value)
        else:
            result[key] = copy.deepcopy(value)
    return result


def _check_axes(study: Study, case: str | None, axes: Any, tables: Mapping[str, Any]) -> None:
    place = axes_key(study, case)
    if not isinstance(axes, dict):
        raise study.error(place, "expected a table of lists")
    for axis, values in axes.items():
        key = (*place, axis)
        if not isinstance(values, list):
            raise study.error(key, f"got {values!r}, expected a list")
        if not values:
            raise study.error(key, "is empty: expected at least one value (or leave the axis out)")
        if len({json.dumps(value, sort_keys=True) for value in values}) < len(values):
            raise study.error(key, "holds a value twice")
        known = {
            "controller": tables["controllers"],
            "reference": tables["references"],
            **{
                layer.axis: {**getattr(study.file, layer.section), **layer.files(study.path.parent)}
                for layer in LAYERS.values()
            },
        }
        if axis in known:
            for value in values:
                if not isinstance(value, str) or value not in known[axis]:
                    where = ""
                    if axis in LAYERS:
                        folder = study.path.parent / LAYERS[axis].section
                        where = f" (looked in this file, {folder} and the program's own)"
                    raise study.error(key, f'unknown {axis} "{value}"; {nearest(str(value), known[axis])}{where}')
        elif axis not in NAMED_AXES and axis.split(".")[0] not in OVERRIDES:
            roots = [*NAMED_AXES, *(f"{name}. ..." for name in OVERRIDES if name != "axes")]
            raise study.error(key, f"unknown axis; {nearest(axis, roots)} (or a dotted key of the file)")
        elif (section := axis.split(".")[0]) in ("controllers", "references"):
            name = axis.partition(".")[2].split(".")[0]
            if name not in tables[section]:
                raise study.error(key, f'unknown {section[:-1]} "{name}"; {nearest(name, tables[section])}')


def axes_key(study: Study, case: str | None) -> files.Key:
    """Where the axes of a case stand: with the case if it has its own."""
    return ("cases", case, "axes") if case and "axes" in study.file.cases[case] else ("axes",)


def _at_point(
    study: Study,
    case: str | None,
    tables: Mapping[str, Any],
    point: Mapping[str, Any],
    read: Callable[[Path], GainFile],
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The tables of a case at one point of its axes, and the plant that is declared there."""
    result = copy.deepcopy(dict(tables))
    declared = result["plant"]
    for axis, layer in LAYERS.items():
        if axis in point:
            result = merged(result, getattr(study.file, layer.section)[point[axis]])
        if layer is MACHINE:
            declared = copy.deepcopy(result["plant"])
    for axis, value in point.items():
        if axis in ("rpm", "controller", "reference"):
            result[axis] = value
        elif axis not in LAYERS:
            *parents, last = axis.split(".")
            table = result
            for part in parents:
                table = table.setdefault(part, {})
                if not isinstance(table, dict):
                    raise study.error((*axes_key(study, case), axis), f'"{part}" is not a table')
            table[last] = value
    result["controllers"] = _with_gains(study, result, point.get(MACHINE.axis), read)
    return result, declared


def _with_gains(
    study: Study, tables: Mapping[str, Any], machine: str | None, read: Callable[[Path], GainFile]
) -> dict[str, Any]:
    """Controllers with what their gain files say for a case's speed and machine.

    Of controllers beside the case's own a file that has nothing for this speed is left: they have cases of their own.
    """
    controllers = tables["controllers"]
    found, own = dict(controllers), tables.get("controller") or next(iter(controllers), None)
    for name, table in controllers.items():
        if not isinstance(table, dict) or KEY not in table:
            continue  # what is no table is told when the case is resolved
        try:
            found[name] = with_gains(table, study.path.parent, rpm_of(tables), machine, read)
        except UserError as error:
            if name == own:
                raise study.error(("controllers", name, KEY), str(error)) from None
    return found


def located(study: Study, case: Case, key: files.Key, message: str) -> UserError:
    """The mistake where the user wrote it: on an axis, in scenario or machine, in the case, or in the study itself."""
    for axis in case.axes:
        parts = tuple(axis.split("."))
        if parts == tuple(map(str, key[: len(parts)])):
            return study.error((*axes_key(study, case.name), axis, *key[len(parts) :]), message)
    layers: list[tuple[files.Key, Any]] = [((), study.file.model_dump(include=set(OVERRIDES)))]
    if case.name:
        layers.append((("cases", case.name), study.file.cases[case.name]))
    for axis, layer in LAYERS.items():
        if name := case.axes.get(axis):
            layers.append(((layer.section, name), getattr(study.file, layer.section)[name]))
    place: files.Key = ()
    depth = -1
    for prefix, table in layers:
        found = _depth(table, key)
        if found > depth or found == len(key):  # what is written twice was last written in the later layer
            place, depth = prefix, found
    return study.error((*place, *key), message)


def _depth(table: Any, key: files.Key) -> int:
    """How many parts of `key` lead into `table`."""
    for depth, part in enumerate(key):
        if isinstance(table, list) and isinstance(part, int) and part < len(table):
            table = table[part]
        elif isinstance(table, dict) and part in table:
            table = table[str(part)]
        else:
            return depth
    return len(key)
