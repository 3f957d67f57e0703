"""The tuning of one controller: search, polish, and what is left of it on machines that the search has not seen."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from optuna.trial import FrozenTrial

from workbench.metrics.statistics import quantile, quantile_interval
from workbench.tune.bench import FRESH, SEARCHED, Bench
from workbench.tune.classic import StartingPoint, starting_points
from workbench.tune.descent import descended
from workbench.tune.goal import Score, margin_speed
from workbench.tune.search import SCORE, is_candidate, search, trials_in
from workbench.tune.space import Point
from workbench.tune.task import Task, tune_table

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

    `start` is the score of the study's own gains on the declared machine. `trials` are all of them, in order; `number`
    is that of the best, `polished` says what a descent from it gained, or why there was none. `on_searched` and
    `on_fresh` hold the quantiles of the "start" and of the "tuned" gains.
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
    """A quantile of draws with its interval."""
    return Quantile(quantile(values, share), *quantile_interval(values, share), len(values))


def tune(bench: Bench, database: Path, identity: str, tell: Tell = lambda said, done, of: None) -> Tuned:
    """Tune one controller; its trials go to `database`, and are taken from there if they are of the same `identity`.

    Raises:
        UserError: trials of another study in the database.
    """
    task, table = bench.task, bench.goal.table
    starts = [task.start, *_classic(task)]
    with trials_in(database, task.name, identity) as stored:
        trials = search(
            stored,
            task.dimensions,
            starts,
            bench.judge,
            table.trials,
            table.seed,
            lambda done: tell(task.name, done, table.trials),
        )
    start = bench.declared(task.start)
    number, best = _best(bench, trials)
    if best is None:
        return Tuned(task, trials, start, None, None, number, "", {}, {})
    tell(f"{task.name}: downhill", table.trials, table.trials)
    best, score, polished = descended(bench, best)
    tell(f"{task.name}: machines not seen", table.trials, table.trials)
    streams = ((table.draws, SEARCHED), (table.fresh_draws, FRESH))
    seen, fresh = (_quantiles(bench, best, count, stream) for count, stream in streams)
    return Tuned(task, trials, start, best, score, number, polished, seen, fresh)


def _quantiles(bench: Bench, best: Point, count: int, stream: int) -> dict[str, Quantile]:
    """Of the study's gains and of the best, on `count` machines of a stream; nothing where none are drawn."""
    table, points = bench.goal.table, {"start": bench.task.start, "tuned": best}
    if not (table.draws and count):
        return {}
    return {
        key: interval(bench.on_machines(point, range(count), stream), table.quantile) for key, point in points.items()
    }


def classic_points(task: Task, point: Point) -> list[StartingPoint]:
    """The classic tunings of a PID for the plant of a task's first case, at the speed of its margins; none for a plant
    whose command has no limit: nothing then says how large a command is.
    """
    case, asked = task.declared(point)[0], tune_table(task.study).constraints
    if not np.isfinite(case.setup.plant.command_limit(case.belief)):
        return []
    return starting_points(case.setup, case.belief, margin_speed(case, asked))


def _classic(task: Task) -> list[dict[str, float]]:
    """Classic starting points of just the PID gains that are tuned, within their limits; the rest is the study's."""
    pid = {one.name for one in task.dimensions} & {"kp", "ki", "kd"}
    found = []
    for point in classic_points(task, task.start):
        gains = {name: value for name, value in point.settings.items() if value}
        if set(gains) == pid:
            wanted = {**task.start, **gains}
            found.append({one.name: min(max(wanted[one.name], one.low), one.high) for one in task.dimensions})
    return [point for i, point in enumerate(found) if point not in (task.start, *found[:i])]


def _best(bench: Bench, trials: Sequence[FrozenTrial]) -> tuple[int, Point | None]:
    """The number and point of the best trial that keeps all constraints, on drawn machines at rest too."""
    table = bench.goal.table
    for trial in sorted(filter(is_candidate, trials), key=lambda one: (one.value, one.number)):
        judged = table.draws if table.constraints.limit_cycle else 0
        if bench.hunting(trial.params, range(judged), SEARCHED) <= 1.0 - table.quantile:
            return trials.index(trial), dict(trial.params)
    return -1, None


def infeasible(found: Tuned) -> str:
    """Which constraint most trials fail, and how near the nearest of them comes."""
    counts = Counter(name for trial in found.trials for name, beyond in trial.constraints.items() if beyond > 0.0)
    if not counts:
        return "every trial that keeps the constraints hunts on too many of the drawn machines"
    name = max(found.start.violations, key=lambda one: counts[one])  # in that order: a trial from a file has another
    count = counts[name]
    closest = min(found.trials, key=lambda trial: trial.constraints[name])
    asked, shown = tune_table(found.task.study).constraints, closest.user_attrs[SCORE]
    reached = {
        "gain margin": f"{shown['gain_margin_dB']:.1f} dB, {asked.gain_margin_dB:g} dB are asked for",
        "phase margin": f"{shown['phase_margin_deg']:.1f} deg, {asked.phase_margin_deg:g} deg are asked for",
        "saturation": f"{closest.constraints[name] + asked.saturated:.0%} of the time at the limit, "
        f"{asked.saturated:.0%} are allowed",
    }
    if "margin" in name and not shown["stable"]:
        reached[name] = "a loop that is not stable"
    nearest = f"; the nearest has {reached[name]}" if name in reached else ""
    return (
        f"no trial keeps all constraints; most often broken: {name}, in {count} of {len(found.trials)} trials{nearest}"
    )
