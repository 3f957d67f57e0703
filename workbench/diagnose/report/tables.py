"""Tables of a diagnosis as text: effects, errors before and after, parameters, and what each candidate was worth."""

import math
from typing import Any

import pandas as pd

from workbench.diagnose.diagnose import Diagnosis
from workbench.diagnose.report.names import ERRORS, REJECTED, interval, percent, plain, quantity, shown_unit
from workbench.diagnose.report.parameters import ENDED, Row, parameter_rows
from workbench.diagnose.report.series import scale_of, unit_of
from workbench.diagnose.selection.selection import gain
from workbench.parameters.sets import known_units
from workbench.publish.tables import shown_number
from workbench.toml.units import factor

INTERVAL = 1.96
"""Standard deviations to either side of a 95 % interval."""

NOT_IDENTIFIED = "not identified"


def effects_table(found: Diagnosis) -> pd.DataFrame:
    """effect | balance | parameter | value | left-out gain | alternatives; empty where none was found."""
    lines = [
        {
            "effect": plain(one.name),
            "balance": one.balance,
            "parameter": name,
            "value ± std": quantity(name, *number),
            "gain on left-out data": percent(one.evidence["left_out_gain"]) if "left_out_gain" in one.evidence else "",
            "cannot be told from": ", ".join(map(plain, one.alternatives)),
        }
        for one in found.found
        for name, number in one.numbers.items()
    ]
    return _without_empty(lines)


def error_table(found: Diagnosis) -> pd.DataFrame:
    """error | unit | before, after, change on the fit and on the held-out records | floor.

    Where nothing was added there is no before and after, and one column for each use.
    """
    lines = []
    errors = found.report["error"]
    keys = dict.fromkeys(key for use in errors.values() for side in ("before", "after") for key in use[side])
    for key in keys:
        words, unit, shown = ERRORS.get(key, (plain(key), "1", "1"))
        scale = factor(unit, shown)
        line = {"error (rms)": words, "unit": shown if shown != "1" else ""}
        for use, heading in (("fit", "fit"), ("held_out", "held-out")):
            before, after = (errors[use][side].get(key) for side in ("before", "after"))
            sides = (
                ((f"{heading}, before", before), (f"{heading}, after", after)) if found.found else ((heading, after),)
            )
            for words, value in sides:
                line[words] = "" if value is None else shown_number(scale * value, 3)
            if found.found and before and after is not None:
                change = percent(after / before - 1.0, 1)
                line[f"{heading}, change"] = f"+{change}" if after > before and change != "0 %" else change
        balance = next((r.balance for r in found.results if key.startswith(f"{r.balance.name}_rms")), None)
        line["noise floor"] = "" if balance is None else shown_number(scale * balance.floor, 3)
        lines.append(line)
    return _without_empty(lines)


def parameter_table(found: Diagnosis) -> pd.DataFrame:
    """parameter | unit | declared | baseline, 95 % interval | with what was found, 95 % interval | remark.

    Where nothing was found there is one fit, and one pair of columns.
    """
    lines = []
    last = "rejected" if found.report["verdict"] == REJECTED else "with effects"
    for name, row in parameter_rows(found).items():
        unit = known_units().get(name, "1")
        shown = shown_unit(unit, row.final.value)
        scale = factor(unit, shown)
        line = {
            "parameter": name,
            "unit": "" if shown == "1" else shown,
            "declared": "" if row.declared is None else shown_number(scale * row.declared, 4),
        }
        sides = (("baseline", row.baseline), (last, row.final)) if found.found else (("fitted", row.final),)
        for heading, one in sides:
            line[heading] = "" if one is None else shown_number(scale * one.value, 4)
            half = math.nan if one is None or one.doubt == ENDED else INTERVAL * scale * one.std
            line[f"{heading}, 95 % interval"] = "" if one is None else interval(scale * one.value, half)
        lines.append({**line, "remark": _remark(row, last) if found.found else NOT_IDENTIFIED * bool(row.final.doubt)})
    return _without_empty(lines)


def _remark(row: Row, last: str) -> str:
    """What a reader has to know of a parameter: of an effect, or not identified, and by which fit."""
    doubts = (("by the baseline", row.baseline is not None and row.baseline.doubt), (last, row.final.doubt))
    unsure = [words for words, doubt in doubts if doubt]
    said = ["of an effect"] if row.baseline is None else []
    return "; ".join([*said, *([f"{NOT_IDENTIFIED} {', '.join(unsure)}"] if unsure else [])])


def evidence_table(found: Diagnosis) -> pd.DataFrame:
    """balance | round | candidate | parameters | left-out rms | gain | standard errors | outcome."""
    lines = []
    for result in found.rounds:
        unit, scale = unit_of(result.balance), scale_of(result.balance)
        for number, step in enumerate(result.steps, 1):
            start = {"balance": result.balance.name, "round": str(number), "unit": unit}
            before = shown_number(scale * step.before.validated_rms, 3)
            lines.append({**start, "candidate": "nothing added", "left-out rms": before})
            for one in step.candidates:
                share, sure = gain(step.before, one.fit)
                lines.append(
                    {
                        **start,
                        "candidate": plain(one.effect),
                        "its parameters": ", ".join(quantity_of(one.fit, name) for name in one.variant),
                        "left-out rms": shown_number(scale * one.fit.validated_rms, 3),
                        "gain": percent(share, 1),
                        "standard errors": f"{sure:.1f}",
                        "outcome": outcome(step, one.effect),
                    }
                )
    return _without_empty(lines)


def quantity_of(fit: Any, name: str) -> str:
    """A fitted parameter by name, with its unit; one without a deviation was stopped by its bound."""
    if not fit.deviations[name]:
        return f"{name} at its bound"
    return f"{name} = {quantity(name, fit.values[name], fit.deviations[name])}"


def outcome(step: Any, effect: str) -> str:
    """What became of a candidate in a round."""
    if step.added is not None and step.added.effect == effect:
        return "added"
    return "as good" if effect in step.alternatives else ""


def _without_empty(lines: list[dict[str, str]]) -> pd.DataFrame:
    frame = pd.DataFrame(lines).fillna("")
    return frame.drop(columns=[name for name in frame.columns if not frame[name].any()])
