"""Tuning all controllers of a study: which they are, the goal that they share, classic tunings beside them."""

import json
import os
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from plants.equation import source_hash
from workbench.errors import UserError, nearest
from workbench.study.resolve import resolve
from workbench.study.runner import PROGRAM_FOLDERS
from workbench.study.study import Case, Study
from workbench.study.unfold import unfold
from workbench.tune.classic import StartingPoint
from workbench.tune.evaluator import Bench
from workbench.tune.objective import Goal, Score, run
from workbench.tune.schema import TuneTable
from workbench.tune.search import Search
from workbench.tune.task import Task, cases_for, task_for, tasks_for, tune_table
from workbench.tune.trials import Trial, TrialStore, trials_in
from workbench.tune.tuning import Tuned, classic_points, concluded, has_pid_gains, starts_of

PD = "pd"
"""What a PD that is added is called."""

PLACED = "pole_placement"
"""What the names of classic tunings by their poles begin with."""


def identity_of(study: Study, table: TuneTable, names: Sequence[str]) -> str:
    """What stored trials of these controllers must agree in: the study but for controllers that do not matter, [tune]
    without the number of trials and of seeds, draws, code.
    """
    uncertainty, controllers = study.file.uncertainty, study.file.controllers
    own = {name: controllers[name] for name in (*names, yardstick_of(study, table))}
    bare = replace(study, file=study.file.model_copy(update={"controllers": own}))
    return json.dumps(
        {
            "study": bare.fingerprint,
            "tune": table.model_dump(mode="json", exclude={"trials", "seed", "seeds", "fresh_draws"}),
            "uncertainty": None if uncertainty is None else uncertainty.model_dump(mode="json"),
            "program": source_hash((*PROGRAM_FOLDERS, "workbench/tune")),
        },
        sort_keys=True,
    )


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


def goal_of(study: Study, cases: Sequence[Case], at: Mapping[str, object]) -> Goal:
    """The goal of a study at one combination of its axes, in units of its yardstick there.

    Raises:
        UserError: no such yardstick, or a figure that it does not have.
    """
    table = tune_table(study)
    name = yardstick_of(study, table)
    columns = tuple(table.objective.used)
    return Goal(table, [run(resolve(study, case), columns) for case in cases_for(study, cases, name, at)])


def bench_of(task: Task) -> Bench:
    """The bench of one task."""
    return Bench(task, goal_of(task.study, unfold(task.study), task.at))


@dataclass(frozen=True)
class Classic:
    """A classic tuning, and its score by the same goal."""

    point: StartingPoint
    score: Score


def classics(study: Study, goal: Goal) -> list[Classic]:
    """The classic tunings of a PID for a study's plant, judged as all others are on the declared machine; none of a
    study that tunes for several machines or speeds.
    """
    if goal.table.per:
        return []
    names = list(study.file.controllers)
    bare = task_for(study, names[0], tuned=False)
    points = [point for point in classic_points(bare, {}) if point.settings]
    tables = {point.name: {"type": point.controller, **point.settings} for point in points}
    controllers = {**study.file.controllers, **tables}
    with_them = replace(study, file=study.file.model_copy(update={"controllers": controllers}))
    judged = [Bench(task_for(with_them, point.name, tuned=False), goal).declared({}) for point in points]
    return [Classic(point, score) for point, score in zip(points, judged, strict=True)]


def prepared(study: Study, wanted: Sequence[str], trials: int | None) -> tuple[Study, list[str]]:
    """A study ready to be tuned, and the controllers that are: of "all" a PD is always one.

    Raises:
        UserError: no [tune], no such controller, or a mistake in what is asked of one of them.
    """
    table = tune_table(study)
    if trials is not None:
        table = table.model_copy(update={"trials": trials})
    study = replace(study, file=study.file.model_copy(update={"tune": table}))
    own = list(study.file.controllers)
    if {"all", PD} & set(wanted) and not any(_is_pd(study.file.controllers[one]) for one in own):
        study = _with_pd(study)
    names = chosen(study, wanted)
    yardstick_of(study, table)
    known = study.file.controllers
    for one in table.gains:
        if one not in known:
            raise study.error(("tune", "gains", one), f'unknown controller "{one}"; {nearest(one, known)}')
    tasks_for(study, names)
    return study, names


def tasks_of(study: Study) -> list[Task]:
    """What tuning all controllers of a study would tune.

    Raises:
        UserError: as `prepared`.
    """
    return tasks_for(*prepared(study, ["all"], None))


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
    """Tune these controllers of a `prepared` study, at every combination that it asks for, `jobs` searches at a time.

    Raises:
        UserError: trials of another study in the database, or a yardstick that does not serve.
    """
    tasks, cases = tasks_for(study, names), unfold(study)
    goals = {repr(task.at): task.at for task in tasks}
    goal_at = {key: goal_of(study, cases, at) for key, at in goals.items()}
    benches = [Bench(task, goal_at[repr(task.at)]) for task in tasks]
    with trials_in(database) as store, ThreadPoolExecutor(jobs or os.cpu_count() or 1) as executor:
        work = _Work(store, tune_table(study), len(tasks), tell)
        try:
            pids = {repr(task.at): task for task in reversed(tasks) if has_pid_gains(task)}
            points = list(executor.map(lambda task: classic_points(task, task.start), pids.values()))
            classic = dict(zip(pids, points, strict=True))
            starts = [starts_of(task, classic.get(repr(task.at), ())) for task in tasks]
            seeds = range(work.table.seed, work.table.seed + work.table.seeds)
            units = [(bench, own, seed) for bench, own in zip(benches, starts, strict=True) for seed in seeds]
            searches = list(executor.map(lambda unit: work.search(*unit), units))
            each = len(seeds)
            by_task = [dict(zip(seeds, searches[i : i + each], strict=True)) for i in range(0, len(units), each)]
            found = list(executor.map(concluded, benches, by_task))
        except BaseException:
            work.stopped.set()
            executor.shutdown(wait=True, cancel_futures=True)
            raise
    return Tuning(study, found, classics(study, next(iter(goal_at.values()))))


class _StoppedError(Exception):
    """The tuning is being stopped."""


class _Work:
    """What the searches of a tuning share: where trials go, how far all are, and whether they are to stop."""

    def __init__(self, store: TrialStore, table: TuneTable, tasks: int, tell: Callable[[str, float], None]) -> None:
        self.table = table
        self.stopped = threading.Event()
        self._store, self._say = store, tell
        self._whole, self._done, self._lock = tasks * table.seeds * table.trials, 0, threading.Lock()

    def search(self, bench: Bench, starts: Sequence[Mapping[str, float]], seed: int) -> list[Trial]:
        """One search, whose trials are kept under its name."""
        task = bench.task
        name = f"{task.label}, seed {seed}"
        identity = identity_of(task.study, self.table, [task.name])
        known = self._store.known(name, identity)
        return Search(bench, seed, known, partial(self._store.keep, name), lambda: self._told(task.label)).run(starts)

    def _told(self, label: str) -> None:
        if self.stopped.is_set():
            raise _StoppedError
        with self._lock:
            self._done += 1
            self._say(label, min(self._done / self._whole, 1.0))
