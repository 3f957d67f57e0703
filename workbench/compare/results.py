"""The verdicts of a folder of results, with those of the best measured again where there are any."""

from pathlib import Path

import pandas as pd

from workbench.compare.candidates import Cell
from workbench.compare.schema import ComparisonTable
from workbench.compare.verdicts import Verdict, verdicts
from workbench.errors import UserError
from workbench.study.reading import read_study
from workbench.study.store import FRESH, STUDY_COPY, read_results


def fresh_results(folder: Path) -> pd.DataFrame | None:
    """The results of the best measured again, None where there are none."""
    return read_results(folder / FRESH) if (folder / FRESH / "results.parquet").exists() else None


def verdicts_of(folder: Path) -> dict[Cell, Verdict]:
    """The verdicts of a folder of results.

    Raises:
        UserError: it holds no results, or its study has no [comparison].
    """
    frame = read_results(folder)
    spec = read_study(folder / STUDY_COPY).section(ComparisonTable)
    if spec is None:
        raise UserError(f"{folder}: its study has no [comparison], so it has no verdicts")
    return verdicts(spec, frame, fresh_results(folder))
