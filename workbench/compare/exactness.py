"""Of how many cases the error is hardly larger than that of their integration."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from workbench.compare.candidates import Cell
from workbench.compare.schema import ComparisonTable

DOUBTFUL = 0.1
"""Share of an error above which that of the integration is told."""


@dataclass(frozen=True)
class InexactCase:
    """A case whose error counts, and whose solver error is a large share of it."""

    cell: Cell
    controller: str
    rpm: float


@dataclass(frozen=True)
class Exactness:
    """Of the `cases` whose solver error is known how many are `doubtful`, and those of them whose error counts, the
    largest first.
    """

    cases: int
    doubtful: int
    counting: Sequence[InexactCase]


def exactness(table: ComparisonTable, frame: pd.DataFrame) -> Exactness:
    """How exact the rows of results are."""
    frame = frame[frame["solver_error_m"].notna()]
    steps = frame["reference"].isin(table.steps)
    error = np.where(steps, frame["steady_state_max_error_m"], frame["rms_error_m"])
    doubtful = np.where(steps, frame["solver_error_m"], frame["solver_rms_error_m"]) > DOUBTFUL * error
    counts = doubtful & (error > table.negligible)
    rows = frame[counts].assign(error=error[counts]).sort_values("error", ascending=False)
    cases = [
        InexactCase(
            Cell(str(row.machine), str(row.scenario), str(row.reference)), str(row.controller), float(str(row.rpm))
        )
        for row in rows.itertuples()
    ]
    return Exactness(len(frame), int(doubtful.sum()), cases)
