"""What a study asks to be made of its results: tables and figures; the page of a comparison is made above."""

from pathlib import Path

import pandas as pd

from workbench.report.break_even import write_break_even
from workbench.report.figures import write_figure
from workbench.report.friction_curves import write_friction_curves
from workbench.report.limit_cycles import write_limit_cycles
from workbench.report.tables import write_table
from workbench.study.document import Study
from workbench.study.friction_curves import curves_of
from workbench.study.runner import Plan


def write_tables(study: Study, frame: pd.DataFrame, folder: Path) -> list[Path]:
    """Write all tables but those of a comparison, which are parts of its page; returns their Markdown."""
    written = [write_table(spec, frame, folder / "tables")[1] for spec in study.file.tables]
    written += [write_break_even(spec, frame, folder / "tables") for spec in study.file.break_even]
    return written + write_friction_curves(study, frame, folder)


def write_figures(study: Study, frame: pd.DataFrame, folder: Path) -> list[list[Path]]:
    """Draw all figures but those of a comparison or of friction curves; returns the paths of each."""
    measured = curves_of(study)
    return [write_figure(spec, frame, folder, measured) for spec in study.file.figures]


def write_cycles(planned: Plan, frame: pd.DataFrame, folder: Path) -> list[Path]:
    """Write each limit cycle beside its describing-function prediction; none where nothing cycles."""
    if not frame["limit_cycle"].isin(["sustained", "decaying", "too_short"]).any():
        return []
    return [write_limit_cycles(planned, frame, folder)]
