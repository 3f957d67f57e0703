"""The tables of a comparison: who was measured again with errors and intervals, and every figure over rpm."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from workbench.compare.candidates import HUNTS, MM, TOLD_SPEED, Candidate, Cell, error_column, with_all_axes
from workbench.compare.intervals import LEAST
from workbench.compare.overview import cell_name
from workbench.compare.schema import ComparisonTable
from workbench.compare.verdicts import Verdict, size_of
from workbench.compare.words import lying
from workbench.metrics.limit_cycle import HUNTING
from workbench.publish.words import plain_name


@dataclass(frozen=True)
class Pivot:
    """One table: a figure of one machine, scenario and reference, a row an rpm, a column a controller."""

    name: str
    machine: str
    scenario: str
    title: str
    cells: pd.DataFrame


def finalist_table(spec: ComparisonTable, found: Mapping[Cell, Verdict]) -> pd.DataFrame:
    """Who stood for each class, with errors, intervals and power, as text; a row each."""
    lines = []
    for cell, verdict in found.items():
        for kind, one in verdict.best.items():
            others = [other for other in verdict.candidates if other.kind == kind and other is not one]
            shown = [one, *(others if verdict.fresh else [])]
            lines += [_line(spec, cell, verdict, item, item is one) for item in shown]
    table = pd.DataFrame(lines)
    return table if table.empty or table["machine"].any() else table.drop(columns="machine")


def _flaw(one: Candidate) -> str:
    return f"{one.flaw} ({one.hunting[0]} of {one.hunting[1]})" if one.flaw == HUNTS else one.flaw


def _line(spec: ComparisonTable, cell: Cell, verdict: Verdict, one: Candidate, stands: bool) -> dict[str, str]:
    size = size_of(spec, one)
    return {
        "machine": plain_name(cell.machine),
        "scenario": plain_name(cell.scenario),
        "motion": plain_name(cell.reference),
        "verdict": verdict.kind,
        "class": one.kind,
        "candidate": one.words,
        "family": one.family,
        "stands for its class": "yes" if stands else _flaw(one),
        "draws": str(len(one.rows)),
        "error (mm)": lying(size).replace(" mm", ""),
        "terminals (W)": "" if one.rpm == 0 else _number(one.mean("motor_electric_power_W")),
        "pump (W)": _number(one.mean("supply_power_W")),
        "paid (W)": _number(one.paid),
        "torque rms (N m)": _number(one.mean("motor_torque_rms_N_m")),
    }


def pivots(spec: ComparisonTable, frame: pd.DataFrame) -> Iterator[Pivot]:
    """All tables that hold anything, machine by machine, scenario by scenario: means over the draws."""
    frame = with_all_axes(frame)
    frame = frame.assign(hunts=frame["limit_cycle"].isin(HUNTING).where(frame["limit_cycle"].notna()))
    for key, rows in frame.groupby(["machine", "scenario", "reference"], sort=False):
        cell = Cell(*map(str, key))
        labels = _speeds(rows)
        for column, label, scale in _figures_of(spec, cell.reference):
            numbers = pd.to_numeric(rows[column])
            if numbers.isna().all() or (column in ("hunts", "limit_cycle_amplitude_m") and not numbers.any()):
                continue
            means = rows.assign(**{column: numbers}).pivot_table(column, "rpm", "controller", "mean", sort=False)
            means = means.reindex(index=sorted(means.index), columns=list(rows["controller"].unique())).dropna(
                how="all"
            )
            shown = means.map(lambda value, scale=scale: _number(value, scale, LEAST * MM / scale))
            shown.insert(0, "rotation (rpm)", [labels[float(rpm)] for rpm in shown.index])
            yield Pivot(
                "_".join([*filter(None, cell), column]),
                cell.machine,
                cell.scenario,
                f"{label}: {plain_name(cell.machine)} {cell_name(cell)}".replace("  ", " "),
                shown.reset_index(drop=True),
            )


def _speeds(rows: pd.DataFrame) -> dict[float, str]:
    """Each commanded speed as a row is called: with the real one where it is another."""
    labels = {}
    for rpm, part in rows.groupby("rpm"):
        command = float(str(rpm))
        real = part["rotation_speed_mean_rpm"].mean()
        off = abs(real - command) > TOLD_SPEED * command
        labels[command] = f"{command:g} (really {real:.3g})" if off and command else f"{command:g}"
    return labels


def _figures_of(spec: ComparisonTable, reference: str) -> list[tuple[str, str, float]]:
    error = error_column(spec, reference)
    power = [
        ("motor_electric_power_W", "power at the motor's terminals (W)", 1.0),
        ("supply_power_W", "pump power (W)", 1.0),
        ("paid_power_W", "paid power, pump and terminals (W)", 1.0),
    ]
    hunts = [
        ("hunts", "share of draws that hunt", 1.0),
        ("limit_cycle_amplitude_m", "limit cycle, peak to peak (mm)", MM),
    ]
    if reference in spec.steps:
        return [(error, "largest error at the end of a dwell (mm)", MM), *hunts, *power]
    motion = [
        (error, "rms error (mm)", MM),
        ("max_error_m", "largest error (mm)", MM),
        ("phase_lag_deg", "phase lag (deg)", 1.0),
    ]
    return [*motion, *hunts, *power]


def _number(value: object, scale: float = 1.0, least: float = 0.0) -> str:
    """A number with three digits; empty where the figure does not apply, and what is too small to be told is not."""
    number = float(str(value)) if value is not None else float("nan")
    if number != number:
        return ""
    return f"< {least * scale:g}" if abs(number) < least else f"{number * scale:.3g}"


def write_tables(
    spec: ComparisonTable, frame: pd.DataFrame, found: Mapping[Cell, Verdict], folder: Path
) -> list[Pivot]:
    """Write every table as CSV, Markdown and LaTeX; returns the pivots."""
    folder.mkdir(parents=True, exist_ok=True)
    made = list(pivots(spec, frame))
    for pivot in made:
        _write(pivot.name, pivot.title, pivot.cells, folder)
    _write("finalists", "Who stood for each class", finalist_table(spec, found), folder)
    return made


def _write(name: str, title: str, cells: pd.DataFrame, folder: Path) -> None:
    cells.to_csv(folder / f"{name}.csv", index=False, lineterminator="\n")
    body = cells.to_markdown(index=False, disable_numparse=True)
    (folder / f"{name}.md").write_text(f"**{title}**\n\n{body}\n", encoding="utf-8")
    latex = cells.map(lambda text: str(text).replace("_", r"\_").replace("<", "$<$"))
    latex.columns = [str(column).replace("_", r"\_") for column in latex.columns]
    text = latex.style.hide(axis="index").to_latex(hrules=True, caption=title, label=f"tab:{name}")
    (folder / f"{name}.tex").write_text(text, encoding="utf-8")
