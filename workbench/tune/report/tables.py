"""Tables of a tuning as text: what was reached, the gains, and classic tunings of a PID beside them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from math import pi

import pandas as pd

from controllers.pid import PID
from controllers.settings import settings_of
from plants.axis import unit_along
from plants.interface import Plant
from workbench.publish.along import SHOWN
from workbench.publish.tables import REMARK, Table, shown_number, with_unit
from workbench.study.names import shown_factor, unit_of_column
from workbench.tune.objective import Score
from workbench.tune.report.rows import Basis, End, When, broken, case_labels, end_of, objective_of
from workbench.tune.result import TUNED, ControllerTuning, Quantile, Tuning, interval
from workbench.tune.schema import reference_controller, tune_table
from workbench.tune.space import RPM, THRESHOLD, Dimension, Point

DIGITS = 3

METRIC_WORDS = {
    "rms_error_m": ("rms error", "mm"),
    "max_error_m": ("largest error", "mm"),
    "steady_state_error_m": ("steady-state error", "mm"),
    "phase_lag_deg": ("phase lag", "deg"),
    "total_power_W": ("power", "W"),
    "motor_electric_power_W": ("electric power", "W"),
    "jerk_rms_m_per_s3": ("jerk, rms", "m/s^3"),
}
"""What a metric that may be weighed is called, and the unit in which it is shown."""

WIDEST = 13
"""Columns of the result that a terminal shows."""

PID_GAINS = ("kp", "ki", "kd")

Line = dict[str, str]


def tables_of(tuning: Tuning) -> dict[str, Table]:
    """Tables by name; none that is empty."""
    tables = {"tuning": result_table(tuning), "gains": gains_table(tuning), "classic": classic_table(tuning)}
    return {name: table for name, table in tables.items() if not table.cells.empty}


def brief(table: Table) -> pd.DataFrame:
    """The columns of the result that fit a terminal: without the metrics of each case where there are many."""
    if len(table.cells.columns) <= WIDEST:
        return table.cells
    kept = ("controller", "machine", "rpm", "objective", "gain margin", "phase margin", "seeds", "outcome")
    chosen = [name for name in table.cells.columns if name.startswith(kept) or " quantile, " in name]
    return table.cells[chosen]


def number(value: float | None, digits: int = DIGITS) -> str:
    """A number as a table shows it; "" where there is none."""
    if value is None or math.isnan(value):
        return ""
    return shown_number(value, digits) if math.isfinite(value) else ("infinite" if value > 0.0 else "-infinite")


def margin(value: float) -> str:
    """A margin (dB, degrees) with one decimal."""
    return f"{value:.1f}" if math.isfinite(value) else ("infinite" if value > 0.0 else "unstable")


def with_interval(quantile: Quantile, share: float) -> str:
    """The quantile of a `share` with the interval in which that of all machines is: "0.41 (0.38 to 0.47)"."""
    if math.isfinite(quantile.high):
        return f"{number(quantile.value)} ({number(quantile.low)} to {number(quantile.high)})"
    few = math.isinf(interval([0.0] * quantile.draws, share).high)
    why = "not bounded by so few draws" if few else "infinite: runs fail on too many draws"
    return f"{number(quantile.value)} ({number(quantile.low)} upwards, {why})"


# --- what was reached ---


def result_table(tuning: Tuning) -> Table:
    """controller | objective, quantiles, metrics of each case, margins, before and after | seeds | outcome."""
    table = tune_table(tuning.study)
    cells = pd.DataFrame([_result(tuned, bool(table.draws), table.quantile) for tuned in tuning.tuned]).fillna("")
    notes = [
        f"Before: with the gains of the study; after: with the tuned ones. {reference_words(tuning)}",
        "Gain and phase margin are the smallest over the cases, of the loop linearised while the rod slides.",
    ]
    if table.draws:
        notes.append(
            f"The {table.quantile:g} quantile of the objective over drawn machines, with its 95 % interval: on the "
            f"{table.draws} that the search saw, and on {table.fresh_draws} that it has not seen."
        )
    if table.seeds > 1:
        notes.append(f"Seeds differ: by how much the worst of {table.seeds} searches is above the best of them.")
    return Table("What tuning reached", _without_empty(cells), notes)


def _result(tuned: ControllerTuning, draws: bool, share: float) -> Line:
    objective = "objective, declared machine" if draws else "objective"
    line = {"controller": tuned.task.name, **{axis: str(value) for axis, value in tuned.task.at.items()}}
    for when in _WHENS:
        score = _score(tuned, when)
        line[f"{objective}, {when}"] = "" if score is None else number(score.nominal)
    for basis in _ON_DRAWS if draws else ():
        for when in _WHENS:
            tables = objective_of(tuned, when, basis)
            line[f"{share:g} quantile, {basis} draws, {when}"] = "" if tables is None else with_interval(tables, share)
    line |= _metrics(tuned)
    for heading, name in (("gain margin", "gain_dB"), ("phase margin", "phase_deg")):
        for when in _WHENS:
            score = _score(tuned, when)
            unit = name.rpartition("_")[2]
            line[f"{heading}, {when} ({unit})"] = "" if score is None else margin(getattr(score.margins, name))
    line["breaks, before"] = ", ".join(broken(tuned.start))
    line["seeds differ"] = differ_words(tuned.seeds_differ)
    return line | {"outcome": TUNED if tuned.score is not None else "no feasible gains"}


_WHENS: tuple[When, When] = ("before", "after")
_ON_DRAWS: tuple[Basis, Basis] = ("searched", "fresh")


def _score(tuned: ControllerTuning, when: When) -> Score | None:
    return tuned.start if when == "before" else tuned.score


def _metrics(tuned: ControllerTuning) -> Line:
    """Metrics that are weighed, of each case, in units that are read."""
    line: Line = {}
    axis = tuned.task.axis
    for column in tune_table(tuned.task.study).objective.used:
        words, unit = METRIC_WORDS[column]
        unit = {"mm": SHOWN[axis].unit}.get(unit, unit_along(unit, axis))
        scale = shown_factor(unit_along(unit_of_column(column), axis), unit)
        for i, label in enumerate(case_labels(tuned.task.cases)):
            for when in _WHENS:
                score = _score(tuned, when)
                heading = with_unit(", ".join(part for part in (words, plain(label), when) if part), unit)
                line[heading] = "" if score is None else _metric(score, i, column, scale)
    return line


def _metric(score: Score, case: int, column: str, scale: float) -> str:
    run = score.runs[case]
    value = run.metrics[column]
    return run.outcome if run.broken else "" if value is None else number(scale * value)


def differ_words(share: float | None) -> str:
    """By how much seeds differ: "0.4 %"; "" where there is one."""
    if share is None:
        return ""
    if math.isinf(share):
        return "one found no gains"
    return "< 0.1 %" if share < 1e-3 else f"{100.0 * share:.1f} %"


def reference_words(tuning: Tuning) -> str:
    """What the reference controller's objective is: the sum of the weights."""
    weights = sum(tune_table(tuning.study).objective.used.values())
    return f"An objective of {weights:g} is that of {reference_controller(tuning.study)} with the gains of the study."


def plain(name: str) -> str:
    """A name in words."""
    return name.replace("_", " ")


# --- gains ---


def gains_table(tuning: Tuning) -> Table:
    """controller | gain | unit | before | after | range | whether it stands at an end of it."""
    lines = [_gain_line(row) for row in gain_rows(tuning)]
    notes = ["Before: what the study says, or where that lies outside the range the end next to it."]
    if any(tuned.task.rotates for tuned in tuning.tuned):
        notes.append("Of a rotation that is tuned it is the end of the range from which the search begins.")
    return Table("Tuned gains", pd.DataFrame(lines), notes)


@dataclass(frozen=True)
class GainRow:
    """A gain of a controller (SI): before and after tuning (None: nothing was found), its range and scale by its
    dimension, and at which end of its range it stands.
    """

    controller: str
    at: Mapping[str, object]
    dimension: Dimension
    before: float
    after: float | None
    end: End


def gain_rows(tuning: Tuning) -> list[GainRow]:
    """A row a gain that was tuned."""
    return [_gain(tuned, dimension) for tuned in tuning.tuned for dimension in tuned.task.dimensions]


def _gain(tuned: ControllerTuning, dimension: Dimension) -> GainRow:
    after = None if tuned.best is None else tuned.best[dimension.name]
    end: End = "" if after is None else end_of(dimension, after)
    return GainRow(tuned.task.name, tuned.task.at, dimension, tuned.task.start[dimension.name], after, end)


def _gain_line(row: GainRow) -> Line:
    dimension = row.dimension
    unit, scale = shown_unit(dimension)
    return {
        "controller": row.controller,
        **{axis: str(value) for axis, value in row.at.items()},
        "gain": dimension.name,
        "unit": "" if unit == "1" else unit,
        "before": number(scale * row.before, 4),
        "after": "" if row.after is None else number(scale * row.after, 4),
        "min": number(scale * dimension.low, 4),
        "max": number(scale * dimension.high, 4),
        "scale": "logarithmic" if dimension.logarithmic else "linear",
        "at an end": row.end,
    }


def shown_unit(dimension: Dimension) -> tuple[str, float]:
    """The unit in which a gain is shown, and what to multiply its value in SI with."""
    return {RPM: ("rpm", 30.0 / pi), THRESHOLD: ("mm/s", 1e3)}.get(dimension.name, (dimension.unit, 1.0))


# --- classic tunings ---


@dataclass(frozen=True)
class PidRow:
    """A PID controller by its gains (SI, by name), how it came by them, and its score on the declared machine."""

    controller: str
    method: str
    gains: Mapping[str, float]
    score: Score
    remark: str = ""


def pid_rows(tuning: Tuning) -> list[PidRow]:
    """The classic tunings, and where there are any the tuned PID controllers behind them."""
    classic = [
        PidRow(each.point.name, each.point.method, each.point.settings, each.score, each.point.note)
        for each in tuning.classics
    ]
    tuned = [
        _tuned_pid(each, each.best, each.score)
        for each in tuning.tuned
        if is_pid(each) and each.best is not None and each.score is not None
    ]
    return [*classic, *tuned] if classic else []


def _tuned_pid(tuned: ControllerTuning, best: Point, score: Score) -> PidRow:
    settings = tuned.task.settings_at(best)
    return PidRow(tuned.task.name, "tuned here", {gain: getattr(settings, gain) for gain in PID_GAINS}, score)


def classic_table(tuning: Tuning) -> Table:
    """controller | method | gains | objective | margins | what it breaks | remark; the tuned PID controllers below."""
    first = tuning.tuned[0].task
    plant = first.declared(first.start)[0].setup.plant
    lines = [_pid_line(row, plant) for row in pid_rows(tuning)]
    notes = [
        "All on the declared machine, by the same objective and constraints. A classic tuning was searched for "
        "nothing: it is what its method gives."
    ]
    return Table("Classic tunings of a PID beside the tuned ones", _without_empty(pd.DataFrame(lines)), notes)


def is_pid(tuned: ControllerTuning) -> bool:
    """Whether a controller is one of the PID family."""
    return tuned.task.cases[0].controller.type == PID.name


def _pid_line(row: PidRow, plant: Plant) -> Line:
    declared = settings_of(PID.Settings)
    gains = {
        f"{gain} ({plant.unit_for(declared[gain].unit)})": number(row.gains.get(gain, 0.0) or None, 4)
        for gain in PID_GAINS
    }
    score = row.score
    return {
        "controller": row.controller,
        "method": row.method,
        **gains,
        "objective": number(score.nominal),
        "gain margin (dB)": margin(score.margins.gain_dB),
        "phase margin (deg)": margin(score.margins.phase_deg),
        "breaks": ", ".join(broken(score)),
        REMARK: row.remark,
    }


def _without_empty(cells: pd.DataFrame) -> pd.DataFrame:
    return cells.drop(columns=[name for name in cells.columns if not cells[name].any()])
