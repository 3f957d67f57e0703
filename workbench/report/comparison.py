"""Compensation against avoidance: tables, figures and a page of a study over controllers, rpm, scenarios, references.

All words are made from the numbers of the results: where rotation beats the best compensator, where it does not, and
what it costs.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from workbench.report.tables import shown_number
from workbench.study.schema import ComparisonTable

CLOSE = 0.05
"""Two errors that differ by less than this share count as the same."""

LEAST = 1e-7
"""m. Smaller errors are not told: they are the integration's."""

MM = 1e3


@dataclass(frozen=True)
class Best:
    """The case with the least error of a group: its controller, rpm, error (m) and row of the results."""

    controller: str
    rpm: float
    error: float
    row: pd.Series

    @property
    def words(self) -> str:
        """The case in words."""
        where = "without rotation" if self.rpm == 0 else f"at {self.rpm:g} rpm"
        size = f"{self.error * MM:.3g} mm" if self.error >= LEAST else f"under {LEAST * MM:g} mm"
        return f"{_plain(self.controller)} {where} ({size})"


@dataclass(frozen=True)
class Pivot:
    """One table: a figure of the results for one scenario and reference, a row an rpm, a column a controller."""

    name: str
    title: str
    cells: pd.DataFrame


def best(rows: pd.DataFrame, error: str) -> Best | None:
    """The row with the least `error` among those that have one; None where there is none."""
    known = rows.dropna(subset=[error])
    if known.empty:
        return None
    row = known.iloc[int(np.argmin(known[error].to_numpy(float)))]
    return Best(str(row["controller"]), float(row["rpm"]), float(row[error]), row)


def cheapest(rows: pd.DataFrame, error: str, limit: float) -> Best | None:
    """The row whose motor draws least among those with an `error` below `limit`; None where there is none."""
    known = rows[rows[error].astype(float) < limit]
    if known.empty:
        return None
    order = known.sort_values(["motor_electric_power_W", error], kind="stable")
    return best(order.iloc[:1], error)


def error_column(spec: ComparisonTable, reference: str) -> str:
    """What counts as the error of a reference: the steady-state error of steps, the rms error of motion."""
    return "steady_state_error_m" if reference in spec.steps else "rms_error_m"


def pivots(spec: ComparisonTable, frame: pd.DataFrame) -> Iterator[Pivot]:
    """All tables, scenario by scenario."""
    for scenario in frame["scenario"].unique():
        part = frame[frame["scenario"] == scenario]
        for reference in part["reference"].unique():
            rows = part[part["reference"] == reference]
            for column, label, scale in _figures_of(spec, reference):
                cells = rows.pivot(index="rpm", columns="controller", values=column)
                cells = cells[[name for name in rows["controller"].unique() if name in cells]]
                shown = cells.map(lambda value, scale=scale: _cell(value, scale))
                yield Pivot(
                    f"{scenario}_{reference}_{column}",
                    f"{label}: {_plain(scenario)}, {_plain(reference)}",
                    shown.reset_index().rename(columns={"rpm": "rotation (rpm)"}),
                )


def _figures_of(spec: ComparisonTable, reference: str) -> list[tuple[str, str, float]]:
    power = [("total_power_W", "hydraulic plus rotary power (W)", 1.0), ("supply_power_W", "pump power (W)", 1.0)]
    if reference in spec.steps:
        return [
            ("steady_state_error_m", "steady-state error (mm)", MM),
            ("limit_cycle", "limit cycle", 1.0),
            ("limit_cycle_amplitude_m", "limit cycle, peak to peak (mm)", MM),
        ]
    return [
        ("phase_lag_deg", "phase lag (deg)", 1.0),
        ("rms_error_m", "rms error (mm)", MM),
        ("max_error_m", "largest error (mm)", MM),
        *power,
    ]


def _cell(value: object, scale: float) -> str:
    if value is None or value != value:
        return ""
    return value if isinstance(value, str) else f"{float(str(value)) * scale:.3g}"


def _plain(name: str) -> str:
    return name.replace("_", " ")


def sentences(spec: ComparisonTable, frame: pd.DataFrame) -> dict[str, list[str]]:
    """By scenario, what its tables say: one sentence a reference, and one about limit cycles."""
    found: dict[str, list[str]] = {}
    for scenario in frame["scenario"].unique():
        part = frame[frame["scenario"] == scenario]
        lines = [
            _verdict(spec, reference, part[part["reference"] == reference]) for reference in part["reference"].unique()
        ]
        found[str(scenario)] = [*lines, _hunting(part)]
    return found


def _verdict(spec: ComparisonTable, reference: str, rows: pd.DataFrame) -> str:
    error = error_column(spec, reference)
    plain = rows["controller"].isin(spec.plain)
    compensation = best(rows[~plain & (rows["rpm"] == 0)], error)
    avoidance = best(rows[plain & (rows["rpm"] > 0)], error)
    both = best(rows, error)
    subject = f"{_plain(reference).capitalize()}:"
    if compensation is None or avoidance is None or both is None:
        return f"{subject} no comparison, since no case of one side completed."
    level = max(compensation.error, spec.negligible)
    enough = cheapest(rows[plain & (rows["rpm"] > 0)], error, spec.negligible)
    better = cheapest(rows[plain & (rows["rpm"] > 0)], error, (1.0 - CLOSE) * compensation.error)
    if compensation.error < spec.negligible and enough is not None:
        return (
            f"{subject} compensation and rotation are both exact to {spec.negligible * MM:g} mm, "
            f"{compensation.words} and {enough.words}; rotation costs {_cost(enough)}."
        )
    if compensation.error < spec.negligible:
        verdict = (
            f"compensation is exact to {spec.negligible * MM:g} mm, {compensation.words}; rotation is not, "
            f"{avoidance.words}, at a cost of {_cost(avoidance)}"
        )
    elif better is not None:
        verdict = f"rotation beats compensation, {compensation.words}: from {better.words} on, at {_cost(better)}"
        if better.rpm != avoidance.rpm:
            verdict += f"; it does best with {avoidance.words}, at {_cost(avoidance)}"
    elif avoidance.error > (1.0 + CLOSE) * compensation.error:
        verdict = (
            f"compensation beats rotation, {compensation.words} against {avoidance.words}, "
            f"which would have cost {_cost(avoidance)}"
        )
    else:
        verdict = f"the two are level, {compensation.words} and {avoidance.words}, which costs {_cost(avoidance)}"
    together = ""
    if both.rpm > 0 and both.controller not in spec.plain and both.error < (1.0 - CLOSE) * min(level, avoidance.error):
        together = f" Both together do best: {both.words}."
    return f"{subject} {verdict}.{together}"


def _cost(case: Best) -> str:
    rotary, electric = case.row["rotation_power_W"], case.row["motor_electric_power_W"]
    return f"{_watts(rotary)} at the rod, {_watts(electric)} at the motor's terminals"


def _watts(power: float) -> str:
    return f"{shown_number(power / 1e3, 2)} kW" if power >= 995.0 else f"{shown_number(power, 2)} W"


def _hunting(rows: pd.DataFrame) -> str:
    judged = rows.dropna(subset=["limit_cycle"])
    hunting = judged[judged["limit_cycle"] == "sustained"]
    if judged.empty:
        return "Limit cycles were not judged: no reference holds still."
    if hunting.empty:
        return f"No limit cycle in any of {len(judged)} cases with steps."
    parts = []
    for controller, group in hunting.groupby("controller", sort=False):
        speeds = ", ".join(f"{rpm:g}" for rpm in sorted(group["rpm"]))
        largest = group["limit_cycle_amplitude_m"].max() * MM
        parts.append(f"{_plain(str(controller))} at {speeds} rpm (up to {largest:.3g} mm peak to peak)")
    return f"Sustained limit cycles: {'; '.join(parts)}."


def write_tables(spec: ComparisonTable, frame: pd.DataFrame, folder: Path) -> list[Pivot]:
    """Write every table as CSV, Markdown and LaTeX; returns them."""
    folder.mkdir(parents=True, exist_ok=True)
    made = list(pivots(spec, frame))
    for pivot in made:
        pivot.cells.to_csv(folder / f"{pivot.name}.csv", index=False, lineterminator="\n")
        (folder / f"{pivot.name}.md").write_text(
            f"**{pivot.title}**\n\n{pivot.cells.to_markdown(index=False)}\n", encoding="utf-8"
        )
        latex = pivot.cells.map(lambda text: str(text).replace("_", r"\_"))
        latex.columns = [str(name).replace("_", r"\_") for name in latex.columns]
        text = latex.style.hide(axis="index").to_latex(hrules=True, caption=pivot.title, label=f"tab:{pivot.name}")
        (folder / f"{pivot.name}.tex").write_text(text, encoding="utf-8")
    return made
