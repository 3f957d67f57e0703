"""What changes the verdicts: tuning, the plant samples. Like is held against like: the samples that all have met."""

from collections.abc import Iterator, Mapping

import pandas as pd

from workbench.compare.agreement import agreement
from workbench.compare.candidates import Cell
from workbench.compare.cells import of_tuned
from workbench.compare.result import Change, Verdict
from workbench.compare.schema import ComparisonTable
from workbench.compare.verdicts import verdicts_of


def changes(
    table: ComparisonTable, frame: pd.DataFrame, searched: Mapping[Cell, Verdict], verdicts: Mapping[Cell, Verdict]
) -> Iterator[Change]:
    """Which verdicts would be others with the gains before, with one plant sample, or without fresh samples.

    `searched` are those of the results `frame` alone.
    """
    if table.before:
        names = {old: new for new, old in table.before.items()}
        before = frame[frame["controller"].isin(list(names))]
        before = before.assign(controller=before["controller"].map(names))
        after = of_tuned(table, frame)
        after = after[after["controller"].isin(list(table.before))]
        held = agreement(verdicts_of(table, after), verdicts_of(table, before))
        yield Change("With the gains before tuning", held)
    samples = sorted(frame["draw"].unique())
    if len(samples) > 1:
        first = verdicts_of(table, frame[frame["draw"] == samples[0]])
        condition = f"With draw {samples[0]} alone in place of all of the choice, taken at its word"
        yield Change(condition, agreement(searched, first))
    if any(verdict.fresh for verdict in verdicts.values()):
        yield Change("With the draws from which the best were chosen", agreement(verdicts, searched))
