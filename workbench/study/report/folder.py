"""What a study asks to be made of its results: tables, figures, and what its other questions make of them."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd

from workbench.metrics.registry import names_along
from workbench.study.plan import Plan
from workbench.study.report.drawn import write_draws
from workbench.study.report.figures import write_figure
from workbench.study.report.page import write_results_page
from workbench.study.report.schema import Column, Curve, Row, TableSpec
from workbench.study.report.select import CYCLE, with_cycles
from workbench.study.report.shown_figures import FIGURES
from workbench.study.report.tables import write_table
from workbench.study.report.unusual import SOLVER_ERRORS
from workbench.study.sections import overlays_of, sections_of
from workbench.study.study import Study


def shown_columns(study: Study, axis: str) -> set[str] | None:
    """The columns of results that tables, figures and the page of a study show; None where it has other questions,
    which may look at all.
    """
    if sections_of(study):
        return None
    called = names_along(axis)
    standard = [called[name] for name in (*(name for name, _ in FIGURES), *CYCLE)]
    columns = [column for table in study.file.tables for column in table.columns]
    rows = [row for table in study.file.tables for row in table.rows]
    panels = [panel for figure in study.file.figures for panel in figure.panels]
    curves = [curve for panel in panels for curve in panel.curves]
    asked: list[TableSpec | Column | Row | Curve] = [*study.file.tables, *columns, *rows, *curves]
    return {
        *standard,
        *SOLVER_ERRORS,
        *(column.result for column in columns),
        *(row.result for row in rows),
        *(str(table.index) for table in study.file.tables),
        *(panel.x for panel in panels),
        *(curve.y for curve in curves),
        *(name for each in asked for name in each.where),
    }


def write_tables(study: Study, frame: pd.DataFrame, folder: Path) -> list[Path]:
    """Write all tables but those that are parts of pages; returns their Markdown."""
    written = [write_table(spec, frame, folder / "tables")[1] for spec in study.file.tables]
    for section, table in sections_of(study):
        written += section.tables(table, study, frame, folder)
    return written


def write_figures(study: Study, frame: pd.DataFrame, folder: Path) -> list[list[Path]]:
    """Draw the study's own figures; returns the paths of each."""
    measured = overlays_of(study)
    return [write_figure(spec, frame, folder, measured) for spec in study.file.figures]


def write_answers(study: Study, frame: pd.DataFrame, folder: Path) -> list[Path]:
    """Write the pages of a study's other questions, with all that is on them; returns the pages."""
    return [page for section, table in sections_of(study) for page in section.pages(table, study, frame, folder)]


def write_pages(study: Study, frame: pd.DataFrame, folder: Path) -> list[Path]:
    """Write the pages of a study's other questions, or where it has none the page of its results, which shows what
    tables and figures lie in `folder`; returns the pages.
    """
    return write_answers(study, frame, folder) or [write_results_page(study, frame, folder)]


def write_cycles(planned: Plan, frame: pd.DataFrame, folder: Path) -> list[Path]:
    """Write each limit cycle whose size is known beside its describing-function prediction; none where none is."""
    if with_cycles(frame, planned.axis).empty:
        return []
    from workbench.study.report.limit_cycles import write_limit_cycles  # a study without cycles waits for no CasADi

    return [write_limit_cycles(planned, frame, folder)]


def write_all(
    planned: Plan, frame: pd.DataFrame, folder: Path, shown: Callable[[list[Path]], None] | None = None
) -> tuple[list[Path], list[Path]]:
    """Write all that is made of finished results: the machines that were drawn, tables, which are `shown` before the
    rest is made, figures and pages; returns tables and pages.
    """
    write_draws(planned, folder)
    tables = write_tables(planned.study, frame, folder) + write_cycles(planned, frame, folder)
    if shown is not None:
        shown(tables)
    write_figures(planned.study, frame, folder)
    return tables, write_pages(planned.study, frame, folder)
