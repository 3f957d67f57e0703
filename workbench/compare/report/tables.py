"""The tables of a comparison: who was measured again with errors and intervals, and every metric over rpm."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from workbench.compare.candidates import HUNTS, MM, Candidate, Cell, turning_words
from workbench.compare.cells import error_column
from workbench.compare.intervals import LEAST
from workbench.compare.report.matrix import NOTATION, matrices
from workbench.compare.report.words import lying
from workbench.compare.result import Comparison, Verdict
from workbench.compare.schema import ComparisonTable
from workbench.metrics.limit_cycle import HUNTING
from workbench.publish.tables import Table, write_frame
from workbench.publish.words import plain_name


@dataclass(frozen=True)
class Pivot:
    """One table: a metric of one machine, scenario and reference, a row an rpm, a column a controller."""

    name: str
    machine: str
    scenario: str
    title: str
    cells: pd.DataFrame


@dataclass(frozen=True)
class Metric:
    """What a pivot holds: a column of the results, its words, and what to multiply it with to show it."""

    column: str
    label: str
    scale: float = 1.0


VERDICTS, FINALISTS = "verdicts", "finalists"
"""Names of the tables of all fields, and of those who were measured again."""

HUNTING_METRICS = (
    Metric("hunts", "share of draws that hunt"),
    Metric("limit_cycle_amplitude_m", "limit cycle, peak to peak (mm)", MM),
)
"""Shown only where something hunts."""

POWER_METRICS = (
    Metric("motor_electric_power_W", "power at the motor's terminals (W)"),
    Metric("supply_power_W", "pump power (W)"),
    Metric("paid_power_W", "paid power, pump and terminals (W)"),
)


def metrics_of(table: ComparisonTable, reference: str) -> list[Metric]:
    """What is tabulated of a reference."""
    error = error_column(table, reference)
    if reference in table.steps:
        return [Metric(error, "largest error at the end of a dwell (mm)", MM), *HUNTING_METRICS, *POWER_METRICS]
    motion = [
        Metric(error, "rms error (mm)", MM),
        Metric("max_error_m", "largest error (mm)", MM),
        Metric("phase_lag_deg", "phase lag (deg)"),
    ]
    return [*motion, *HUNTING_METRICS, *POWER_METRICS]


def verdict_table(comparison: Comparison) -> pd.DataFrame:
    """The matrices as one table, as text: a row a field, with its verdict, margin and price."""
    lines = [
        {
            "machine": plain_name(matrix.machine),
            "scenario": plain_name(row.scenario),
            "motion": plain_name(reference),
            "verdict": field.word,
            "margin": field.margin,
            "price": field.price,
        }
        for matrix in matrices(comparison)
        for row in matrix.rows
        for reference, field in zip(matrix.references, row.fields, strict=True)
        if field is not None
    ]
    cells = pd.DataFrame(lines)
    return cells.drop(columns=[name for name in cells.columns if not cells[name].any()])


def finalist_table(comparison: Comparison) -> pd.DataFrame:
    """Who stood for each class, with errors, intervals and power, as text; a row each."""
    lines = []
    for cell, verdict in comparison.verdicts.items():
        for kind, best in verdict.best.items():
            others = [each for each in verdict.candidates if each.kind == kind and each is not best]
            shown = [best, *(others if verdict.fresh else [])]
            lines += [_line(comparison.table, cell, verdict, each, each is best) for each in shown]
    cells = pd.DataFrame(lines)
    return cells if cells.empty or cells["machine"].any() else cells.drop(columns="machine")


def _line(table: ComparisonTable, cell: Cell, verdict: Verdict, candidate: Candidate, stands: bool) -> dict[str, str]:
    size = candidate.mean_error(table.probability)
    return {
        "machine": plain_name(cell.machine),
        "scenario": plain_name(cell.scenario),
        "motion": plain_name(cell.reference),
        "verdict": verdict.kind,
        "class": candidate.kind,
        "candidate": candidate.words,
        "family": candidate.family,
        "stands for its class": "yes" if stands else _flaw(candidate),
        "draws": str(candidate.samples),
        "error (mm)": lying(size).replace(" mm", ""),
        "terminals (W)": "" if candidate.rpm == 0 else _number(candidate.terminal_power),
        "pump (W)": _number(candidate.pump_power),
        "paid (W)": _number(candidate.paid_power),
        "torque rms (N m)": _number(candidate.motor_torque),
    }


def _flaw(candidate: Candidate) -> str:
    hunting = candidate.hunting
    return f"{candidate.flaw} ({hunting.hunts} of {hunting.samples})" if candidate.flaw == HUNTS else candidate.flaw


def pivots(comparison: Comparison) -> Iterator[Pivot]:
    """All tables that hold anything, machine by machine, scenario by scenario: means over the plant samples."""
    frame = comparison.tuned
    frame = frame.assign(hunts=frame["limit_cycle"].isin(HUNTING).where(frame["limit_cycle"].notna()))
    for key, rows in frame.groupby(["machine", "scenario", "reference"], sort=False):
        cell = Cell(*map(str, key))
        for metric in metrics_of(comparison.table, cell.reference):
            numbers = pd.to_numeric(rows[metric.column])
            if numbers.isna().all() or (metric in HUNTING_METRICS and not numbers.any()):
                continue
            yield Pivot(
                "_".join([*filter(None, cell), metric.column]),
                cell.machine,
                cell.scenario,
                f"{metric.label}: {plain_name(cell.machine)} {cell.words}".replace("  ", " "),
                _means(rows.assign(**{metric.column: numbers}), metric),
            )


def _means(rows: pd.DataFrame, metric: Metric) -> pd.DataFrame:
    """The means of a metric as text, by rpm and controller, with the real speed where it is another."""
    means = rows.pivot_table(metric.column, "rpm", "controller", "mean", sort=False)
    means = means.reindex(index=sorted(means.index), columns=list(rows["controller"].unique())).dropna(how="all")
    shown = means.map(lambda value: _number(value, metric.scale, LEAST * MM / metric.scale))
    real = pd.to_numeric(rows["rotation_speed_mean_rpm"]).groupby(rows["rpm"]).mean()
    shown.insert(0, "rotation (rpm)", [turning_words(float(rpm), float(real[rpm])) for rpm in shown.index])
    return shown.reset_index(drop=True)


def _number(value: float, scale: float = 1.0, least: float = 0.0) -> str:
    """A number with three digits; empty where the metric does not apply, and what is too small to be told is not."""
    if math.isnan(value):
        return ""
    return f"< {least * scale:g}" if abs(value) < least else f"{value * scale:.3g}"


def write_tables(comparison: Comparison, folder: Path) -> list[Pivot]:
    """Write every table as CSV, Markdown and LaTeX; returns the pivots."""
    made = list(pivots(comparison))
    for pivot in made:
        write_frame(pivot.name, Table(pivot.title, pivot.cells), folder)
    write_frame(VERDICTS, Table("Compensate or avoid", verdict_table(comparison), [NOTATION]), folder)
    write_frame(FINALISTS, Table("Who stood for each class", finalist_table(comparison)), folder)
    return made
