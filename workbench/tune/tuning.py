"""Tuning of a study's controllers: search, polish, and what is left of it on machines that the search has not seen."""

import json
import math
import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from optuna.trial import FrozenTrial
from scipy.stats import binom

from plants.equation import source_hash
from workbench.errors import UserError, nearest
from workbench.metrics.window import find_window
from workbench.study.document import Study
from workbench.study.resolve import resolve
from workbench.study.runner import PROGRAM_FOLDERS
from workbench.study.tune_schema import TuneTable
from workbench.tune.bench import FRESH, SEARCHED, Bench
from workbench.tune.classic import starting_points
from workbench.tune.goal import Goal, Score, quantile, run
from workbench.tune.polish import PolishProblem, polish
from workbench.tune.search import SCORE, is_candidate, search, trials_in
from workbench.tune.space import Point
from workbench.tune.task import Task, cases_for, task_for, tune_table

SURE = 0.95
"""Of the interval of a quantile."""

PD = "pd"
"""What a PD that is added is called."""

Tell = Callable[[str, int, int], None]
"""Is told what is being done, and how many of how many trials are finished."""


@dataclass(frozen=True)
class Quantile:
    """A quantile over draws, with the interval in which that of all machines is; `high` is infinite where so few draws
    do not bound it.
    """

    value: float
    low: float
    high: float
    draws: int


@dataclass(frozen=True, eq=False)
class Tuned:
    """What became of one controller. `best` is None where no trial keeps the constraints.

    `trials` are all of them, in order; `number` is that of the best, `polished` what a local descent from it gained (as
    a share), or why there was none. `on_searched` and `on_fresh` hold the quantiles of `start` (the study's gains) and of
    the best.
    """

    task: Task
    trials: Sequence[FrozenTrial]
    start: Score
    best: Point | None
    score: Score | None
    number: int
    polished: str
    on_searched: Mapping[str, Quantile]
    on_fresh: Mapping[str, Quantile]


def interval(values: Sequence[float], share: float) -> Quantile:
    """A quantile of draws, and its interval by order statistics: free of any assumption of their distribution.

    The number of draws below the true quantile is binomial; the interval's ends are the draws of the ranks between
    which it is with a probability of at least `SURE`.
    """
    ordered, count = sorted(values), len(values)
    low = int(binom.ppf(0.5 * (1.0 - SURE), count, share))
    high = int(binom.ppf(0.5 * (1.0 + SURE), count, share)) + 1
    return Quantile(
        quantile(values, share),
        ordered[low - 1] if low >= 1 else 0.0,
        ordered[high - 1] if high <= count else float("inf"),
        count,
    )


def identity_of(study: Study, table: TuneTable) -> str:
    """What stored trials must agree in: study, [tune] without the number of trials, draws, code."""
    uncertainty = study.file.uncertainty
    return json.dumps(
        {
            "study": study.fingerprint,
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


def goal_of(study: Study, executor: Executor) -> Goal:
    """The goal of a study, in units of its yardstick.

    Raises:
        UserError: no such yardstick, or a figure that it does not have.
    """
    table = tune_table(study)
    name = table.yardstick or next(iter(study.file.controllers))
    if name not in study.file.controllers:
        raise study.error(
            ("tune", "yardstick"), f'unknown controller "{name}"; {nearest(name, study.file.controllers)}'
        )
    cases = [resolve(study, case) for case in cases_for(study, table, name)]
    columns = tuple(table.objective.used)
    return Goal(table, list(executor.map(lambda case: run(case, columns), cases)))


def tune(
    study: Study, name: str, database: Path, executor: Executor, tell: Tell = lambda said, done, of: None
) -> Tuned:
    """Tune one controller of a study; its trials go to `database`, and are taken from there.

    Raises:
        UserError: a mistake in [tune], or trials of another study in the database.
    """
    table = tune_table(study)
    task, goal = task_for(study, name), goal_of(study, executor)
    bench = Bench(task, goal, executor)
    with trials_in(database, name, identity_of(study, table)) as stored:
        trials = search(
            stored,
            task.dimensions,
            [task.start, *_classic(task)],
            bench.judge,
            table.trials,
            table.seed,
            lambda done: tell(name, done, table.trials),
        )
    start = bench.judge([task.start], math.inf)[0]
    number, best, score = _best(bench, trials)
    if best is None:
        return Tuned(task, trials, start, None, None, -1, "", {}, {})
    tell(f"{name}: polish", table.trials, table.trials)
    best, score, polished = _polished(bench, best, score)
    tell(f"{name}: machines not seen", table.trials, table.trials)
    points = {"start": task.start, "tuned": best}
    seen, fresh = (
        {key: interval(bench.on_machines(point, range(count), stream), table.quantile) for key, point in points.items()}
        if table.draws and count
        else {}
        for count, stream in ((table.draws, SEARCHED), (table.fresh_draws, FRESH))
    )
    return Tuned(task, trials, start, best, score, number, polished, seen, fresh)


def _classic(task: Task) -> list[dict[str, float]]:
    """Classic starting points that have just the gains that are tuned, within their limits."""
    names = {one.name for one in task.dimensions}
    found = []
    for point in starting_points(task.declared(task.start)[0]):
        gains = {name: value for name, value in point.settings.items() if value}
        if set(gains) == names:
            found.append({one.name: min(max(gains[one.name], one.low), one.high) for one in task.dimensions})
    return found


def _best(bench: Bench, trials: Sequence[FrozenTrial]) -> tuple[int, Point | None, Score | None]:
    """The number, point and score of the best trial that keeps all constraints, on drawn machines at rest too."""
    table = bench.goal.table
    for trial in sorted(filter(is_candidate, trials), key=lambda one: (one.value, one.number)):
        point = dict(trial.params)
        judged = table.draws if table.constraints.limit_cycle else 0
        if bench.hunting(point, range(judged), SEARCHED) > 1.0 - table.quantile:
            continue
        return trials.index(trial), point, bench.judge([point], math.inf)[0]
    return -1, None, None


def _polished(bench: Bench, best: Point, score: Score) -> tuple[Point, Score, str]:
    """The best after a local descent by exact derivatives, where that helps, and what it gained in words."""
    table, task = bench.goal.table, bench.task
    if not table.polish:
        return best, score, "not asked for"
    if table.draws:
        return best, score, "none: a quantile over draws is not smooth"
    if set(bench.goal.columns) != {"rms_error_m"}:
        return best, score, "none: only the rms error has a derivative here"
    if task.rotates:
        return best, score, "none: the rotation is tuned too"
    descent = polish(_problem(bench, best))
    if descent.value >= descent.start_value:
        return best, score, f"no gain: {descent.reason}"
    moved = {one.name: float(f"{getattr(descent.settings, one.name):.12g}") for one in task.dimensions}
    again = bench.judge([moved], math.inf)[0]
    if not again.feasible:
        failed = ", ".join(name for name, beyond in again.violations.items() if beyond > 0.0)
        return best, score, f"no gain: what it leads to does not keep {failed}"
    if again.value >= score.value:
        return best, score, "no gain: the simulation does not confirm what it leads to"
    share = 1.0 - again.value / score.value
    return moved, again, f"{100.0 * share:.2g} % in {descent.gradient_evaluations} evaluations of the gradient"


def _problem(bench: Bench, best: Point) -> PolishProblem:
    """The smooth part of a goal about a point."""
    task, cases = bench.task, bench.task.declared(best)
    units = [one["rms_error_m"] for one in bench.goal.units]
    parts = []
    for case, unit in zip(cases, units, strict=True):
        samples = round(case.setup.duration / case.setup.sample_time) + 1
        window = find_window(case.setup.sample_time * np.arange(samples), case.signal, case.transient)
        if unit is not None and window is not None:
            parts.append((case.setup, window.start, samples, 1.0 / (unit * len(cases))))
    bounds = {one.name: (one.low, one.high, one.logarithmic) for one in task.dimensions}
    names = tuple(bounds)
    return PolishProblem(tuple(parts), task.controller, task.settings_at(best), cases[0].belief, names, bounds)


def infeasible(found: Tuned) -> str:
    """Which constraint most trials fail, and how near the nearest of them comes."""
    counts = Counter(name for trial in found.trials for name, beyond in trial.constraints.items() if beyond > 0.0)
    if not counts:
        return "every trial that keeps the constraints hunts on too many of the drawn machines"
    name, count = counts.most_common(1)[0]
    closest = min(found.trials, key=lambda trial: trial.constraints[name])
    asked, shown = tune_table(found.task.study).constraints, closest.user_attrs[SCORE]
    reached = {
        "gain margin": f"; the nearest has {shown['gain_margin_dB']:.1f} dB, {asked.gain_margin_dB:g} dB are asked for",
        "phase margin": f"; the nearest has {shown['phase_margin_deg']:.1f} deg, {asked.phase_margin_deg:g} deg are "
        "asked for",
        "saturated": f"; the nearest saturates for {closest.constraints[name] + asked.saturated:.0%} of the time, "
        f"{asked.saturated:.0%} are allowed",
    }
    return (
        f"no trial keeps all constraints; {name} fails most often, in {count} of {len(found.trials)} trials"
        f"{reached.get(name, '')}"
    )


def prepared(study: Study, name: str, trials: int | None) -> tuple[Study, list[str]]:
    """A study ready to be tuned, and the controllers that are: a PD is always among all of them.

    Raises:
        UserError: no [tune], no such controller, or a mistake in what is asked of one of them.
    """
    table = tune_table(study)
    if trials is not None:
        table = table.model_copy(update={"trials": trials})
    study = replace(study, file=study.file.model_copy(update={"tune": table}))
    names = chosen(study, name)
    if name == "all" and not any(_is_pd(study.file.controllers[one]) for one in names):
        study, names = _with_pd(study, names)
    for one in names:
        task_for(study, one)
    return study, names


def _is_pd(table: Mapping[str, object]) -> bool:
    return table.get("type") == "pid" and bool(table.get("kd")) and not table.get("ki")


def _with_pd(study: Study, names: list[str]) -> tuple[Study, list[str]]:
    """The study with a PD controller, placed by its poles, beside the others."""
    plain = task_for(study, names[0])
    placed = next(
        point
        for point in starting_points(plain.declared(plain.start)[0])
        if point.settings.get("kd") and not point.settings.get("ki")
    )
    table = {"type": "pid", **{key: value for key, value in placed.settings.items() if value}}
    controllers = {**study.file.controllers, PD: table}
    return replace(study, file=study.file.model_copy(update={"controllers": controllers})), [*names, PD]


def tune_all(
    study: Study, names: Sequence[str], database: Path, jobs: int | None, tell: Callable[[str, float], None]
) -> list[Tuned]:
    """Tune these controllers of a `prepared` study, one after another."""
    with ThreadPoolExecutor(jobs or os.cpu_count() or 1) as executor:
        return [
            tune(
                study,
                name,
                database,
                executor,
                lambda said, done, of, number=number: tell(said, (number + done / of) / len(names)),
            )
            for number, name in enumerate(names)
        ]
