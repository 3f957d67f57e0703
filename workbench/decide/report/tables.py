"""The candidates of a decision as a table of text."""

import math

import pandas as pd

from workbench.decide.candidate import CandidateResult
from workbench.decide.report.answer import failure
from workbench.decide.report.names import ERRORS, MM, interval, percent, share
from workbench.decide.result import Decision
from workbench.decide.schema import DecideTable
from workbench.publish.tables import shown_number
from workbench.publish.words import plain_name

_DRAWN = ("search", "fresh", "probability (95 %)", "its interval (mm)")
"""What a single machine does not have."""


def candidate_table(decision: Decision) -> pd.DataFrame:
    """A row a candidate at the speed and spread that were asked for, the best first; one machine has no interval."""
    table = decision.table
    searched = {row.candidate: row for row in decision.asked.search}
    cells = pd.DataFrame([_cells(row, searched[row.candidate], table) for row in decision.asked.ordered])
    return cells if decision.plan.several else cells.drop(columns=list(_DRAWN))


def _cells(row: CandidateResult, search: CandidateResult, table: DecideTable) -> dict[str, str]:
    fresh = row.stage == "fresh"
    return {
        "candidate": plain_name(row.controller),
        "rotation (rpm)": f"{row.rpm:g}",
        "really (rpm)": _number(row.real_rpm) if row.rpm else "0",
        "meets it": _meets(row, table),
        "search": f"{search.met} of {search.draws}",
        "fresh": f"{row.met} of {row.draws}" if fresh else "-",
        "probability (95 %)": f"{share(row.probability)} ({interval(row)})" if fresh else "-",
        f"{ERRORS[table.figure]}, {percent(table)} (mm)": _number(row.error * MM),
        "its interval (mm)": f"{_number(row.error_low * MM)} to {_number(row.error_high * MM)}",
        "mean power (W)": _number(row.mean_power),
        "pump (W)": _number(row.pump),
        "motor (W)": _number(row.motor),
        "most often fails": failure(row) if row.failures else "-",
        "outcome": row.outcome,
    }


def short_table(decision: Decision) -> pd.DataFrame:
    """The same without what a terminal has no room for."""
    dropped = ["really (rpm)", "its interval (mm)", "pump (W)", "motor (W)", "outcome"]
    return candidate_table(decision).drop(columns=dropped, errors="ignore")


def _meets(row: CandidateResult, table: DecideTable) -> str:
    """What its draws tell: those of the search rule out, and no more."""
    standing = row.standing(table)
    if row.draws > 1 and row.stage == "search" and standing != "fails":
        return "not measured"
    return {"meets": "yes", "fails": "no", "open": "cannot be told"}[standing]


def _number(value: float) -> str:
    """A number with three digits; what has no bound or no run is a dash."""
    return shown_number(value, 3) if math.isfinite(value) else "-"
