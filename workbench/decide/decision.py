"""A decision: what was asked, every run, and what the runs say."""

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from workbench.decide.judgement import Answer, Judged, answer, at, judge, ordered
from workbench.decide.machines import Progress, run_all
from workbench.decide.plan import Plan
from workbench.study.decide_schema import DecideTable


@dataclass(frozen=True, eq=False)
class Decision:
    """The runs of a plan (a row each) and the judgement of each candidate at each speed and spread."""

    plan: Plan
    draws: pd.DataFrame
    rows: Sequence[Judged]

    @property
    def table(self) -> DecideTable:
        """What was asked."""
        return self.plan.table

    @property
    def asked(self) -> list[Judged]:
        """The candidates at the speed and spread that were asked for, the best first."""
        return ordered(at(self.rows, self.table.speed, self.table.spread), self.table)

    def answer(self, speed: float, spread: float) -> Answer:
        """What suffices at a speed (m/s) and a spread of the map."""
        return answer(at(self.rows, speed, spread), self.table)


def decide(plan: Plan, jobs: int | None = None, progress: Progress | None = None) -> Decision:
    """Run a plan and judge it; the same whatever the number of `jobs`."""
    draws = run_all(plan, jobs, progress)
    return Decision(plan, draws, judge(draws, plan.table))
