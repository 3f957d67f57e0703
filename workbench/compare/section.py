"""[comparison]: what a study has to do with a comparison of compensation and rotation."""

from pathlib import Path

import pandas as pd

from workbench.compare.candidates import Cell
from workbench.compare.checks import check_comparison, misplaced, one_sided
from workbench.compare.finalists import finalists
from workbench.compare.schema import ComparisonTable
from workbench.study.sections import Again, Checked, Said, Section
from workbench.study.study import Study


def _warnings(table: ComparisonTable, checked: Checked) -> list[str]:
    return [*one_sided(table, checked), *misplaced(table, checked)]


def _again(table: ComparisonTable, searched: pd.DataFrame, fresh: pd.DataFrame | None) -> Again | None:
    """The best of each class on fresh plant samples; where they hunt there, those behind them, until one holds."""
    chosen = finalists(table, searched, fresh) if table.fresh_draws else []
    if not chosen:
        return None
    cells = [name for name in Cell._fields if name in searched]
    wanted = [
        {**{name: getattr(each.cell, name) for name in cells}, "controller": each.controller, "rpm": each.rpm}
        for each in chosen
    ]
    who = "the best of each class" if fresh is None else "those behind whom hunting has taken out"
    return Again(wanted, table.fresh_draws, who)


def _pages(table: ComparisonTable, study: Study, frame: pd.DataFrame, folder: Path) -> list[Path]:
    from workbench.compare.comparison import compare, fresh_results
    from workbench.compare.report.page import write_comparison  # imports what draws and tabulates

    return write_comparison(compare(study, table, frame, fresh_results(folder)), folder)


def _said(table: ComparisonTable, study: Study, frame: pd.DataFrame, folder: Path) -> Said:
    from workbench.compare.comparison import compare, fresh_results
    from workbench.compare.report.overview import answer
    from workbench.compare.report.page import motors, rules, scope
    from workbench.compare.report.tables import VERDICTS

    comparison = compare(study, table, frame, fresh_results(folder))
    notes = [scope(comparison), *rules(comparison), *table.left_out, *motors(study), *table.assumptions]
    return Said(answer(comparison), notes, [VERDICTS])


COMPARISON = Section(
    name="comparison",
    table=ComparisonTable,
    check=check_comparison,
    warnings=_warnings,
    again=_again,
    pages=_pages,
    said=_said,
)
