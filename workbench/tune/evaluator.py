"""Scores of points: margins of the loop, runs on the declared machine, runs on the machines that are drawn."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

from workbench.metrics.statistics import quantile
from workbench.study.resolve import Resolved
from workbench.tune.objective import Goal, Ran, Score, hold, margins_of, run
from workbench.tune.space import Point
from workbench.tune.task import Task

SEARCHED, FRESH = 0, 1
"""Streams of draws: those on which gains are found, and those on which they are measured again."""


class Bench:
    """Judges the points of a task by a goal."""

    def __init__(self, task: Task, goal: Goal) -> None:
        self.task = task
        self.goal = goal

    def screened(self, point: Point) -> Score:
        """As `declared`, without any run where the margins, which cost less than one, are not kept."""
        return self._judged(point, whatever=False)

    def declared(self, point: Point) -> Score:
        """The score of a point on the declared machine alone."""
        return self._judged(point, whatever=True)

    def on_draws(self, point: Point) -> Score:
        """The score of a point on the machines of the search, where there are any; a limit cycle of theirs apart."""
        score, table = self.declared(point), self.goal.table
        if not table.draws:
            return score
        values = self.on_machines(point, range(table.draws), SEARCHED)
        return replace(score, value=quantile(values, table.quantile), on_draws=values)

    def on_machines(self, point: Point, numbers: Iterable[int], stream: int) -> list[float]:
        """J of a point on each of the machines drawn with these numbers."""
        return [self.goal.on_machine(self._run(self.task.sampled(point, number, stream))) for number in numbers]

    def hunting(self, point: Point, numbers: Iterable[int], stream: int) -> float:
        """Share of the machines drawn with these numbers on which a step that is held ends in a limit cycle."""
        machines = [hold(self.task.sampled(point, number, stream), self.goal.table.constraints) for number in numbers]
        held = [one for cases in machines for one in self._run(cases)]
        return sum(bool(one.hunting) for one in held) / len(held) if held else 0.0

    def _judged(self, point: Point, *, whatever: bool) -> Score:
        """Margins, then the cases, then, of a point that keeps all else, the step that is held."""
        asked = self.goal.table.constraints
        cases = self.task.declared(point)
        margin = margins_of(cases, asked)
        beyond = self.goal.violations(margin, (), ())
        if not whatever and any(value > 0.0 for value in beyond.values()):
            return Score(math.inf, (), beyond, margin, math.inf)
        ran = self._run(cases)
        beyond, nominal = self.goal.violations(margin, ran, ()), self.goal.objective(ran)
        if all(value <= 0.0 for value in beyond.values()):
            beyond = self.goal.violations(margin, ran, self._run(hold(cases, asked)))
        return Score(nominal, ran, beyond, margin, nominal)

    def _run(self, cases: Sequence[Resolved]) -> list[Ran]:
        return [run(case, self.goal.columns) for case in cases]
