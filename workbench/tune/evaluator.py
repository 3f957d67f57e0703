"""Scores of points: margins of the loop, runs on the declared machine, runs on plant samples."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from workbench.metrics.statistics import quantile
from workbench.study.resolve import Resolved, resolve
from workbench.study.study import Case, Study
from workbench.study.unfold import unfold
from workbench.tune.objective import Objective, RunMetrics, Score, hold, margins_of, run
from workbench.tune.prepare import cases_for, tasks_for
from workbench.tune.schema import reference_controller, tune_table
from workbench.tune.space import Point
from workbench.tune.task import Task

SEARCHED, FRESH = 0, 1
"""Streams of plant samples: those on which gains are found, and those on which they are measured again."""


@dataclass(frozen=True, eq=False)
class Evaluator:
    """Scores the points of a task by an objective."""

    task: Task
    objective: Objective

    def screened(self, point: Point) -> Score:
        """As `declared`, without any run where the margins, which cost less than one, are not kept."""
        return self._score(point, whatever=False)

    def declared(self, point: Point) -> Score:
        """The score of a point on the declared machine alone."""
        return self._score(point, whatever=True)

    def on_draws(self, point: Point) -> Score:
        """The score of a point on the plant samples of the search, where there are any; their limit cycles apart."""
        score, table = self.declared(point), self.objective.table
        if not table.draws:
            return score
        values = self.on_samples(point, range(table.draws), SEARCHED)
        return replace(score, value=quantile(values, table.quantile), on_samples=values)

    def on_samples(self, point: Point, numbers: Iterable[int], stream: int) -> list[float]:
        """J of a point on each of the plant samples of these numbers."""
        return [self.objective.on_sample(self._run(self.task.sampled(point, number, stream))) for number in numbers]

    def hunting(self, point: Point, numbers: Iterable[int], stream: int) -> float:
        """Share of the plant samples of these numbers on which a step that is held ends in a limit cycle."""
        constraints = self.objective.table.constraints
        samples = [hold(self.task.sampled(point, number, stream), constraints) for number in numbers]
        runs = [each for cases in samples for each in self._run(cases)]
        return sum(bool(each.hunting) for each in runs) / len(runs) if runs else 0.0

    def _score(self, point: Point, *, whatever: bool) -> Score:
        """Margins, then the cases, then, of a point that keeps all else, the step that is held."""
        constraints = self.objective.table.constraints
        cases = self.task.declared(point)
        smallest = margins_of(cases, constraints)
        beyond = self.objective.violations(smallest, (), ())
        if not whatever and any(value > 0.0 for value in beyond.values()):
            return Score(math.inf, (), beyond, smallest, math.inf)
        runs = self._run(cases)
        beyond, nominal = self.objective.violations(smallest, runs, ()), self.objective.value(runs)
        if all(value <= 0.0 for value in beyond.values()):
            beyond = self.objective.violations(smallest, runs, self._run(hold(cases, constraints)))
        return Score(nominal, runs, beyond, smallest, nominal)

    def _run(self, cases: Sequence[Resolved]) -> list[RunMetrics]:
        return [run(case, self.objective.columns) for case in cases]


def objective_at(study: Study, cases: Sequence[Case], at: Mapping[str, object]) -> Objective:
    """The objective of a study at one combination of its axes, in units of its reference controller there.

    Raises:
        UserError: no such reference controller, or a metric that it does not have.
    """
    table = tune_table(study)
    name = reference_controller(study)
    columns = tuple(table.objective.used)
    return Objective(table, [run(resolve(study, case), columns) for case in cases_for(study, cases, name, at)])


def evaluators_of(study: Study, names: Sequence[str]) -> list[Evaluator]:
    """The evaluators of all tasks of tuning these controllers of a `prepared` study.

    Raises:
        UserError: a reference controller that does not serve.
    """
    tasks, cases = tasks_for(study, names), unfold(study)
    places = {repr(task.at): task.at for task in tasks}
    objectives = {key: objective_at(study, cases, at) for key, at in places.items()}
    return [Evaluator(task, objectives[repr(task.at)]) for task in tasks]
