"""Tables of a diagnosis as text: effects, errors before and after, parameters, and what each candidate was worth."""

from typing import Any

import pandas as pd

from workbench.diagnose.diagnose import Diagnosis
from workbench.diagnose.selection import gain
from workbench.parameters import known_units
from workbench.report.diagnosis_series import scale_of, unit_of
from workbench.report.diagnosis_words import ERRORS, REJECTED, plain, quantity, shown_unit
from workbench.report.tables import shown_number
from workbench.units import factor

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
            "gain on left-out data": f"{100.0 * one.evidence['left_out_gain']:.0f} %"
            if "left_out_gain" in one.evidence
            else "",
            "cannot be told from": ", ".join(map(plain, one.alternatives)),
        }
        for one in found.found
        for name, number in one.numbers.items()
    ]
    return _without_empty(lines)


def error_table(found: Diagnosis) -> pd.DataFrame:
    """error | unit | before, after, change on the fit and on the held-out records | floor."""
    lines = []
    errors = found.report["error"]
    keys = dict.fromkeys(key for use in errors.values() for side in ("before", "after") for key in use[side])
    for key in keys:
        words, unit, shown = ERRORS.get(key, (plain(key), "1", "1"))
        scale = factor(unit, shown)
        line = {"error (rms)": words, "unit": shown if shown != "1" else ""}
        for use, heading in (("fit", "fit"), ("held_out", "held-out")):
            before, after = (errors[use][side].get(key) for side in ("before", "after"))
            for side, value in (("before", before), ("after", after)):
                line[f"{heading}, {side}"] = "" if value is None else shown_number(scale * value, 3)
            change = "" if not before or after is None else f"{100.0 * (after / before - 1.0):+.1f} %"
            line[f"{heading}, change"] = "0 %" if change in ("+0.0 %", "-0.0 %") else change
        balance = next((r.balance for r in found.results if key.startswith(f"{r.balance.name}_rms")), None)
        line["noise floor"] = "" if balance is None else shown_number(scale * balance.floor, 3)
        lines.append(line)
    return _without_empty(lines)


def parameter_rows(found: Diagnosis) -> dict[str, dict[str, Any]]:
    """For each fitted parameter, SI: declared, baseline and corrected values with std, whether it is identified."""
    rows: dict[str, dict[str, Any]] = {}
    for result in found.fits:
        baseline, after = result.before, result.after
        for name in after.names:
            rows[name] = {"declared": found.declared.get(name)}
            if name in baseline.names:
                rows[name]["baseline"] = (baseline.values[name], baseline.deviations[name])
                rows[name]["identified"] = found.report["baseline"].get(name, {}).get("identified", True)
            rows[name]["fitted"] = (after.values[name], after.deviations[name])
    for one in found.found:
        for name, number in one.numbers.items():
            rows.setdefault(name, {"declared": found.declared.get(name), "fitted": number})
    return rows


def parameter_table(found: Diagnosis) -> pd.DataFrame:
    """parameter | unit | declared | baseline, 95 % interval | with what was found, 95 % interval | remark."""
    lines = []
    last = "rejected" if found.report["verdict"] == REJECTED else "with effects"
    for name, row in parameter_rows(found).items():
        unit = known_units().get(name, "1")
        shown = shown_unit(unit, row["fitted"][0])
        scale = factor(unit, shown)
        declared = row["declared"]
        line = {
            "parameter": name,
            "unit": "" if shown == "1" else shown,
            "declared": "" if declared is None else shown_number(scale * declared, 4),
        }
        for heading, key in (("baseline", "baseline"), (last, "fitted")):
            value, std = row.get(key, (None, None))
            line[heading] = "" if value is None else shown_number(scale * value, 4)
            line[f"{heading}, 95 % interval"] = "" if value is None else _interval(scale * value, scale * std)
        line["remark"] = "" if row.get("identified", True) else f"{NOT_IDENTIFIED} by the baseline"
        if "baseline" not in row:
            line["remark"] = "of an effect"
        lines.append(line)
    return _without_empty(lines)


def _interval(value: float, std: float) -> str:
    return f"{shown_number(value - INTERVAL * std, 4)} to {shown_number(value + INTERVAL * std, 4)}"


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
                        "gain": f"{100.0 * share:.1f} %" if abs(share) >= 0.0005 else "0 %",
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
