"""What a study asks to be made of its results: tables, figures, and what its other questions make of them."""

from pathlib import Path

import pandas as pd

from workbench.study.plan import Plan
from workbench.study.report.figures import write_figure
from workbench.study.report.page import write_results_page
from workbench.study.report.select import with_cycles
from workbench.study.report.tables import write_table
from workbench.study.sections import overlays_of, sections_of
from workbench.study.study import Study


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
