"""Measuring on fresh draws what the search would choose, so that having been picked makes nothing look better.

What is best of many on some draws was in part lucky on them: its share of these draws is too high (the winner's curse).
So the search only says in which order candidates are measured, on draws that it has not seen. The first whose interval
is above the asked probability is chosen; one whose interval is below it is out, and the next is measured. The i-th that
is measured has an interval of 1 - a/(i (i + 1)) with a = 1 - SURE: since 1/2 + 1/6 + 1/12 + ... = 1, all intervals
together hold with at least `SURE`, however many are measured and whichever is chosen (Bonferroni's inequality).

Source: Bonferroni's inequality with unequal shares fixed before the data, as in Wiens 2003 (Pharmaceutical Statistics
2, 211); samples of their own for selection and measurement, Cox 1975 (Biometrika 62, 441).
"""

from collections.abc import Callable, Sequence

import pandas as pd

from workbench.decide.answer import Cell
from workbench.decide.judged import Judged, judge
from workbench.decide.machines import batches, in_order, run_batches
from workbench.decide.plan import Plan
from workbench.metrics.statistics import SURE, deciding_counts, least_draws

Tell = Callable[[str, float], None]
"""Called with what is being done, and the share of it that is."""


def sureness(place: int) -> float:
    """Of the interval of the `place`-th candidate that is measured (1, 2, ...)."""
    return 1.0 - (1.0 - SURE) / (place * (place + 1))


def confirm(plan: Plan, cells: Sequence[Cell], jobs: int | None, tell: Tell) -> pd.DataFrame:
    """Measure what is needed in every cell; returns the runs. Without draws the search has said everything.

    In each round the next contender of every cell runs that has no sure answer yet; then, where it was asked, the first
    of each other kind, to say by how much they differ.
    """
    if not plan.several:
        for cell in cells:
            cell.measured += [row for row in cell.search if row.standing(plan.table) == "meets"]
        return pd.DataFrame()
    frames = list[pd.DataFrame]()
    while wanted := {cell: row for cell in cells if (row := cell.next()) is not None}:
        frames.append(_round(plan, wanted, jobs, tell, len(frames) + 1))
    asked = [cell for cell in cells if (cell.speed, cell.spread) == (plan.table.speed, plan.table.spread)]
    while wanted := {cell: row for cell in asked if (row := cell.next_to_compare()) is not None}:
        frames.append(_round(plan, wanted, jobs, tell, len(frames) + 1))
    return in_order(plan, pd.concat(frames)) if frames else pd.DataFrame()


def _round(plan: Plan, wanted: dict[Cell, Judged], jobs: int | None, tell: Tell, number: int) -> pd.DataFrame:
    """Run one contender of each of these cells on the fresh draws, and add what they say."""
    candidates = [(row.candidate, cell.speed, cell.spread) for cell, row in wanted.items()]
    told = f"fresh draws, round {number}"
    frame = run_batches(
        plan,
        batches("fresh", candidates, range(plan.fresh_draws)),
        jobs,
        lambda done, runs: tell(f"{told}: {done} of {runs} runs", done / runs),
    )
    for cell, row in wanted.items():
        own = frame[
            (frame["controller"] == row.controller)
            & (frame["rpm"] == row.rpm)
            & (frame["speed_m_per_s"] == row.speed)
            & (frame["spread"] == row.spread)
        ]
        cell.measured += judge(own, plan.table, sureness(len(cell.measured) + 1))
    return frame


def enough(probability: float, fresh_draws: int) -> str:
    """How many fresh draws settle a probability: for the plan and for the page."""
    sure = sureness(1)
    met, missed = deciding_counts(probability, fresh_draws, sure)
    least = least_draws(probability, sure)
    if met is None:
        return (
            f"{fresh_draws} fresh draws cannot show a probability above {probability:g}, not even {fresh_draws} of "
            f"{fresh_draws}: at least {least} are needed"
        )
    below = "nothing shows that it is not" if missed is None else f"{missed} or fewer that it is not"
    return (
        f"of {fresh_draws} fresh draws {met} or more show a probability above {probability:g}, {below}; in between it "
        f"cannot be told. The least number that can show it is {least}"
    )
