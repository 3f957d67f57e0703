"""From a point of what is tuned to everything that its runs depend on."""

import copy
import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any

from controllers.interface import Controller
from controllers.registry import CONTROLLERS
from controllers.settings import settings_of
from workbench.errors import UserError
from workbench.files import SchemaError
from workbench.study.document import Case, Study, unfold
from workbench.study.names import in_words, matches
from workbench.study.resolve import Resolved, resolve
from workbench.study.tune_schema import TuneTable, UncertaintyTable
from workbench.study.uncertainty import check_scales, drawn_case
from workbench.tune.space import RPM, THRESHOLD, Dimension, Point, rotation_of, space_of

MACHINES = 4096
"""Drawn machines that are kept resolved."""


@dataclass(frozen=True, eq=False)
class Task:
    """One controller of a study, to be tuned: its cases on the declared machine, and what is tuned.

    `settings` are those that the study gives it.
    """

    study: Study
    name: str
    controller: Controller
    settings: Any
    cases: Sequence[Case]
    dimensions: Sequence[Dimension]
    uncertainty: UncertaintyTable

    @property
    def rotates(self) -> bool:
        """Whether the rotation is tuned too."""
        return any(one.name in (RPM, THRESHOLD) for one in self.dimensions)

    @property
    def start(self) -> dict[str, float]:
        """The study's own point; nearest to it within the limits."""
        return {one.name: min(max(one.start, one.low), one.high) for one in self.dimensions}

    def settings_at(self, point: Point) -> Any:
        """The controller's settings at a point."""
        return self.settings._replace(**{name: value for name, value in point.items() if name not in (RPM, THRESHOLD)})

    def declared(self, point: Point) -> list[Resolved]:
        """The cases at a point, on the declared machine."""
        return _at(self, tuple(sorted(point.items())))

    def drawn(self, point: Point, number: int, stream: int = 0) -> list[Resolved]:
        """The cases at a point, on the machine of a draw."""
        rotation = tuple((name, point[name]) for name in (RPM, THRESHOLD) if name in point)
        machines = _machine(self, rotation, number, stream)
        loops = [case.setup.loop for case in self.declared(point)]
        return [
            replace(machine, setup=replace(machine.setup, loop=loop))
            for machine, loop in zip(machines, loops, strict=True)
        ]


@functools.lru_cache(maxsize=64)
def _at(task: Task, point: tuple[tuple[str, float], ...]) -> list[Resolved]:
    return [resolve(task.study, _moved(task, case, dict(point))) for case in task.cases]


@functools.lru_cache(maxsize=MACHINES)
def _machine(task: Task, rotation: tuple[tuple[str, float], ...], number: int, stream: int) -> list[Resolved]:
    """The cases of a task on a drawn machine, with the gains of the study."""
    moved = [_moved(task, case, dict(rotation)) for case in task.cases]
    return [resolve(task.study, drawn_case(case, task.uncertainty, number, stream)) for case in moved]


def _moved(task: Task, case: Case, point: Point) -> Case:
    """A case at a point: settings and rotation as numbers in SI."""
    tables = copy.deepcopy(case.tables)
    own = tables["controllers"][task.name]
    for name, value in point.items():
        if name == RPM:
            tables["rpm"] = value * 30.0 / pi
        elif name == THRESHOLD:
            tables["plant"][THRESHOLD] = value
        else:
            own[name] = value
    return replace(case, tables=tables)


def cases_for(study: Study, table: TuneTable, name: str) -> list[Case]:
    """The cases on which a controller is tuned: those that `where` chooses, each once, with this controller.

    Raises:
        UserError: there is none.
    """
    found: dict[str, Case] = {}
    for case in unfold(study):
        columns = {key: value for key, value in case.columns.items() if key != "controller"}
        if matches(columns, table.where) and name in case.tables["controllers"]:
            tables = {**case.tables, "controller": name}
            found.setdefault(repr(columns), replace(case, axes=columns, tables=tables))
    if not found:
        raise UserError(
            f"{study.path}: [tune] where: no case of {name} has {in_words(table.where) or 'any'}; expected values of "
            "the study's axes"
        )
    return list(found.values())


def task_for(study: Study, name: str, *, tuned: bool = True) -> Task:
    """The task of tuning the controller `name` of a study; not `tuned`: as it stands there.

    Raises:
        UserError: the study has no [tune], no such controller, or limits of it are wrong.
    """
    table = tune_table(study)
    cases = cases_for(study, table, name)
    first = resolve(study, cases[0])
    settings = first.settings
    own = cases[0].tables["controllers"][name]
    controller = CONTROLLERS.working()[str(own["type"])]
    if controller.choose is not None:
        controller = first.setup.loop.controller
    try:
        dimensions = list[Dimension]()
        if tuned:
            dimensions += space_of(name, controller, settings, table, first.setup.plant.command_unit)
            dimensions += rotation_of(table, cases[0].rpm, cases[0].tables["plant"].get(THRESHOLD))
        uncertainty = study.file.uncertainty or UncertaintyTable()
        task = Task(study, name, controller, settings, cases, dimensions, uncertainty)
        if table.draws and study.file.uncertainty is None:
            raise SchemaError(("tune", "draws"), "needs [uncertainty], which says what machines may be met")
        if table.draws:
            check_scales(study)
            resolve(study, drawn_case(cases[0], uncertainty, 0))
        if table.rotation is not None and table.rotation.rpm is not None and len({case.rpm for case in cases}) > 1:
            raise SchemaError(("tune", "rotation", "rpm"), "is tuned: expected one value on the axis rpm, its start")
    except SchemaError as mistake:
        raise study.error(mistake.key, mistake.message) from None
    return task


def tune_table(study: Study) -> TuneTable:
    """The [tune] of a study.

    Raises:
        UserError: it has none.
    """
    if study.file.tune is None:
        raise UserError(
            f"{study.path}: has no [tune]; expected at least [tune.objective] with a weight, such as rms_error = 1"
        )
    return study.file.tune


def in_user_units(task: Task, point: Point) -> Mapping[str, float | str]:
    """A point as a study writes it: numbers with units."""
    written: dict[str, float | str] = {}
    declared = settings_of(task.controller.Settings)
    for one in task.dimensions:
        value = point[one.name]
        if one.name == RPM:
            written[one.name] = f"{value * 30.0 / pi:.12g} rpm"
        elif one.name in declared and declared[one.name].unit == "1":
            written[one.name] = float(f"{value:.12g}")
        else:
            written[one.name] = f"{value:.12g} {one.unit}"
    return written
