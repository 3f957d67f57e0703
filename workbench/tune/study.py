"""Tuning all controllers of a study: which they are, the goal that they share, classic tunings beside them."""

import json
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

from plants.equation import source_hash
from workbench.errors import UserError, nearest
from workbench.study.document import Study
from workbench.study.resolve import resolve
from workbench.study.runner import PROGRAM_FOLDERS
from workbench.study.tune_schema import TuneTable
from workbench.tune.bench import Bench
from workbench.tune.classic import StartingPoint
from workbench.tune.goal import Goal, Score, run
from workbench.tune.task import Task, cases_for, task_for, tune_table
from workbench.tune.tuning import Tuned, classic_points, tune

PD = "pd"
"""What a PD that is added is called."""

PLACED = "pole_placement"
"""What the names of classic tunings by their poles begin with."""


def identity_of(study: Study, table: TuneTable, names: Sequence[str]) -> str:
    """What stored trials of these controllers must agree in: the study but for controllers that do not matter, [tune]
    without the number of trials, draws, code.
    """
    uncertainty, controllers = study.file.uncertainty, study.file.controllers
    own = {name: controllers[name] for name in (*names, yardstick_of(study, table))}
    bare = replace(study, file=study.file.model_copy(update={"controllers": own}))
    return json.dumps(
        {
            "study": bare.fingerprint,
            "tune": table.model_dump(mode="json", exclude={"trials", "fresh_draws", "polish"}),
            "uncertainty": None if uncertainty is None else uncertainty.model_dump(mode="json"),
            "program": source_hash((*PROGRAM_FOLDERS, "workbench/tune")),
        },
        sort_keys=True,
    )


def chosen(study: Study, name: str) -> list[str]:
    """The controllers that a name stands for: one, or all.

    Raises:
        UserError: there is none of that name.
    """
    known = list(study.file.controllers)
    if name == "all":
        return known
    if name not in known:
        raise UserError(f'--controller "{name}": {nearest(name, ["all", *known])}')
    return [name]


def yardstick_of(study: Study, table: TuneTable) -> str:
    """The name of the yardstick.

    Raises:
        UserError: no such controller.
    """
    known = study.file.controllers
    name = table.yardstick or next(iter(known))
    if name not in known:
        raise study.error(("tune", "yardstick"), f'unknown controller "{name}"; {nearest(name, known)}')
    return name


def goal_of(study: Study, executor: Executor) -> Goal:
    """The goal of a study, in units of its yardstick.

    Raises:
        UserError: no such yardstick, or a figure that it does not have.
    """
    table = tune_table(study)
    name = yardstick_of(study, table)
    cases = [resolve(study, case) for case in cases_for(study, table, name)]
    columns = tuple(table.objective.used)
    return Goal(table, list(executor.map(lambda case: run(case, columns), cases)))


@dataclass(frozen=True)
class Classic:
    """A classic tuning, and its score by the same goal."""

    point: StartingPoint
    score: Score


def classics(study: Study, goal: Goal, executor: Executor) -> list[Classic]:
    """The classic tunings of a PID for a study's plant, judged as all others are on the declared machine."""
    names = list(study.file.controllers)
    bare = task_for(study, names[0], tuned=False)
    points = [point for point in classic_points(bare, {}) if point.settings]
    tables = {point.name: {"type": point.controller, **point.settings} for point in points}
    controllers = {**study.file.controllers, **tables}
    with_them = replace(study, file=study.file.model_copy(update={"controllers": controllers}))
    judged = [Bench(task_for(with_them, point.name, tuned=False), goal, executor).declared({}) for point in points]
    return [Classic(point, score) for point, score in zip(points, judged, strict=True)]


def prepared(study: Study, name: str, trials: int | None) -> tuple[Study, list[str]]:
    """A study ready to be tuned, and the controllers that are: a PD is always among all of them.

    Raises:
        UserError: no [tune], no such controller, or a mistake in what is asked of one of them.
    """
    table = tune_table(study)
    if trials is not None:
        table = table.model_copy(update={"trials": trials})
    study = replace(study, file=study.file.model_copy(update={"tune": table}))
    own = list(study.file.controllers)
    if name in ("all", PD) and not any(_is_pd(study.file.controllers[one]) for one in own):
        study = _with_pd(study)
    names = chosen(study, name)
    yardstick_of(study, table)
    known = study.file.controllers
    for one in table.gains:
        if one not in known:
            raise study.error(("tune", "gains", one), f'unknown controller "{one}"; {nearest(one, known)}')
    for one in names:
        task_for(study, one)
    return study, names


def tasks_of(study: Study) -> list[Task]:
    """What tuning all controllers of a study would tune.

    Raises:
        UserError: as `prepared`.
    """
    ready, names = prepared(study, "all", None)
    return [task_for(ready, name) for name in names]


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


@dataclass(frozen=True, eq=False)
class Tuning:
    """What became of all controllers, and classic tunings of a PID beside them."""

    study: Study
    found: Sequence[Tuned]
    classics: Sequence[Classic]


def tune_all(
    study: Study,
    names: Sequence[str],
    database: Path,
    jobs: int | None = None,
    tell: Callable[[str, float], None] = lambda said, done: None,
) -> Tuning:
    """Tune these controllers of a `prepared` study, one after another.

    Raises:
        UserError: trials of another study in the database, or a yardstick that does not serve.
    """
    with ThreadPoolExecutor(jobs or os.cpu_count() or 1) as executor:
        goal = goal_of(study, executor)
        found = list[Tuned]()
        for name in names:

            def told(said: str, done: int, of: int) -> None:
                tell(said, (len(found) + done / of) / len(names))

            identity = identity_of(study, goal.table, [name])
            found.append(tune(Bench(task_for(study, name), goal, executor), database, identity, told))
        return Tuning(study, found, classics(study, goal, executor))
