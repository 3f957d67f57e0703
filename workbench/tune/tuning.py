"""The tuning of one controller: searches from several seeds, and what is left on machines that they have not seen."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.metrics.statistics import quantile, quantile_interval
from workbench.tune.classic import StartingPoint, starting_points
from workbench.tune.evaluator import FRESH, SEARCHED, Bench
from workbench.tune.objective import Score, margin_speed
from workbench.tune.space import Point
from workbench.tune.task import Task, tune_table
from workbench.tune.trials import Trial

PID_GAINS = {"kp", "ki", "kd"}


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

    `start` is the score of the study's own gains on the declared machine. `trials` are those of all seeds, in order;
    `number` is that of the best. `seeds` holds the best objective that each seed found, None where it found no gains.
    `on_searched` and `on_fresh` hold the quantiles of the "start" and of the "tuned" gains.
    """

    task: Task
    trials: Sequence[Trial]
    start: Score
    best: Point | None
    score: Score | None
    number: int
    seeds: Mapping[int, float | None]
    on_searched: Mapping[str, Quantile]
    on_fresh: Mapping[str, Quantile]

    @property
    def seeds_differ(self) -> float | None:
        """By which share the best objective of the worst seed is above that of the best; None of a single seed.

        Infinite where a seed found no gains, or where the best is 0 and another is not.
        """
        values = list(self.seeds.values())
        known = [value for value in values if value is not None]
        if len(values) < 2 or not known:
            return None
        if len(known) < len(values):
            return float("inf")
        low, high = min(known), max(known)
        return 0.0 if low == high else high / low - 1.0 if low else float("inf")


def interval(values: Sequence[float], share: float) -> Quantile:
    """A quantile of draws with its interval."""
    return Quantile(quantile(values, share), *quantile_interval(values, share), len(values))


def starts_of(task: Task, classic: Sequence[StartingPoint]) -> list[Mapping[str, float]]:
    """The points with which every search begins: the gains of the study, then classic tunings of just its gains."""
    return [task.start, *_classic(task, classic)]


def has_pid_gains(task: Task) -> bool:
    """Whether a classic tuning of a PID says something of what is tuned."""
    return bool(PID_GAINS & {one.name for one in task.dimensions})


def candidate(trials: Sequence[Trial], draws: int) -> int | None:
    """The number of the best trial that keeps all constraints on so many draws; None where there is none."""
    numbers = [i for i, one in enumerate(trials) if one.draws == draws and one.feasible and one.value < np.inf]
    return min(numbers, key=lambda i: trials[i].value, default=None)


def concluded(bench: Bench, searches: Mapping[int, Sequence[Trial]]) -> Tuned:
    """What the searches of all seeds found, measured again."""
    task, table = bench.task, bench.goal.table
    trials = [trial for found in searches.values() for trial in found]
    seeds = dict[int, float | None]()
    for seed, found in searches.items():
        own = candidate(found, table.draws)
        seeds[seed] = None if own is None else found[own].value
    start, number = bench.declared(task.start), candidate(trials, table.draws)
    if number is None:
        return Tuned(task, trials, start, None, None, -1, seeds, {}, {})
    best = dict(trials[number].point)
    score = bench.on_draws(best)
    seen, fresh = dict[str, Quantile](), dict[str, Quantile]()
    if table.draws:
        before = bench.on_machines(task.start, range(table.draws), SEARCHED)
        seen = {"start": interval(before, table.quantile), "tuned": interval(score.on_draws, table.quantile)}
    if table.draws and table.fresh_draws:
        points = {"start": task.start, "tuned": best}
        runs = {key: bench.on_machines(point, range(table.fresh_draws), FRESH) for key, point in points.items()}
        fresh = {key: interval(values, table.quantile) for key, values in runs.items()}
    return Tuned(task, trials, start, best, score, number, seeds, seen, fresh)


def classic_points(task: Task, point: Point) -> list[StartingPoint]:
    """The classic tunings of a PID for the plant of a task's first case, at the speed of its margins; none for a plant
    whose command has no limit: nothing then says how large a command is.
    """
    case, asked = task.declared(point)[0], tune_table(task.study).constraints
    if not np.isfinite(case.setup.plant.command_limit(case.belief)):
        return []
    return starting_points(case.setup, case.belief, margin_speed(case, asked))


def _classic(task: Task, points: Sequence[StartingPoint]) -> list[dict[str, float]]:
    """Classic starting points of just the PID gains that are tuned, within their limits; the rest is the study's."""
    pid = PID_GAINS & {one.name for one in task.dimensions}
    found = []
    for point in points if pid else ():
        gains = {name: value for name, value in point.settings.items() if value}
        if set(gains) == pid:
            wanted = {**task.start, **gains}
            found.append({one.name: min(max(wanted[one.name], one.low), one.high) for one in task.dimensions})
    return [point for i, point in enumerate(found) if point not in (task.start, *found[:i])]


def infeasible(found: Tuned) -> str:
    """Which constraint all trials fail, and how near the nearest comes; else how many fail which."""
    broken = Counter(name for trial in found.trials for name, beyond in trial.violations.items() if beyond > 0.0)
    if not broken:
        return "every trial that keeps the constraints fails on too many of the drawn machines"
    many, name = len(found.trials), max(broken, key=lambda one: broken[one])
    if broken[name] < many:
        told = ", ".join(f"{one} in {count}" for one, count in broken.most_common())
        return f"no trial keeps all constraints; of {many} trials broken: {told}"
    closest = min((one for one in found.trials if name in one.violations), key=lambda trial: trial.violations[name])
    asked = tune_table(found.task.study).constraints
    reached = {
        "gain margin": f"{closest.gain_margin_dB:.1f} dB, {asked.gain_margin_dB:g} dB are asked for",
        "phase margin": f"{closest.phase_margin_deg:.1f} deg, {asked.phase_margin_deg:g} deg are asked for",
        "saturation": f"{closest.violations[name] + asked.saturated:.0%} of the time at the limit, "
        f"{asked.saturated:.0%} are allowed",
    }
    if "margin" in name and not closest.stable:
        reached[name] = "a loop that is not stable"
    nearest = f"; the nearest has {reached[name]}" if name in reached else ""
    return f"no trial keeps all constraints; most often broken: {name}, in {broken[name]} of {many} trials{nearest}"
