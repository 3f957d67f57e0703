"""A decision: what was asked, every run, and what the runs say."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import pandas as pd

from workbench.decide.answer import Answer, Cell
from workbench.decide.confirm import confirm
from workbench.decide.judged import judge
from workbench.decide.machines import batches, run_batches
from workbench.decide.plan import Plan
from workbench.decide.schema import DecideTable

Tell = Callable[[str, float], None]
"""Called with what is being done, and the share of everything that is."""

SEARCH_SHARE = 0.6
"""Of the time, about, that the search takes; the rest is spent on fresh draws."""


@dataclass(frozen=True, eq=False)
class Decision:
    """The runs of a plan (a row each), and what they say at each speed and spread."""

    plan: Plan
    draws: pd.DataFrame
    cells: Sequence[Cell]

    @property
    def table(self) -> DecideTable:
        """What was asked."""
        return self.plan.table

    @property
    def asked(self) -> Cell:
        """The speed and spread that were asked for."""
        return self.at(self.table.speed, self.table.spread)

    def at(self, speed: float, spread: float) -> Cell:
        """A speed (m/s) and a spread of the map."""
        return next(cell for cell in self.cells if (cell.speed, cell.spread) == (speed, spread))

    def answer(self, speed: float, spread: float) -> Answer:
        """What suffices there."""
        return self.at(speed, spread).answer()


def decide(plan: Plan, jobs: int | None = None, tell: Tell = lambda said, done: None) -> Decision:
    """Look for candidates, measure those that may be chosen on fresh draws; the same whatever the number of `jobs`."""
    wanted = [
        (candidate, speed, spread) for candidate in plan.candidates for speed in plan.speeds for spread in plan.spreads
    ]
    searched = run_batches(
        plan,
        batches("search", wanted, range(plan.draws)),
        jobs,
        lambda done, runs: tell(f"search: {done} of {runs} runs", SEARCH_SHARE * done / runs),
    )
    rows = judge(searched, plan.table)
    cells = [
        Cell(speed, spread, plan.table, [row for row in rows if (row.speed, row.spread) == (speed, spread)])
        for speed in plan.speeds
        for spread in plan.spreads
    ]
    fresh = confirm(plan, cells, jobs, lambda said, done: tell(said, SEARCH_SHARE + 0.9 * (1.0 - SEARCH_SHARE) * done))
    return Decision(plan, pd.concat([searched, fresh], ignore_index=True) if len(fresh) else searched, cells)
