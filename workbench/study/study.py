"""A study as read, and its cases as the file has them: plain data, with the place of every mistake."""

import hashlib
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

from workbench.errors import UserError, nearest, shortened
from workbench.metrics.registry import METRICS
from workbench.study.layers import LAYERS
from workbench.study.overrides import DECLARED, Overrides
from workbench.study.schema import OVERRIDES, StudyFile
from workbench.toml import reading as files
from workbench.toml.quantities import rpm_si
from workbench.toml.reading import Strict

T = TypeVar("T", bound=Strict)

NAMED_AXES = ("rpm", "controller", "reference", *LAYERS)
"""Axes that are not dotted keys of the file."""


CASE = "case"
"""The column that names which of [cases] a row belongs to."""

DRAW = "draw"
"""The column that numbers the machines on which a case is run, where the study draws any."""

INDEX = "case_index"
"""The column of the database that orders the cases; not exported."""


REPORTED = {"title", "source", "question", "tables", "figures", "uncertainty"}
"""What of a study's own tables `computed` leaves out: its report, and machines, which the numbers of a plan tell."""


@dataclass(frozen=True)
class Study:
    """A study file as read. `file.machines` and `file.scenarios` hold those of files too, whose path and text are in
    `sources`, by section and name. `allow_fmu` says whether the FMUs that it names, foreign code, may be
    run; None where nothing is, so that nobody is asked.
    """

    path: Path
    text: str
    file: StudyFile
    sources: Mapping[files.Key, tuple[Path, str]] = field(default_factory=dict)
    allow_fmu: bool | None = None

    def error(self, key: files.Key, message: str) -> UserError:
        """The error for a mistake at `key`, in the file of a machine or scenario where that is what holds it."""
        if key[:2] in self.sources:
            return files.at(*self.sources[key[:2]], key[2:], message)
        return files.at(self.path, self.text, key, message)

    def section(self, table: type[T]) -> T | None:
        """The table of a question of its own, such as [tune], by its class; None where the study has none."""
        return next((value for _, value in self.file if isinstance(value, table)), None)

    def with_section(self, name: str, table: Strict) -> "Study":
        """The study with another such table of that name."""
        return replace(self, file=self.file.model_copy(update={name: table}))

    @property
    def computed(self) -> str:
        """What the study computes, as JSON: all but its report, and the tables of other questions. Tables may stand in
        any order but cases and axes, which number the rows and columns of the results.
        """
        others = {*type(self.file).model_fields} - {*StudyFile.model_fields}
        content: dict[str, Any] = self.file.model_dump(exclude=REPORTED | others)
        parts = {name: case["axes"] for name, case in self.file.cases.items() if isinstance(case.get("axes"), dict)}
        axes_of_parts = {name: [*axes] for name, axes in parts.items()}
        content["order"] = {"axes": [*self.file.axes], "cases": [*self.file.cases], "axes of cases": axes_of_parts}
        return json.dumps(content, sort_keys=True, default=str)

    @property
    def fingerprint(self) -> str:
        """A hash of what it computes."""
        return hashlib.sha256(self.computed.encode()).hexdigest()


@dataclass(frozen=True)
class Case:
    """One point of a study, before anything is built: `tables` is what the file says there.

    `axes` are its columns in the results; `declared` is the plant table of its machine, without what scenario and axes
    changed: what a controller may believe. `overrides` go before the tables. Plain data, so that it can travel to
    another process. `tells_solver_error` is false on all draws but the first: what the integration adds is the loop's
    own, and costs more than the run.
    """

    index: int
    name: str | None
    axes: Mapping[str, Any]
    tables: dict[str, Any]
    declared: dict[str, Any]
    folder: Path
    overrides: Overrides = DECLARED
    tells_solver_error: bool = True

    @property
    def columns(self) -> dict[str, object]:
        """The columns that tell this case from the others."""
        return {**({CASE: self.name} if self.name is not None else {}), **self.axes}

    @property
    def rpm(self) -> float:
        """The speed of rotation that the case asks for (rpm), in whole millionths."""
        return rpm_of(self.tables)

    @property
    def label(self) -> str:
        """The case in words."""
        return in_full(self.columns)


def in_full(columns: Mapping[str, object]) -> str:
    """What tells a case from the others, in words."""
    return ", ".join(f"{name} {value}" for name, value in columns.items()) or "the only case"


def rpm_of(tables: Mapping[str, object]) -> float:
    """The speed of rotation (rpm) that the tables of a case ask for, in whole millionths."""
    return round(rpm_si(tables.get("rpm", 0.0)) * 30.0 / math.pi, 6)


def named(case: Case, kind: str) -> str:
    """The name of a case's "controller" or "reference": what an axis says, else the only one; "" if there is none."""
    return case.tables.get(kind) or next(iter(case.tables[f"{kind}s"]), "")


def axes_key(study: Study, case: str | None) -> files.Key:
    """Where the axes of a case stand: with the case if it has its own."""
    return ("cases", case, "axes") if case and "axes" in study.file.cases[case] else ("axes",)


def located(study: Study, case: Case, key: files.Key, message: str) -> UserError:
    """The mistake where the user wrote it: on an axis, in scenario or machine, in the case, or in the study itself."""
    for axis in case.axes:
        parts = tuple(axis.split("."))
        if parts == tuple(map(str, key[: len(parts)])):
            return study.error((*axes_key(study, case.name), axis, *key[len(parts) :]), message)
    layers: list[tuple[files.Key, object]] = [((), study.file.model_dump(include=set(OVERRIDES)))]
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


def _depth(table: object, key: files.Key) -> int:
    """How many parts of `key` lead into `table`."""
    for depth, part in enumerate(key):
        if isinstance(table, list) and isinstance(part, int) and part < len(table):
            table = table[part]
        elif isinstance(table, dict) and part in table:
            table = table[str(part)]
        else:
            return depth
    return len(key)


def check_name(study: Study, key: files.Key, what: str, name: str, valid: Iterable[str]) -> None:
    """Raise UserError where `name` is none of the `valid` names of that kind."""
    names = list(valid)
    if name in names:
        return
    if what in ("controller", "reference") and name in getattr(study.file, f"{what}s"):
        raise study.error(key, f'no case has the {what} "{name}"; put it on an axis, or leave it out')
    broken = METRICS.broken().values() if what in ("column", "figure") else ()
    raise study.error(key, f'unknown {what} "{shortened(name)}"; {nearest(name, names, broken)}')
