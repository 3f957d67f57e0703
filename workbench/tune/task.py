"""From a point of what is tuned to everything that its runs depend on."""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import pi
from typing import Any

from controllers.interface import Controller
from controllers.settings import settings_of
from workbench.errors import UserError
from workbench.study.names import in_words, matches
from workbench.study.overrides import Overrides
from workbench.study.resolve import ParsedCase, Resolved, parse_case
from workbench.study.study import Case, Study, named
from workbench.study.uncertainty import check_scales, plant_sample
from workbench.study.uncertainty_schema import UncertaintyTable
from workbench.study.unfold import unfold
from workbench.toml.reading import SchemaError
from workbench.tune.schema import TuneTable
from workbench.tune.space import RPM, THRESHOLD, Dimension, Point, rotation_of, space_of

SAMPLES = 4096
"""Plant samples that are kept resolved."""


@dataclass(frozen=True, eq=False)
class Task:
    """One controller of a study, to be tuned: its cases on the declared machine, and what is tuned.

    `settings` are those that the study gives it. `at` are the values of the axes that [tune] per names: each
    combination of them has a task of its own.
    """

    study: Study
    name: str
    controller: Controller
    settings: Any
    cases: Sequence[ParsedCase]
    dimensions: Sequence[Dimension]
    uncertainty: UncertaintyTable
    at: Mapping[str, Any] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """The task in words: the controller, and where it is tuned."""
        return ", ".join([self.name, *(f"{axis} {value}" for axis, value in self.at.items())])

    @property
    def rpm(self) -> float | None:
        """The speed of rotation (rpm) for which it is tuned; None where it is tuned for all of them."""
        return self.cases[0].case.rpm if RPM in self.at else None

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

    def sampled(self, point: Point, number: int, stream: int = 0) -> list[Resolved]:
        """The cases at a point, on the plant sample of that number."""
        rotation = tuple((name, point[name]) for name in (RPM, THRESHOLD) if name in point)
        samples = _samples(self, rotation, number, stream)
        loops = [case.setup.loop for case in self.declared(point)]
        return [
            replace(sample, setup=replace(sample.setup, loop=loop)) for sample, loop in zip(samples, loops, strict=True)
        ]


@functools.lru_cache(maxsize=64)
def _at(task: Task, point: tuple[tuple[str, float], ...]) -> list[Resolved]:
    overrides = overrides_at(dict(point))
    return [case.resolve(overrides) for case in task.cases]


@functools.lru_cache(maxsize=SAMPLES)
def _samples(task: Task, rotation: tuple[tuple[str, float], ...], number: int, stream: int) -> list[Resolved]:
    """The cases of a task on a plant sample, with the gains of the study."""
    sample = plant_sample(task.uncertainty, number, stream)
    overrides = replace(overrides_at(dict(rotation)), sample=sample)
    return [case.resolve(overrides) for case in task.cases]


def overrides_at(point: Point) -> Overrides:
    """What a point changes of a case."""
    settings = {name: value for name, value in point.items() if name not in (RPM, THRESHOLD)}
    rpm = point[RPM] * 30.0 / pi if RPM in point else None
    return Overrides(settings, rpm, point.get(THRESHOLD))


def combinations(study: Study, cases: Sequence[Case]) -> list[dict[str, Any]]:
    """The combinations of values on the axes that [tune] per names, in order; one that is empty where it names none.

    Raises:
        UserError: an axis that the study does not have.
    """
    table, found = tune_table(study), dict[str, dict[str, Any]]()
    for case in cases:
        columns = case.columns
        for axis in table.per:
            if axis not in columns:
                raise study.error(("tune", "per"), f'the study has no axis "{axis}"; give it one under [axes]')
        if matches({key: value for key, value in columns.items() if key != "controller"}, table.where):
            chosen: dict[str, Any] = {axis: columns[axis] for axis in table.per}
            found.setdefault(repr(chosen), chosen)
    return list(found.values()) or [{}]


def cases_for(study: Study, cases: Sequence[Case], name: str, at: Mapping[str, Any]) -> list[Case]:
    """The cases on which a controller is tuned: those that `where` and `at` choose, each once, with this controller.

    Raises:
        UserError: there is none.
    """
    found: dict[str, Case] = {}
    where = {**tune_table(study).where, **at}
    for case in cases:
        columns = {key: value for key, value in case.columns.items() if key != "controller"}
        if matches(columns, where) and name in case.tables["controllers"]:
            tables = {**case.tables, "controller": name}
            found.setdefault(repr(columns), replace(case, axes=columns, tables=tables))
    if not found:
        raise UserError(
            f"{study.path}: [tune] where: no case of {name} has {in_words(where) or 'any'}; expected values of "
            "the study's axes"
        )
    return list(found.values())


def tasks_for(study: Study, names: Sequence[str]) -> list[Task]:
    """The tasks of tuning these controllers, each for the combinations that [tune] per asks for where the study has a
    case with it; for all of them where it has none.

    Raises:
        UserError: as `task_for`.
    """
    cases = unfold(study)
    own = {name: [case for case in cases if named(case, "controller") == name] or cases for name in names}
    return [_task(study, cases, name, at) for name in names for at in combinations(study, own[name])]


def task_for(study: Study, name: str, *, tuned: bool = True) -> Task:
    """The first task of tuning the controller `name` of a study; not `tuned`: as it stands there.

    Raises:
        UserError: the study has no [tune], no such controller, or limits of it are wrong.
    """
    cases = unfold(study)
    return _task(study, cases, name, combinations(study, cases)[0], tuned=tuned)


def _task(study: Study, all_cases: Sequence[Case], name: str, at: Mapping[str, Any], *, tuned: bool = True) -> Task:
    table = tune_table(study)
    chosen = cases_for(study, all_cases, name, at)
    cases = [parse_case(study, case) for case in chosen]
    first = cases[0].resolve()
    settings, controller = first.settings, first.setup.loop.controller
    try:
        dimensions = list[Dimension]()
        if tuned:
            dimensions += space_of(name, controller, settings, table, first.setup.plant.command_unit)
            dimensions += rotation_of(table, chosen[0].rpm, cases[0].tables.plant.minimum_helical_speed)
        uncertainty = study.file.uncertainty or UncertaintyTable()
        task = Task(study, name, controller, settings, cases, dimensions, uncertainty, at)
        if table.draws and study.file.uncertainty is None:
            raise SchemaError(("tune", "draws"), "needs [uncertainty], which says what machines may be met")
        if table.draws:
            check_scales(study, chosen)
            cases[0].resolve(Overrides(sample=plant_sample(uncertainty, 0)))
        if table.rotation is not None and table.rotation.rpm is not None and len({case.rpm for case in chosen}) > 1:
            raise SchemaError(("tune", "rotation", "rpm"), "is tuned: expected one value on the axis rpm, its start")
    except SchemaError as mistake:
        raise study.error(mistake.key, mistake.message) from None
    return task


def tune_table(study: Study) -> TuneTable:
    """The [tune] of a study.

    Raises:
        UserError: it has none.
    """
    table = study.section(TuneTable)
    if table is None:
        raise UserError(
            f"{study.path}: has no [tune]; expected at least [tune.objective] with a weight, such as rms_error = 1"
        )
    return table


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
