"""Reasons of a diagnosis in words: why an effect was not added, what simulation and a data-driven term say, and which
parameters are not identified.
"""

from collections.abc import Mapping
from typing import Any

from workbench.diagnose.diagnose import PLACED, PLACES, Diagnosis
from workbench.diagnose.report.names import listed, percent, plain
from workbench.diagnose.report.parameters import Row, parameter_rows
from workbench.diagnose.selection.selection import (
    AT_FLOOR,
    SURE,
    BalanceResult,
    Candidate,
    Step,
    gain,
    is_circular,
    least_gain,
)
from workbench.diagnose.selection.unexplained import dependence
from workbench.publish.tables import shown_number
from workbench.toml.units import factor


def why_none(result: BalanceResult) -> str:
    """Why no effect was added to a balance: what stopped the best one."""
    step = result.steps[0]
    best = step.candidates[0]
    share, _ = gain(step.before, best.fit)
    return (
        f"No effect was added to the {result.balance.name} balance: the best, {plain(best.effect)}, would lower it by "
        f"{percent(share, 1)} on data that its fit has not seen, but {_stopped(step, best)}."
    )


def _stopped(step: Step, best: Candidate) -> str:
    """The rule that stopped a candidate."""
    balance = step.before.balance
    share, sure = gain(step.before, best.fit)
    least = least_gain(best.effect, len(best.variant), balance)
    ended = sorted(best.fit.bounded - set(balance.free))
    if step.before.rms <= AT_FLOOR:
        return "the balance is at its noise floor without any"
    if ended:
        return f"{listed(ended)} ran to the end of its range, and so is no estimate"
    if share <= least:
        return f"{percent(least)} and more are asked for"
    if sure <= SURE:
        return f"by {sure:.1f} standard errors over the pieces of the records, where {SURE:g} are asked for"
    first = dependence(balance, step.before.values)
    if is_circular(best.effect, balance) and first is not None:
        placed = [plain(name) for name in PLACES if first.shares.get(name, 0.0) > PLACED]
        if placed:
            return (
                f"it was withdrawn: it is made of the pressures that it is to explain, and the residual depends on "
                f"{listed(placed)}, which no such force makes"
            )
    return "it was withdrawn: what it left went on to depend on a signal, so that it stands in for something else"


def of_parameters(found: Diagnosis) -> list[str]:
    """Which parameters the records do not identify: without effects, and with those that were found."""
    rows = parameter_rows(found)
    final = [name for name, row in rows.items() if row.final.doubt]
    if not found.found:
        return [f"The records do not identify {listed(final)}: {_doubts(final, rows)}."] if final else []
    first = [name for name, row in rows.items() if row.baseline is not None and row.baseline.doubt]
    lines = []
    if first:
        lines.append(f"Without effects (baseline) the records do not identify {listed(first)}.")
    if final:
        lines.append(f"With what was found the records do not identify {listed(final)}: {_doubts(final, rows)}.")
    elif first:
        lines.append("With what was found they identify every parameter that was fitted.")
    return lines


def _doubts(names: list[str], rows: Mapping[str, Row]) -> str:
    """Why parameters are not identified, and what plant.toml has of them."""
    reasons = dict.fromkeys(rows[name].final.doubt for name in names)
    return f"{listed(list(reasons), 'or')}. In plant.toml such a value stands without a deviation"


def of_term(unexplained: Mapping[str, Any]) -> str:
    """What a data-driven term would do, and that it is no more than that."""
    term = unexplained["data_driven_term"]
    use = "held_out" if "held_out" in term else "fit"
    shown = {"m^3/s": "cm^3/s"}.get(term["unit"], term["unit"])
    before, after = (shown_number(factor(term["unit"], shown) * term[use][side], 3) for side in ("before", "after"))
    lowers = term[use]["after"] < term[use]["before"]
    return (
        f"A data-driven term, the mean of that residual over {plain(term['signal'])}, "
        f"{'would lower' if lowers else 'would not lower'} it on the {use.replace('_', '-')} records: "
        f"{before} {shown} without it, {after} {shown} with it, where something moves (report.json has its nodes). It "
        "describes the records and names no cause."
    )


def of_simulation(found: Diagnosis) -> list[str]:
    """What the simulated plant says, and how far a free run of a held-out record can be believed."""
    if found.simulated is None:
        return []
    data, lines = found.report["simulation"], []
    pieces = data["starts_anew_every_s"]
    along = "from end to end" if pieces is None else f"in pieces of {pieces:g} s, since it runs away before the end"
    change = "" if not found.found else f", {shown_number(data['before'], 3)} without what was found"
    said = (
        f"is off by {shown_number(data['after'], 3)} standard deviations of the sensors' noise{change}; "
        "the parameters are of this fit"
    )
    if not data["parameters_from_it"]:
        said = "is off by far more than the sensors' noise; the parameters are those that fit the balances"
    lines.append(f"Simulated {along} and fitted to the fit records, the plant {said}.")
    if data["dropped"]:
        lines.append(f"The simulated plant does without {listed([plain(name) for name in data['dropped']])}: dropped.")
    own = found.report["error"]["held_out"].get("own_parameters")
    if own is not None:
        after = found.report["error"]["held_out"]["after"]["position_rms_m"]
        best = own["position_rms_m"]
        lines.append(
            f"A free run of the held-out records is off by {shown_number(1e3 * after, 2)} mm in position. With the "
            f"same parameters fitted to these records themselves {shown_number(1e3 * best, 2)} mm would be left: so "
            "much of it is the model's, and the rest is drift, as small forces that differ between records add up."
        )
    return lines
