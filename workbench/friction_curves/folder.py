"""Measured friction-velocity curves against what the bristle laws predict: the tables and figures of a study."""

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import pandas as pd

from workbench.friction_curves.checks import curves_of
from workbench.friction_curves.comparison import Comparison, compare
from workbench.friction_curves.figures import curves_data, draw_curves, draw_reductions, power_data, static_data
from workbench.friction_curves.power import power_table
from workbench.friction_curves.schema import FrictionCurvesTable
from workbench.friction_curves.tables import (
    effect_table,
    error_table,
    slope_table,
    slowest_table,
    static_table,
)
from workbench.friction_curves.validation import NAME, NOTE, TITLE, validation_table
from workbench.publish.pictures import save
from workbench.publish.tables import Table, write_frame
from workbench.study.study import Study

TABLES: Mapping[str, Callable[[Comparison], Table]] = {
    "friction_curve_error": error_table,
    "friction_curve_effects": effect_table,
    "added_slope": slope_table,
    "static_friction": static_table,
    "slowest_friction": slowest_table,
    "power_at_speed": power_table,
}
"""By name, in the order in which they are told."""


def write_friction_curves(spec: FrictionCurvesTable, study: Study, frame: pd.DataFrame, folder: Path) -> list[Path]:
    """Write tables and figures; returns the Markdown tables.

    The file of measured curves goes to the results as well, so that they can be drawn again.
    """
    source, copy = study.path.parent / spec.measured, folder / spec.measured
    if source.resolve() != copy.resolve() and folder.resolve() in copy.resolve().parents:
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, copy)
    found = compare(study, spec)
    for name, figure in {
        "curves_forward": draw_curves(curves_data(found, "forward"), "forward"),
        "curves_backward": draw_curves(curves_data(found, "backward"), "backward"),
        "figure_5_10": draw_reductions(static_data(found)),
        "figure_5_21": draw_reductions(power_data(found)),
    }.items():
        save(figure, name, folder / "figures")
    tables = {name: make(found) for name, make in TABLES.items()}
    validation = validation_table(study, frame, folder, curves_of(study, spec))
    if not validation.empty:
        tables[NAME] = Table(TITLE, validation, [NOTE])
    return [write_frame(name, table, folder / "tables")[1] for name, table in tables.items()]
