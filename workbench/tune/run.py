"""Tuning all controllers of a study: searches side by side, and what they found measured again."""

import math
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from workbench.parallel.workers import workers
from workbench.progress import Progress, silent
from workbench.study.resolve import parse_case
from workbench.study.study import Study
from workbench.study.unfold import unfold
from workbench.tune.classic import StartingPoint
from workbench.tune.evaluator import FRESH, SEARCHED, Evaluator, evaluators_of
from workbench.tune.objective import Objective
from workbench.tune.prepare import cases_for, task_for
from workbench.tune.remote import on_cluster
from workbench.tune.result import ClassicTuning, ControllerTuning, Quantile, Tuning, interval
from workbench.tune.schema import TuneTable, reference_controller, tune_table
from workbench.tune.search import Search
from workbench.tune.space import Point
from workbench.tune.starts import classic_points, has_pid_gains, starts_of
from workbench.tune.task import Task
from workbench.tune.trials import Trial, TrialStore, kept_identity, trials_in

MOST_SEARCHES = 64
"""Searches at a time, at most, whose points a cluster scores: each is led by a thread of this process."""


@dataclass(frozen=True, eq=False)
class _Unit:
    """A search that is to be run."""

    evaluator: Evaluator
    starts: Sequence[Point]
    seed: int
    identity: Mapping[str, object]


def tune_all(
    study: Study,
    names: Sequence[str],
    database: Path,
    jobs: int | None = None,
    progress: Progress = silent,
    cluster: str | None = None,
) -> Tuning:
    """Tune these controllers of a `prepared` study, at every combination that it asks for, `jobs` searches at a time,
    or all at a time where the workers of a `cluster` (the address of a dask scheduler) score their points.

    `progress` is told whose trials are being made, and how far all are.

    Raises:
        UserError: trials of another study in the database, or a reference controller that does not serve.
    """
    table, here = tune_table(study), evaluators_of(study, names)
    identities = _identities(study, [evaluator.task for evaluator in here])
    at_a_time = jobs if cluster is None else min(len(here) * table.seeds, MOST_SEARCHES)
    with (
        trials_in(database) as store,
        on_cluster(here, study, names, cluster) as evaluators,
        workers(at_a_time) as executor,
    ):
        tasks = [evaluator.task for evaluator in evaluators]
        work = _Work(store, table, len(tasks), progress)
        try:
            pids = {repr(task.at): task for task in reversed(tasks) if has_pid_gains(task)}
            points = list(executor.map(lambda task: classic_points(task, task.start), pids.values()))
            classic = dict(zip(pids, points, strict=True))
            units = [
                _Unit(evaluator, starts_of(evaluator.task, classic.get(repr(evaluator.task.at), ())), seed, identity)
                for evaluator, identity in zip(evaluators, identities, strict=True)
                for seed in range(table.seed, table.seed + table.seeds)
            ]
            searches = list(executor.map(work.search, units))
            by_task = [
                {unit.seed: trials for unit, trials in zip(units, searches, strict=True) if unit.evaluator is evaluator}
                for evaluator in evaluators
            ]
            tuned = list(executor.map(conclude, evaluators, by_task))
        except BaseException:
            work.stopped.set()
            raise
        known = classic.get(repr(tasks[0].at))
    return Tuning(study, tuned, classic_tunings(study, here[0].objective, known))


def _identities(study: Study, tasks: Sequence[Task]) -> list[Mapping[str, object]]:
    """What kept trials of each task must agree in."""
    cases, name = unfold(study), reference_controller(study)
    places = {repr(task.at): task.at for task in tasks}
    references = {
        key: [parse_case(study, case) for case in cases_for(study, cases, name, at)] for key, at in places.items()
    }
    return [kept_identity(task, references[repr(task.at)]) for task in tasks]


def conclude(evaluator: Evaluator, searches: Mapping[int, Sequence[Trial]]) -> ControllerTuning:
    """What the searches of all seeds found, measured again."""
    task, table = evaluator.task, evaluator.objective.table
    every = [trial for trials in searches.values() for trial in trials]
    seeds = dict[int, float | None]()
    for seed, trials in searches.items():
        own = best_trial(trials, table.draws)
        seeds[seed] = None if own is None else trials[own].value
    start, number = evaluator.declared(task.start), best_trial(every, table.draws)
    if number is None:
        return ControllerTuning(task, every, start, None, None, -1, seeds, {}, {})
    best = dict(every[number].point)
    score = evaluator.on_draws(best)
    seen, fresh = dict[str, Quantile](), dict[str, Quantile]()
    if table.draws:
        before = evaluator.on_samples(task.start, range(table.draws), SEARCHED)
        seen = {"start": interval(before, table.quantile), "tuned": interval(score.on_samples, table.quantile)}
    if table.draws and table.fresh_draws:
        for key, point in (("start", task.start), ("tuned", best)):
            fresh[key] = interval(evaluator.on_samples(point, range(table.fresh_draws), FRESH), table.quantile)
    return ControllerTuning(task, every, start, best, score, number, seeds, seen, fresh)


def best_trial(trials: Sequence[Trial], draws: int) -> int | None:
    """The number of the best trial that keeps all constraints on so many draws; None where there is none."""
    numbers = [i for i, each in enumerate(trials) if each.draws == draws and each.feasible and each.value < math.inf]
    return min(numbers, key=lambda i: trials[i].value, default=None)


def classic_tunings(
    study: Study, objective: Objective, known: Sequence[StartingPoint] | None = None
) -> list[ClassicTuning]:
    """The classic tunings of a PID for a study's plant, scored as all others are on the declared machine; none of a
    study that tunes for several machines or speeds. `known` are those with which searches have begun.
    """
    if objective.table.per:
        return []
    if known is None:
        known = classic_points(task_for(study, next(iter(study.file.controllers)), tuned=False), {})
    points = [point for point in known if point.settings]
    tables = {point.name: {"type": point.controller, **point.settings} for point in points}
    file = study.file.model_copy(update={"controllers": {**study.file.controllers, **tables}})
    with_them = replace(study, file=file)
    return [
        ClassicTuning(point, Evaluator(task_for(with_them, point.name, tuned=False), objective).declared({}))
        for point in points
    ]


class _StoppedError(Exception):
    """The tuning is being stopped."""


class _Work:
    """What the searches of a tuning share: where trials go, how far all are, and whether they are to stop."""

    def __init__(self, store: TrialStore, table: TuneTable, tasks: int, progress: Progress) -> None:
        self.stopped = threading.Event()
        self._store, self._progress = store, progress
        self._whole, self._done, self._lock = tasks * table.seeds * table.trials, 0, threading.Lock()

    def search(self, unit: _Unit) -> list[Trial]:
        """One search, whose trials are kept under its name."""
        task = unit.evaluator.task
        name = f"{task.label}, seed {unit.seed}"
        known = self._store.known(name, unit.identity)
        keep = partial(self._store.keep, name)
        return Search(unit.evaluator, unit.seed, known, keep, lambda: self._made(task.label)).run(unit.starts)

    def _made(self, label: str) -> None:
        if self.stopped.is_set():
            raise _StoppedError
        with self._lock:
            self._done += 1
            self._progress(label, min(self._done / self._whole, 1.0))
