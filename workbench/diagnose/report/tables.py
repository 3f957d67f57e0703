"""Tables of a diagnosis as text: effects, errors before and after, parameters, and what each candidate was worth."""

import math

import pandas as pd

from workbench.diagnose.report.names import ERRORS, interval, percent, quantity, shown_unit, within
from workbench.diagnose.report.parameters import Row, parameter_rows
from workbench.diagnose.report.series import words_of
from workbench.diagnose.residuals.fit import Fit
from workbench.diagnose.result import ENDED, Diagnosis, error_of
from workbench.diagnose.selection.selection import Step
from workbench.parameters.sets import known_units
from workbench.publish.along import SHOWN
from workbench.publish.tables import shown_number
from workbench.publish.words import plain_name
from workbench.toml.units import factor

INTERVAL = 1.96
"""Standard deviations to either side of a 95 % interval."""

NOT_IDENTIFIED = "not identified"


def effects_table(diagnosis: Diagnosis) -> pd.DataFrame:
    """effect | balance | parameter | value | share of the residual | alternatives; empty where none was found."""
    lines = [
        {
            "effect": plain_name(effect.name),
            "balance": SHOWN[diagnosis.axis].said(effect.balance),
            "parameter": name,
            "value ± std": quantity(name, *number, diagnosis.axis),
            "lowers the residual by": "" if (share := effect.evidence.left_out_gain) is None else percent(share),
            "cannot be told from": ", ".join(map(plain_name, effect.alternatives)),
        }
        for effect in diagnosis.effects
        for name, number in effect.parameters.items()
    ]
    return _without_empty(lines)


def error_table(diagnosis: Diagnosis) -> pd.DataFrame:
    """error | unit | before, after, change on the fit and on the held-out records | floor.

    Where nothing was added there is no before and after, and one column for each use.
    """
    uses = (("fit", diagnosis.errors.fit), ("held-out", diagnosis.errors.held_out))
    models = [errors for _, use in uses for errors in (use.before, use.after)]
    floors = {error_of(result.balance.name, result.balance.unit): result.balance.floor for result in diagnosis.results}
    lines = []
    for key in dict.fromkeys(key for errors in models for key in errors.by_key):
        words, unit, shown = ERRORS.get(key, (plain_name(key), "1", "1"))
        scale = factor(unit, shown)
        line = {"error (rms)": words, "unit": shown if shown != "1" else ""}
        for use, errors in uses:
            before, after = (side.by_key.get(key) for side in (errors.before, errors.after))
            columns = {f"{use}, before": before, f"{use}, after": after} if diagnosis.effects else {use: after}
            for heading, rms in columns.items():
                line[heading] = "" if rms is None else shown_number(scale * rms, 3)
            if diagnosis.effects and before and after is not None:
                change = percent(after / before - 1.0, 1)
                line[f"{use}, change"] = f"+{change}" if after > before and change != "0 %" else change
        line["noise floor"] = shown_number(scale * floors[key], 3) if key in floors else ""
        lines.append(line)
    return _without_empty(lines)


def parameter_table(diagnosis: Diagnosis) -> pd.DataFrame:
    """parameter | unit | declared | baseline, 95 % interval | with what was found, 95 % interval | remark.

    Where nothing was found there is one fit, and one pair of columns.
    """
    lines = []
    last = "rejected" if diagnosis.is_rejected else "with effects"
    of_effects = {name for effect in diagnosis.effects for name in effect.parameters}
    for name, row in parameter_rows(diagnosis).items():
        unit = known_units(diagnosis.axis).get(name, "1")
        shown = shown_unit(unit, row.final.value)
        scale = factor(unit, shown)
        line = {
            "parameter": name,
            "unit": "" if shown == "1" else shown,
            "declared": "" if row.declared is None else shown_number(scale * row.declared, 4),
        }
        sides = {"baseline": row.baseline, last: row.final} if diagnosis.effects else {"fitted": row.final}
        for heading, fitted in sides.items():
            half = math.nan if fitted is None or fitted.doubt == ENDED else INTERVAL * scale * fitted.std
            line[heading] = "" if fitted is None else within(scale * fitted.value, half)
            line[f"{heading}, 95 % interval"] = "" if fitted is None else interval(scale * fitted.value, half)
        remark = _remark(row, last, name in of_effects) if diagnosis.effects else NOT_IDENTIFIED * bool(row.final.doubt)
        lines.append({**line, "remark": remark})
    return _without_empty(lines)


def _remark(row: Row, last: str, of_effect: bool) -> str:
    """What a reader has to know of a parameter: of an effect, or not identified, and by which fit."""
    doubts = (("by the baseline", row.baseline is not None and row.baseline.doubt), (last, row.final.doubt))
    unsure = [words for words, doubt in doubts if doubt]
    remarks = ["of an effect"] if of_effect else []
    return "; ".join([*remarks, *([f"{NOT_IDENTIFIED} {', '.join(unsure)}"] if unsure else [])])


def evidence_table(diagnosis: Diagnosis) -> pd.DataFrame:
    """balance | round | candidate | parameters | stands out by | asked for | gain in log-likelihood | outcome."""
    lines = []
    for result in diagnosis.rounds:
        for number, step in enumerate(result.steps, 1):
            for candidate in step.candidates:
                fitted = candidate.fit
                lines.append(
                    {
                        "balance": words_of(result.balance),
                        "round": str(number),
                        "candidate": plain_name(candidate.effect),
                        "its parameters": ", ".join(
                            name if fitted is None else quantity_of(fitted, name) for name in candidate.variant
                        ),
                        "stands out by (std. deviations)": f"{candidate.deviations:.1f}",
                        "asked for": f"{candidate.asked_deviations:.1f}",
                        "gain in log-likelihood": shown_number(candidate.gain, 3),
                        "known by": "first order" if fitted is None else "a fit",
                        "outcome": outcome(step, candidate.effect),
                    }
                )
    return _without_empty(lines)


def quantity_of(fit: Fit, name: str) -> str:
    """A fitted parameter by name, with its unit; one without a deviation was stopped by its bound."""
    if not fit.deviations[name]:
        return f"{name} at its bound"
    return f"{name} = {quantity(name, fit.values[name], fit.deviations[name], fit.balance.axis)}"


def outcome(step: Step, effect: str) -> str:
    """What became of a candidate in a round."""
    if effect in step.added:
        return "added"
    return "as good" if effect in step.alternatives else ""


def _without_empty(lines: list[dict[str, str]]) -> pd.DataFrame:
    frame = pd.DataFrame(lines).fillna("")
    return frame.drop(columns=[name for name in frame.columns if not frame[name].any()])
