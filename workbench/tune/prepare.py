"""A study made ready to be tuned: its controllers, of each the cases that count, and what is tuned of it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from workbench.errors import UserError, nearest
from workbench.study.fmu_plant import refuse_fmu
from workbench.study.names import in_words, matches
from workbench.study.overrides import Overrides
from workbench.study.resolve import parse_case
from workbench.study.study import Case, Study, named
from workbench.study.uncertainty import check_scales, plant_sample
from workbench.study.uncertainty_schema import UncertaintyTable
from workbench.study.unfold import unfold
from workbench.toml.quantities import check_along
from workbench.toml.reading import SchemaError
from workbench.tune.schema import reference_controller, tune_table
from workbench.tune.space import Dimension, rotation_of, space_of
from workbench.tune.starts import classic_points
from workbench.tune.task import Task, overrides_at

PD = "pd"
"""What a PD that is added is called."""

PLACED = "pole_placement"
"""What the names of classic tunings by their poles begin with."""


def combinations(study: Study, cases: Sequence[Case]) -> list[dict[str, object]]:
    """The combinations of values on the axes that [tune] per names, in order; one that is empty where it names none.

    Raises:
        UserError: an axis that the study does not have.
    """
    table, places = tune_table(study), dict[str, dict[str, object]]()
    for case in cases:
        columns = case.columns
        for axis in table.per:
            if axis not in columns:
                raise study.error(("tune", "per"), f'the study has no axis "{axis}"; give it one under [axes]')
        if matches({key: value for key, value in columns.items() if key != "controller"}, table.where):
            place: dict[str, object] = {axis: columns[axis] for axis in table.per}
            places.setdefault(repr(place), place)
    return list(places.values()) or [{}]


def cases_for(study: Study, cases: Sequence[Case], name: str, at: Mapping[str, object]) -> list[Case]:
    """The cases on which a controller is tuned: those that `where` and `at` choose, each once, with this controller.

    Raises:
        UserError: there is none.
    """
    selected: dict[str, Case] = {}
    where = {**tune_table(study).where, **at}
    for case in cases:
        columns = {key: value for key, value in case.columns.items() if key != "controller"}
        if matches(columns, where) and name in case.tables["controllers"]:
            tables = {**case.tables, "controller": name}
            selected.setdefault(repr(columns), replace(case, axes=columns, tables=tables))
    if not selected:
        raise UserError(
            f"{study.path}: [tune] where: no case of {name} has {in_words(where) or 'any'}; expected values of "
            "the study's axes"
        )
    return list(selected.values())


def tasks_for(study: Study, names: Sequence[str]) -> list[Task]:
    """The tasks of tuning these controllers, each for the combinations that [tune] per asks for where the study has a
    case with it; for all of them where it has none.

    Raises:
        UserError: as `task_for`.
    """
    cases = [*unfold(study)]  # each is looked at for each task
    own = {name: [case for case in cases if named(case, "controller") == name] or cases for name in names}
    return [_task(study, cases, name, at) for name in names for at in combinations(study, own[name])]


def task_for(study: Study, name: str, *, tuned: bool = True) -> Task:
    """The first task of tuning the controller `name` of a study; not `tuned`: as it stands there.

    Raises:
        UserError: the study has no [tune], no such controller, or limits of it are wrong.
    """
    cases = unfold(study)
    return _task(study, cases, name, combinations(study, cases)[0], tuned=tuned)


def _task(study: Study, all_cases: Sequence[Case], name: str, at: Mapping[str, object], *, tuned: bool = True) -> Task:
    table = tune_table(study)
    chosen = cases_for(study, all_cases, name, at)
    cases = [parse_case(study, case) for case in chosen]
    first = cases[0].resolve()
    settings, controller = first.settings, first.setup.loop.controller
    try:
        check_along(table, first.setup.plant.axis, ("tune",))
        dimensions = list[Dimension]()
        if tuned:
            dimensions += space_of(name, controller, settings, table, first.setup.plant)
            dimensions += rotation_of(table, chosen[0].rpm, cases[0].tables.plant.minimum_helical_speed)
        uncertainty = study.file.uncertainty or UncertaintyTable()
        task = Task(study, name, controller, settings, cases, dimensions, uncertainty, at, first.setup.plant.axis)
        if table.draws and study.file.uncertainty is None:
            raise SchemaError(("tune", "draws"), "needs [uncertainty], which says what machines may be met")
        if table.draws:
            check_scales(study, chosen)
            cases[0].resolve(Overrides(sample=plant_sample(uncertainty, 0, axis=task.axis)))
        if table.rotation is not None and tuned:
            cases[0].resolve(overrides_at(task.start))
        if table.rotation is not None and table.rotation.rpm is not None and len({case.rpm for case in chosen}) > 1:
            raise SchemaError(("tune", "rotation", "rpm"), "is tuned: expected one value on the axis rpm, its start")
    except SchemaError as mistake:
        raise study.error(mistake.key, mistake.message) from None
    return task


def chosen(study: Study, wanted: Sequence[str]) -> list[str]:
    """The controllers that names stand for, each once: themselves, or "all".

    Raises:
        UserError: there is none of a name.
    """
    known = list(study.file.controllers)
    for name in wanted:
        if name != "all" and name not in known:
            raise UserError(f'--controller "{name}": {nearest(name, ["all", *known])}')
    return known if "all" in wanted else list(dict.fromkeys(wanted))


def prepared(study: Study, wanted: Sequence[str], trials: int | None) -> tuple[Study, list[str]]:
    """A study ready to be tuned, and the controllers that are: of "all" a PD is always one.

    Raises:
        UserError: no [tune], no such controller, or a mistake in what is asked of one of them.
    """
    study, names, _ = _prepared(study, wanted, trials)
    return study, names


def tasks_of(study: Study) -> list[Task]:
    """What tuning all controllers of a study would tune.

    Raises:
        UserError: as `prepared`.
    """
    _, _, tasks = _prepared(study, ["all"], None)
    return tasks


def _prepared(study: Study, wanted: Sequence[str], trials: int | None) -> tuple[Study, list[str], list[Task]]:
    table = tune_table(study)
    refuse_fmu(study, "tune")
    if trials is not None and trials < 1:
        raise UserError(f"trials: got {trials}, expected 1 or more")
    if trials is not None:
        table = table.model_copy(update={"trials": trials})
    study = study.with_section("tune", table)
    if {"all", PD} & set(wanted) and not any(map(_is_pd, study.file.controllers.values())):
        study = _with_pd(study)
    names = chosen(study, wanted)
    reference_controller(study)
    known = study.file.controllers
    for name in table.gains:
        if name not in known:
            raise study.error(("tune", "gains", name), f'unknown controller "{name}"; {nearest(name, known)}')
    return study, names, tasks_for(study, names)


def _is_pd(table: Mapping[str, object]) -> bool:
    return table.get("type") == "pid" and bool(table.get("kd")) and not table.get("ki")


def _with_pd(study: Study) -> Study:
    """The study with a PD controller, placed by its poles, beside the others."""
    plain = task_for(study, next(iter(study.file.controllers)))
    points = [point for point in classic_points(plain, plain.start) if point.name.startswith(PLACED)]
    placed = [{"type": point.controller, **point.settings} for point in points]
    table = next(filter(_is_pd, placed), None)
    if table is None:
        raise UserError(
            f"{study.path}: no PD is among the controllers, and none could be placed for this plant; give one a kp and "
            'a kd, such as pd = { type = "pid", kp = "500 V/m", kd = "2 V s/m" }'
        )
    controllers = {**study.file.controllers, PD: table}
    return replace(study, file=study.file.model_copy(update={"controllers": controllers}))
