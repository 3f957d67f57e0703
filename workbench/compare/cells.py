"""From the rows of results to the candidates of each cell."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from workbench.compare.candidates import HUNTS, NOWHERE_JUDGED, Candidate, Cell, Family, HuntingCount
from workbench.compare.schema import ComparisonTable
from workbench.metrics.limit_cycle import HUNTING
from workbench.simulation.run import COMPLETED

Cells = Mapping[Cell, list[Candidate]]
"""The candidates of each cell, in the order of the results."""

Place = tuple[str, str, str, float]
"""Machine, scenario, controller and rpm: where a limit cycle is judged, whatever the reference."""


def error_column(table: ComparisonTable, reference: str) -> str:
    """What counts as the error of a reference: the largest at the end of a dwell for steps, the rms error of motion."""
    return "steady_state_max_error_m" if reference in table.steps else "rms_error_m"


def family_of(table: ComparisonTable, controller: str) -> Family:
    """The family of a controller."""
    return "plain" if controller in table.plain else "pressure" if controller in table.pressure else "friction model"


def with_all_axes(frame: pd.DataFrame) -> pd.DataFrame:
    """The results with a column for each axis of a comparison: one machine, scenario or draw where there is no axis."""
    filled: dict[str, str | int] = {"machine": "", "scenario": "nominal", "draw": 1}
    for name, value in filled.items():
        if name not in frame:
            frame = frame.assign(**{name: value})
    return frame


def of_tuned(table: ComparisonTable, frame: pd.DataFrame) -> pd.DataFrame:
    """The results without controllers whose gains are those before."""
    return frame[~frame["controller"].isin(list(table.before.values()))]


def cells_of(table: ComparisonTable, frame: pd.DataFrame) -> Cells:
    """The candidates of each cell, in the order of the results."""
    frame = with_all_axes(frame)
    hunting = hunting_counts(frame)
    cells: dict[Cell, list[Candidate]] = {}
    names = ["machine", "scenario", "reference", "controller", "rpm"]
    for key, rows in frame.set_index("draw").sort_index(kind="stable").groupby(names, sort=False):
        machine, scenario, reference, controller = map(str, key[:-1])
        rpm = float(str(key[-1]))
        column = error_column(table, reference)
        counted = hunting.get((machine, scenario, controller, rpm), NOWHERE_JUDGED)
        flaw = _flaw(rows, column, counted.hunts > 0)
        candidate = Candidate(controller, rpm, family_of(table, controller), rows, column, flaw, counted)
        cells.setdefault(Cell(machine, scenario, reference), []).append(candidate)
    return cells


def hunting_counts(frame: pd.DataFrame) -> dict[Place, HuntingCount]:
    """On how many plant samples each controller hunts at each speed; none of what is judged nowhere."""
    judged = frame[frame["limit_cycle"].notna()]
    if judged.empty:
        return {}
    names = ["machine", "scenario", "controller", "rpm"]
    hunts = judged["limit_cycle"].isin(HUNTING).groupby([judged[name] for name in (*names, "draw")]).any()
    by_place = hunts.groupby(level=names)
    hunting, of = by_place.sum(), by_place.size().to_numpy()
    return {
        place: HuntingCount(int(count), int(of_all))
        for place, count, of_all in zip(hunting.index, hunting.to_numpy(), of, strict=True)
    }


def _flaw(rows: pd.DataFrame, error: str, hunts: bool) -> str:
    """Why a candidate cannot win; empty if it can. What does not complete has that flaw, whether it hunts or not."""
    unusual = [outcome for outcome in rows["outcome"].to_numpy() if outcome != COMPLETED]
    if unusual:
        return str(unusual[0])
    if hunts:
        return HUNTS
    return "has no error" if np.isnan(rows[error].to_numpy(float)).any() else ""
