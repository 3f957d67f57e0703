"""Making a comparison of a study's results, once: what pages, tables, figures and notebooks then read."""

from pathlib import Path

import pandas as pd

from workbench.compare.cells import cells_of, of_tuned, with_all_axes
from workbench.compare.changes import changes
from workbench.compare.result import Comparison
from workbench.compare.schema import ComparisonTable
from workbench.compare.verdicts import judged
from workbench.errors import UserError
from workbench.study.reading import read_study
from workbench.study.store import FRESH, STUDY_COPY, read_results
from workbench.study.study import Study


def compare(study: Study, table: ComparisonTable, frame: pd.DataFrame, fresh: pd.DataFrame | None = None) -> Comparison:
    """The verdict of each cell: chosen from the results `frame`, measured in `fresh` where there is such a frame."""
    results, again = with_all_axes(frame), None if fresh is None else with_all_axes(fresh)
    searched = cells_of(table, of_tuned(table, results))
    measured = None if again is None else cells_of(table, of_tuned(table, again))
    verdicts = judged(table, searched, measured)
    return Comparison(
        study,
        table,
        results,
        again,
        searched,
        verdicts,
        list(changes(table, results, judged(table, searched, None), verdicts)),
    )


def fresh_results(folder: Path) -> pd.DataFrame | None:
    """The results of the best measured again, None where there are none."""
    return read_results(folder / FRESH) if (folder / FRESH / "results.parquet").exists() else None


def comparison_in(folder: Path) -> Comparison:
    """The comparison of a folder of results.

    Raises:
        UserError: it holds no results, or its study has no [comparison].
    """
    frame = read_results(folder)
    return comparison_of(read_study(folder / STUDY_COPY), frame, folder)


def comparison_of(study: Study, frame: pd.DataFrame, folder: Path) -> Comparison:
    """The comparison that a study asks for, of its results as read from a folder.

    Raises:
        UserError: it has no [comparison].
    """
    table = study.section(ComparisonTable)
    if table is None:
        raise UserError(f"{folder}: its study has no [comparison], so it has no verdicts")
    return compare(study, table, frame, fresh_results(folder))
