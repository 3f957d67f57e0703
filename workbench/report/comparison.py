"""Compensation against avoidance: the verdicts and tables of a study over controllers, rpm, scenarios and references.

All words are made from the numbers of the results: what a plain controller leaves with neither, where rotation beats
the best compensator, where it does not, and what it costs.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from workbench.report.tables import shown_number
from workbench.study.report_schema import ComparisonTable

CLOSE = 0.05
"""Errors and powers that differ by less than this share count as the same."""

LEAST = 1e-4
"""The least number that is told, in the unit shown (mm, ...)."""

MM = 1e3


NOTHING = "nothing is needed"


@dataclass(frozen=True)
class Best:
    """One case: its controller, rpm, error (m), solver error (m) and row of the results."""

    controller: str
    rpm: float
    error: float
    solver_error: float
    row: pd.Series

    @property
    def words(self) -> str:
        """The case in words."""
        where = "without rotation" if self.rpm == 0 else f"at {self.rpm:g} rpm"
        return f"{plain_name(self.controller)} {where} ({self.size})"

    @property
    def size(self) -> str:
        """Its error in words."""
        return f"{_small(self.error * MM)} mm"

    @property
    def cost(self) -> str:
        """What its rotation costs, in words."""
        rotary, electric = self.row["rotation_power_W"], self.row["motor_electric_power_W"]
        return f"{_watts(rotary)} at the rod, {_watts(electric)} at the motor's terminals"


@dataclass(frozen=True)
class Verdict:
    """What the cases of one scenario and reference say: which side wins, and in full."""

    kind: str
    words: str


@dataclass(frozen=True)
class Pivot:
    """One table: a figure of the results for one scenario and reference, a row an rpm, a column a controller."""

    name: str
    scenario: str
    title: str
    cells: pd.DataFrame


def plain_name(name: str) -> str:
    """The name of a controller, scenario or reference as a reader sees it."""
    return name.replace("_", " ")


def rule(spec: ComparisonTable) -> str:
    """In words, when two errors count as different."""
    return (
        f"Two errors count as different only if they differ by more than {CLOSE * 100:g} % of the larger, by more than "
        f"{spec.negligible * MM:g} mm, and by more than their solver errors together; else they are level."
    )


def beats(spec: ComparisonTable, one: Best, other: Best) -> bool:
    """Whether the error of `one` is below that of `other` by a difference that counts (see `rule`)."""
    margin = max(CLOSE * max(one.error, other.error), spec.negligible, one.solver_error + other.solver_error)
    return other.error - one.error > margin


def cases_of(rows: pd.DataFrame, error: str) -> list[Best]:
    """The cases of `rows` that have an `error`."""
    known = rows.dropna(subset=[error])
    return [
        Best(
            str(row["controller"]),
            float(row["rpm"]),
            float(row[error]),
            0.0 if pd.isna(row["solver_error_m"]) else float(row["solver_error_m"]),
            row,
        )
        for _, row in known.iterrows()
    ]


def best(cases: list[Best]) -> Best:
    """The case with the least error."""
    return min(cases, key=lambda case: case.error)


def cheapest(cases: list[Best]) -> Best:
    """At the rpm where the motor draws least, the case with the least error."""
    rpm = min(cases, key=lambda case: float(case.row["motor_electric_power_W"])).rpm
    return best([case for case in cases if case.rpm == rpm])


def error_column(spec: ComparisonTable, reference: str) -> str:
    """What counts as the error of a reference: the steady-state error of steps, the rms error of motion."""
    return "steady_state_error_m" if reference in spec.steps else "rms_error_m"


def sentences(spec: ComparisonTable, frame: pd.DataFrame) -> dict[str, list[str]]:
    """By scenario, what its tables say: a verdict a reference, and a sentence about limit cycles."""
    found: dict[str, list[str]] = {}
    for (scenario, reference), verdict in verdicts(spec, frame).items():
        found.setdefault(scenario, []).append(f"{plain_name(reference).capitalize()}: {verdict.words}")
    return {name: [*lines, _hunting(frame[frame["scenario"] == name])] for name, lines in found.items()}


def verdicts(spec: ComparisonTable, frame: pd.DataFrame) -> dict[tuple[str, str], Verdict]:
    """By scenario and reference, what its cases say."""
    return {
        (str(scenario), str(reference)): _verdict(spec, cases_of(rows, error_column(spec, str(reference))))
        for (scenario, reference), rows in frame.groupby(["scenario", "reference"], sort=False)
    }


def _verdict(spec: ComparisonTable, cases: list[Best]) -> Verdict:
    """What the cases of one scenario and reference say."""
    neither, compensated, rotated, both = (
        [case for case in cases if (case.controller in spec.plain) == plain and (case.rpm > 0) == turning]
        for plain, turning in ((True, False), (False, False), (True, True), (False, True))
    )
    if not (neither and compensated and rotated):
        return Verdict("no comparison", "no comparison, since no case of one side has an error.")
    bare, top, compensation = best(neither), best(cases), best(compensated)
    if bare.error <= spec.negligible:
        simplest = next(case for case in neither if case.error <= spec.negligible)
        return Verdict(NOTHING, f"nothing is needed: {simplest.words} is within {spec.negligible * MM:g} mm.")
    if not beats(spec, top, bare):
        return Verdict(NOTHING, f"nothing is needed: {bare.words} is level with the best of all, {top.words}.")
    start = f"with neither, {plain_name(bare.controller)} leaves {bare.size}. "
    idle = "" if beats(spec, compensation, bare) else ", by this rule no better than neither"
    together = [case for case in both if beats(spec, case, compensation) and beats(spec, case, best(rotated))]
    end = f" Both together beat either alone: {_offers(spec, together)}." if together else ""
    found = _against(spec, compensation, idle, rotated)
    return Verdict(found.kind, start + found.words + end)


def _against(spec: ComparisonTable, compensation: Best, idle: str, rotated: list[Best]) -> Verdict:
    """Rotation without compensation against the best compensation without rotation."""
    winning = [case for case in rotated if beats(spec, case, compensation)]
    if winning:
        words = f"Rotation beats compensation, {compensation.words}{idle}: {_offers(spec, winning)}."
        return Verdict("rotation beats compensation", words)
    compensated = f"Compensation, {compensation.words}{idle},"
    if beats(spec, compensation, best(rotated)):
        least = _cheapest_of_the_best(spec, rotated)
        words = f"{compensated} beats rotation, {least.words}, which would have cost {least.cost}."
        return Verdict("compensation beats rotation", words)
    level = cheapest([case for case in rotated if not beats(spec, compensation, case)])
    return Verdict("level", f"{compensated} and rotation, {level.words}, are level; rotation costs {level.cost}.")


def _cheapest_of_the_best(spec: ComparisonTable, cases: list[Best]) -> Best:
    """The cheapest of those that the best one does not beat."""
    top = best(cases)
    return cheapest([case for case in cases if not beats(spec, top, case)])


def _offers(spec: ComparisonTable, cases: list[Best]) -> str:
    """The cheapest of rotating cases, and the one that does best if it is better."""
    first, top = cheapest(cases), _cheapest_of_the_best(spec, cases)
    words = f"cheapest with {first.words}, {first.cost}"
    return f"{words}; best with {top.words}, {top.cost}" if beats(spec, top, first) else words


def _watts(power: float) -> str:
    return f"{shown_number(power / 1e3, 2)} kW" if power >= 995.0 else f"{shown_number(power, 2)} W"


def _small(number: float) -> str:
    """A number with three digits; what is smaller than `LEAST` is not told."""
    return f"< {LEAST:g}" if abs(number) < LEAST else f"{number:.3g}"


def _hunting(rows: pd.DataFrame) -> str:
    judged = rows.dropna(subset=["limit_cycle"])
    hunting = judged[judged["limit_cycle"] == "sustained"]
    if judged.empty:
        return "Limit cycles were not judged: no reference holds still."
    if hunting.empty:
        return f"No sustained limit cycle in any of {len(judged)} cases with steps."
    parts = []
    for controller, group in hunting.groupby("controller", sort=False):
        speeds = ", ".join(f"{rpm:g}" for rpm in sorted(group["rpm"]))
        largest = group["limit_cycle_amplitude_m"].max() * MM
        parts.append(f"{plain_name(str(controller))} at {speeds} rpm (up to {largest:.3g} mm peak to peak)")
    return f"Sustained limit cycles: {'; '.join(parts)}."


def exactness(spec: ComparisonTable, frame: pd.DataFrame) -> str:
    """In words, how many cases have an error that is hardly larger than that of their integration."""
    error = frame["rms_error_m"].where(~frame["reference"].isin(spec.steps), frame["steady_state_error_m"])
    doubtful = frame["solver_error_m"] > 0.1 * error
    told = doubtful & (error > spec.negligible)
    return (
        f"{doubtful.sum()} of {len(frame)} cases have a solver error above 10 % of their error; in {told.sum()} of "
        f"these the error is above {spec.negligible * MM:g} mm."
    )


def pivots(spec: ComparisonTable, frame: pd.DataFrame) -> Iterator[Pivot]:
    """All tables that hold anything, scenario by scenario."""
    for scenario in frame["scenario"].unique():
        part = frame[frame["scenario"] == scenario]
        for reference in part["reference"].unique():
            rows = part[part["reference"] == reference]
            for column, label, scale in _figures_of(spec, reference):
                if rows[column].isin(["none"]).eq(rows[column].notna()).all():
                    continue
                cells = rows.pivot(index="rpm", columns="controller", values=column)
                cells = cells[[name for name in rows["controller"].unique() if name in cells]]
                shown = cells.map(lambda value, scale=scale: _cell(value, scale))
                yield Pivot(
                    f"{scenario}_{reference}_{column}",
                    str(scenario),
                    f"{label}: {plain_name(scenario)}, {plain_name(reference)}",
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
    return value if isinstance(value, str) else _small(float(str(value)) * scale)


def write_tables(spec: ComparisonTable, frame: pd.DataFrame, folder: Path) -> list[Pivot]:
    """Write every table as CSV, Markdown and LaTeX; returns them."""
    folder.mkdir(parents=True, exist_ok=True)
    made = list(pivots(spec, frame))
    for pivot in made:
        pivot.cells.to_csv(folder / f"{pivot.name}.csv", index=False, lineterminator="\n")
        (folder / f"{pivot.name}.md").write_text(
            f"**{pivot.title}**\n\n{pivot.cells.to_markdown(index=False)}\n", encoding="utf-8"
        )
        latex = pivot.cells.map(lambda text: str(text).replace("_", r"\_").replace("<", "$<$"))
        latex.columns = [str(name).replace("_", r"\_") for name in latex.columns]
        text = latex.style.hide(axis="index").to_latex(hrules=True, caption=pivot.title, label=f"tab:{pivot.name}")
        (folder / f"{pivot.name}.tex").write_text(text, encoding="utf-8")
    return made
