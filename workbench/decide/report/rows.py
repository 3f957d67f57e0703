"""The rows of a decision's results.csv."""

import math
from collections.abc import Sequence

import pandas as pd

from workbench.decide.candidate import CandidateResult
from workbench.decide.result import Cell


def results(cells: Sequence[Cell]) -> pd.DataFrame:
    """A row a candidate, speed and spread, by its fresh draws where it has such; what does not apply is empty."""
    return pd.DataFrame([_row(row, cell) for cell in cells for row in cell.rows])


def _row(row: CandidateResult, cell: Cell) -> dict[str, object]:
    answer = cell.answer()
    search = next(each for each in cell.search if each.candidate == row.candidate)
    return {
        "controller": row.controller,
        "rpm": row.rpm,
        "speed_m_per_s": row.speed,
        "spread": row.spread,
        "kind": row.kind,
        "outcome": row.outcome,
        "search_draws": search.draws,
        "search_met": search.met,
        "stage": row.stage,
        "draws": row.draws,
        "met": row.met,
        "probability": row.probability,
        "probability_low": row.low,
        "probability_high": row.high,
        "sure": row.sure,
        "standing": row.standing(cell.table),
        "chosen": answer.kind is not None and row is answer.best,
        "fails_by": row.main_failure,
        "hunting_draws": row.hunting,
        "accuracy_share": row.accurate,
        "power_share": row.within_power,
        "error_quantile_m": _finite(row.error),
        "error_quantile_low_m": _finite(row.error_low),
        "error_quantile_high_m": _finite(row.error_high),
        "mean_power_W": _finite(row.mean_power),
        "power_quantile_W": _finite(row.power),
        "pump_power_W": _finite(row.pump),
        "motor_power_W": _finite(row.motor),
        "rotation_speed_mean_rpm": _finite(row.real_rpm),
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
