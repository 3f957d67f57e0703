"""Scores of points: runs on the declared machine, margins of the loop, runs on the machines that are drawn."""

from collections.abc import Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import replace

from workbench.metrics.statistics import quantile
from workbench.study.resolve import Resolved
from workbench.tune.goal import Goal, Ran, Score, beyond_reach, hold, margins_of, run
from workbench.tune.space import Point
from workbench.tune.task import Task

CHUNK = 8
"""Draws that are run before it is asked whether a point is worth the others."""

SEARCHED, FRESH = 0, 1
"""Streams of draws: those on which gains are found, and those on which they are measured again."""


class Bench:
    """Judges the points of a task by a goal; `executor` runs what is independent at once."""

    def __init__(self, task: Task, goal: Goal, executor: Executor) -> None:
        self.task = task
        self.goal = goal
        self._executor = executor

    def judge(self, points: Sequence[Point], best: float) -> list[Score]:
        """Scores of points. On draws one is given up as soon as its quantile is certain to be above `best`."""
        scores = self._declared(points)
        return [
            self._on_draws(point, score, best) if self.goal.table.draws and score.feasible else score
            for point, score in zip(points, scores, strict=True)
        ]

    def declared(self, point: Point) -> Score:
        """The score of a point on the declared machine alone."""
        return self._declared([point])[0]

    def on_machines(self, point: Point, numbers: Iterable[int], stream: int) -> list[float]:
        """J of a point on each of the machines drawn with these numbers."""
        machines = [self.task.drawn(point, number, stream) for number in numbers]
        done = self._run([case for cases in machines for case in cases])
        sizes = [len(cases) for cases in machines]
        ends = [sum(sizes[: i + 1]) for i in range(len(sizes))]
        return [self.goal.on_machine(done[end - size : end]) for end, size in zip(ends, sizes, strict=True)]

    def hunting(self, point: Point, numbers: Iterable[int], stream: int) -> float:
        """Share of the machines drawn with these numbers on which a step that is held ends in a limit cycle."""
        machines = [hold(self.task.drawn(point, number, stream), self.goal.table.constraints) for number in numbers]
        held = self._run([case for cases in machines for case in cases])
        return sum(bool(one.hunting) for one in held) / len(held) if held else 0.0

    def _declared(self, points: Sequence[Point]) -> list[Score]:
        """Scores on the declared machine alone."""
        cases = [self.task.declared(point) for point in points]
        held = [hold(one, self.goal.table.constraints) for one in cases]
        found = list(self._executor.map(lambda one: margins_of(one, self.goal.table.constraints), cases))
        done = iter(self._run([case for pair in zip(cases, held, strict=True) for part in pair for case in part]))
        scores = []
        for own, rests, margin in zip(cases, held, found, strict=True):
            ran, rested = [next(done) for _ in own], [next(done) for _ in rests]
            nominal = self.goal.objective(ran)
            scores.append(Score(nominal, ran, self.goal.violations(margin, ran, rested), margin, nominal))
        return scores

    def _on_draws(self, point: Point, score: Score, best: float) -> Score:
        table, values = self.goal.table, list[float]()
        while len(values) < table.draws:
            values += self.on_machines(point, range(len(values), min(len(values) + CHUNK, table.draws)), SEARCHED)
            if len(values) < table.draws and beyond_reach(values, table.draws, table.quantile, best):
                return replace(score, value=quantile(values, table.quantile), on_draws=values, pruned=True)
        return replace(score, value=quantile(values, table.quantile), on_draws=values)

    def _run(self, cases: Sequence[Resolved]) -> list[Ran]:
        return list(self._executor.map(lambda case: run(case, self.goal.columns), cases))
