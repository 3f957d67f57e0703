"""[friction_curves]: what a study has to do with measured friction-velocity curves."""

from pathlib import Path

import pandas as pd

from workbench.friction_curves.checks import check_friction_curves, curves_of
from workbench.friction_curves.measured import DIRECTIONS
from workbench.friction_curves.schema import FrictionCurvesTable
from workbench.study.sections import Overlay, Section
from workbench.study.study import Study


def _overlays(spec: FrictionCurvesTable, study: Study) -> list[Overlay]:
    """Friction (N) over velocity (m/s), each with the sign of its direction."""
    return [
        Overlay(curve.rpm, sign * curve.speed, sign * curve.friction)
        for curve in curves_of(study, spec)
        for sign in (DIRECTIONS[curve.direction],)
    ]


def _tables(spec: FrictionCurvesTable, study: Study, frame: pd.DataFrame, folder: Path) -> list[Path]:
    from workbench.friction_curves.folder import write_friction_curves  # figures are drawn where there are results

    return write_friction_curves(spec, study, frame, folder)


FRICTION_CURVES = Section(
    name="friction_curves",
    table=FrictionCurvesTable,
    check=check_friction_curves,
    overlays=_overlays,
    tables=_tables,
)
