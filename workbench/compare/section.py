"""[comparison]: what a study has to do with a comparison of compensation and rotation."""

from pathlib import Path

import pandas as pd

from workbench.compare.checks import check_comparison, misplaced, one_sided
from workbench.compare.finalists import finalists
from workbench.compare.schema import ComparisonTable
from workbench.study.sections import Again, Checked, Section
from workbench.study.study import Study


def _warnings(spec: ComparisonTable, checked: Checked) -> list[str]:
    return [*one_sided(spec, checked), *misplaced(spec, checked)]


def _again(spec: ComparisonTable, searched: pd.DataFrame, fresh: pd.DataFrame | None) -> Again | None:
    """The best of each class on fresh draws; where they hunt there, those behind them, until one holds."""
    wanted = finalists(spec, searched, fresh) if spec.fresh_draws else []
    if not wanted:
        return None
    who = "the best of each class" if fresh is None else "those behind whom hunting has taken out"
    return Again(wanted, spec.fresh_draws, who)


def _pages(spec: ComparisonTable, study: Study, frame: pd.DataFrame, folder: Path) -> list[Path]:
    from workbench.compare.page import write_comparison  # what draws and tabulates is imported where there are results

    return write_comparison(spec, study, frame, folder)


COMPARISON = Section(
    name="comparison",
    table=ComparisonTable,
    check=check_comparison,
    warnings=_warnings,
    again=_again,
    pages=_pages,
)
