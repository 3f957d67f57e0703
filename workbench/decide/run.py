"""Running a decision: candidates are looked for, then those that may be chosen are measured on fresh plant samples.

What is best of many on some draws was in part lucky on them: its share of these draws is too high (the winner's curse).
So the search only says in which order candidates are measured, on draws that it has not seen. The first whose interval
is above the asked probability is chosen; one whose interval is below it is out, and the next is measured. The i-th that
is measured has an interval of 1 - a/(i (i + 1)) with a = 1 - SURE: since 1/2 + 1/6 + 1/12 + ... = 1, all intervals
together hold with at least `SURE`, however many are measured and whichever is chosen (Bonferroni's inequality).

Source: Bonferroni's inequality with unequal shares fixed before the data, as in Wiens 2003 (Pharmaceutical Statistics
2, 211); samples of their own for selection and measurement, Cox 1975 (Biometrika 62, 441).
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import pandas as pd

from workbench.decide.batches import NOTHING_KEPT, Kept, batches, in_order, run_batches
from workbench.decide.candidate import CandidateResult, candidate_results
from workbench.decide.plan import Plan
from workbench.decide.result import Cell, Decision
from workbench.metrics.statistics import SURE, deciding_counts, least_draws
from workbench.progress import Progress, part_of, silent
from workbench.simulation.simulate import ready

SEARCH_SHARE = 0.6
"""Of the time, about, that the search takes; the rest is spent on fresh samples."""

FRESH_SHARE = 0.9
"""Of the share that is left: a round of fresh samples never says that all is done, since another may follow."""


def decide(
    plan: Plan,
    jobs: int | None = None,
    progress: Progress = silent,
    kept: Kept = NOTHING_KEPT,
    cluster: str | None = None,
) -> Decision:
    """Look for candidates, measure those that may be chosen on fresh samples; the same for any number of `jobs`, on a
    `cluster` (the address of a dask scheduler), and whatever runs of it are `kept`.

    `progress` is told what is being done, and how far all is.

    Raises:
        UserError: see `run_batches`.
    """
    if cluster is None:
        compiled(plan)
    run = partial(run_batches, plan, jobs=jobs, kept=kept, cluster=cluster)
    wanted = [
        (candidate, speed, spread) for candidate in plan.candidates for speed in plan.speeds for spread in plan.spreads
    ]
    search_part = part_of(progress, 0.0, SEARCH_SHARE)
    searched = run(batches("search", wanted, range(plan.draws)), doing="search", progress=search_part)
    rows = candidate_results(searched, plan.table)
    cells = [
        Cell(speed, spread, plan.table, [row for row in rows if (row.speed, row.spread) == (speed, spread)])
        for speed in plan.speeds
        for spread in plan.spreads
    ]
    fresh_part = part_of(progress, SEARCH_SHARE, FRESH_SHARE * (1.0 - SEARCH_SHARE))
    cells, fresh = confirm(plan, cells, partial(run, progress=fresh_part))
    return Decision(plan, pd.concat([searched, fresh], ignore_index=True) if len(fresh) else searched, cells)


def compiled(plan: Plan) -> None:
    """Have all compiled code of a plan at hand, before processes are made that would each compile it."""
    for case in plan.cases[plan.table.speed].values():
        ready(case.resolve().setup)


def confirm(plan: Plan, cells: Sequence[Cell], run: Callable[..., pd.DataFrame]) -> tuple[list[Cell], pd.DataFrame]:
    """The cells with what is needed measured in each, and the runs. Without draws the search has said everything.

    `run` runs batches of the plan, as `run_batches` does. In each round the next contender of every cell runs that has
    no sure answer yet; then, where it was asked, the first of each other kind, to say by how much they differ.
    """
    if not plan.several:
        meets = [[row for row in cell.search if row.standing(plan.table) == "meets"] for cell in cells]
        return [cell.with_measured(rows) for cell, rows in zip(cells, meets, strict=True)], pd.DataFrame()
    measured, frames = list(cells), list[pd.DataFrame]()
    while wanted := {i: row for i, cell in enumerate(measured) if (row := cell.next()) is not None}:
        frames.append(_measure(plan, measured, wanted, run, len(frames) + 1))
    asked = next(
        i for i, cell in enumerate(cells) if (cell.speed, cell.spread) == (plan.table.speed, plan.table.spread)
    )
    while (row := measured[asked].next_to_compare()) is not None:
        frames.append(_measure(plan, measured, {asked: row}, run, len(frames) + 1))
    return measured, in_order(plan, pd.concat(frames)) if frames else pd.DataFrame()


def _measure(
    plan: Plan,
    cells: list[Cell],
    wanted: Mapping[int, CandidateResult],
    run: Callable[..., pd.DataFrame],
    number: int,
) -> pd.DataFrame:
    """Run one contender of each of these `cells`, which are renewed with what the fresh samples say of it."""
    candidates = [(row.candidate, cells[i].speed, cells[i].spread) for i, row in wanted.items()]
    frame = run(batches("fresh", candidates, range(plan.fresh_draws)), doing=f"fresh draws, round {number}")
    for i, row in wanted.items():
        own = frame[
            (frame["controller"] == row.controller)
            & (frame["rpm"] == row.rpm)
            & (frame["speed_m_per_s"] == row.speed)
            & (frame["spread"] == row.spread)
        ]
        sure = sureness(len(cells[i].measured) + 1)
        cells[i] = cells[i].with_measured(candidate_results(own, plan.table, sure))
    return frame


def sureness(place: int) -> float:
    """Of the interval of the `place`-th candidate that is measured (1, 2, ...)."""
    return 1.0 - (1.0 - SURE) / (place * (place + 1))


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
