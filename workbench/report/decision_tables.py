"""Tables of a decision as text: the candidates where it was asked, and the map."""

import pandas as pd

from workbench.decide.decision import Decision
from workbench.decide.judgement import Judged
from workbench.report.comparison import plain_name
from workbench.report.decision_words import ERRORS, MM, NAMES, chance, choice, percent
from workbench.report.tables import shown_number
from workbench.study.decide_schema import DecideTable


def candidate_table(found: Decision) -> pd.DataFrame:
    """A row a candidate at the speed and spread that were asked for, the best first; one machine has no interval."""
    table = found.table
    cells = pd.DataFrame(
        [
            {
                "candidate": plain_name(row.controller),
                "rotation (rpm)": f"{row.rpm:g}",
                "meets it": _meets(row, table),
                "on": f"{row.met} of {row.draws}",
                "probability (95 %)": chance(row),
                f"{ERRORS[table.figure]}, {percent(table)} (mm)": _number(row.error * MM),
                "its interval (mm)": f"{_number(row.error_low * MM)} to {_number(row.error_high * MM)}",
                "mean power (W)": _number(row.mean_power),
                f"power, {percent(table)} (W)": _number(row.power),
                "outcome": row.outcome,
            }
            for row in found.asked
        ]
    )
    return cells if found.plan.draws > 1 else cells.drop(columns=["on", "probability (95 %)", "its interval (mm)"])


def short_table(found: Decision) -> pd.DataFrame:
    """The same without what a terminal has no room for."""
    return candidate_table(found).drop(columns=["its interval (mm)", "outcome"], errors="ignore")


def _meets(row: Judged, table: DecideTable) -> str:
    said = "yes" if row.meets(table) else "no"
    return said if row.settled(table) else f"{said}, unsettled"


def _number(value: float) -> str:
    """A number with three digits; what has no bound or no run is a dash."""
    return shown_number(value, 3) if abs(value) < float("inf") else "-"


def map_table(found: Decision) -> pd.DataFrame:
    """What suffices, a row a spread, a column a speed: the kind, the winning choice and its probability."""
    lines = []
    for spread in found.plan.spreads:
        line = {"spread of friction": f"{spread:g}"}
        for speed in found.plan.speeds:
            given = found.answer(speed, spread)
            mark = "" if given.settled else "?"
            line[f"{speed * MM:g} mm/s"] = (
                f"{NAMES[given.kind]}: {choice(given.best)}, {given.best.probability:.2f}{mark}"
            )
        lines.append(line)
    return pd.DataFrame(lines)
