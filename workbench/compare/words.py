"""The words of a cell: its verdict with the margin, how the others do, the price, whether a friction model is needed.

Every number is one of the rows behind it: an error is the mean over the draws, a ratio the geometric mean of the ratios
on each draw, and what stands in brackets is where they lie.
"""

import pandas as pd

from workbench.compare.candidates import HUNTS, MM, Candidate, Class, sound
from workbench.compare.finalists import related
from workbench.compare.intervals import LEAST, MOST_DRAWS, Interval, Relation
from workbench.compare.schema import ComparisonTable
from workbench.compare.verdicts import NAMED, Verdict, size_of, within
from workbench.metrics.statistics import share_interval
from workbench.publish.words import watts

ALIKE = 0.02
"""Powers that differ by less than this share of the larger are told as one."""

SIDES: dict[Class, str] = {
    "nothing": "plain at rest",
    "compensate": "compensation at rest",
    "avoid": "rotation",
    "both": "compensation with rotation",
}


FAR = 1e4
"""The ends of an interval of ratios that are further apart than this bound nothing."""


def millimetres(error: float) -> str:
    """An error (m) in mm, with three digits; what is too small to be told is not."""
    return f"< {LEAST * MM:g} mm" if abs(error) < LEAST else f"{error * MM:.3g} mm"


def spread(interval: Interval, scale: float = 1.0) -> str:
    """Where a mean lies, in brackets; nothing where there is one draw."""
    if interval.low == interval.high:
        return ""
    if 0.0 < interval.low * FAR < interval.high:
        return " (not bounded by so few draws)"
    return f" ({_end(interval.low * scale)} to {_end(interval.high * scale)})"


def lying(length: Interval) -> str:
    """A length in mm with where it lies; one that is too small to be told lies nowhere in particular."""
    told = max(abs(length.low), abs(length.high)) >= LEAST
    return millimetres(length.mean) + (spread(length, MM) if told else "")


def _end(number: float) -> str:
    return f"{number:.3g}"


def sized(spec: ComparisonTable, one: Candidate) -> str:
    """A candidate with its error: "pi at rest, 0.05 mm (0.04 to 0.06)"."""
    return f"{one.words}, {lying(size_of(spec, one))}"


def sentences(spec: ComparisonTable, verdict: Verdict) -> list[str]:
    """All that is said of a cell, the verdict first."""
    lines = [_verdict(spec, verdict), *_flawed(verdict), *_rare(spec, verdict)]
    lines += _against_nothing(spec, verdict)
    lines += _together(spec, verdict)
    lines += _price(spec, verdict)
    lines += _without_model(spec, verdict)
    return lines


def _verdict(spec: ComparisonTable, verdict: Verdict) -> str:
    """The verdict with what it rests on."""
    word = verdict.kind.capitalize()
    if verdict.kind == "no comparison":
        return f"{word}: the study has no {_absent(verdict)}."
    if verdict.kind == "none holds":
        return f"{word}: every candidate hunts or does not complete."
    if verdict.otherwise is not None:
        told = "; ".join(f"{sized(spec, one)}, {hunts_on(one)}" for one in verdict.rare.values())
        return (
            f"{word}: {verdict.strictly} without what hunts on any draw, {verdict.otherwise} with what hunts rarely: "
            f"{told}."
        )
    if verdict.kind == "nothing needed" and within(spec, verdict.best["nothing"]):
        return f"{word}: {sized(spec, verdict.best['nothing'])}, is within {millimetres(spec.negligible)}."
    pair = verdict.pair
    if pair is None:
        (only,) = verdict.best.values() if len(verdict.best) == 1 else [verdict.best[NAMED.get(verdict.kind, "avoid")]]
        return f"{word}: {sized(spec, only)}; no other class has a candidate that holds."
    one, other = (verdict.best[kind] for kind in pair)
    relation = verdict.relation(*pair)
    return f"{word}: {sized(spec, one)}, {relation.word} {sized(spec, other)}: {margin(relation)}{needed(relation)}."


def _absent(verdict: Verdict) -> str:
    sides: tuple[Class, ...] = ("compensate", "avoid")
    absent = [SIDES[side] for side in sides if side not in verdict.best and side not in verdict.flawed]
    return " and no ".join(absent)


def margin(relation: Relation) -> str:
    """Ratio and difference with their intervals: "ratio 1.8 (1.6 to 2.1), difference 0.04 mm (0.03 to 0.05)"."""
    ratio, difference = relation.ratio, relation.difference
    return f"ratio {_end(ratio.mean)}{spread(ratio)}, difference {lying(difference)}"


def needed(relation: Relation) -> str:
    """How many draws would tell, where these do not."""
    if relation.word != "cannot be told from":
        return ""
    if relation.needed is None:
        return f"; {relation.draws} draws do not tell, nor would {MOST_DRAWS}"
    return f"; {relation.draws} draws do not tell, about {relation.needed} would"


def hunts_on(one: Candidate) -> str:
    """On how many draws a candidate hunts, and on what share of all machines with that."""
    count, draws = one.hunting
    low, high = (_end(100.0 * share) for share in share_interval(count, draws))
    return f"hunts at a standstill on {count} of {draws} draws, so on {low} to {high} % of such machines"


def _flawed(verdict: Verdict) -> list[str]:
    """Which classes have no candidate that holds, and why; who hunts least often."""
    lines = []
    for kind, candidates in verdict.flawed.items():
        flaws = list(dict.fromkeys(one.flaw for one in candidates if one.flaw))
        hunters = [one for one in candidates if one.flaw == HUNTS]
        if hunters:
            least = min(hunters, key=lambda one: (one.hunting[0] / one.hunting[1], -one.hunting[1]))
            count, draws = least.hunting
            flaws[flaws.index(HUNTS)] = f"{HUNTS} (least often {least.words}, on {count} of {draws} draws)"
        lines.append(f"No candidate of {SIDES[kind]} holds: {', '.join(flaws)}.")
    return lines if verdict.kind != "none holds" else []


def _rare(spec: ComparisonTable, verdict: Verdict) -> list[str]:
    """Who would stand in front of who holds, but hunts, if rarely; where that changes the verdict, it is told there."""
    if verdict.otherwise is not None:
        return []
    return [
        f"Of {SIDES[kind]}, {sized(spec, one)}, would stand in front, but {hunts_on(one)}."
        for kind, one in verdict.rare.items()
        if kind in verdict.best
    ]


def _against_nothing(spec: ComparisonTable, verdict: Verdict) -> list[str]:
    """How compensation, rotation and both together do against a plain controller at rest."""
    if verdict.kind in ("nothing needed", "no comparison") or "nothing" not in verdict.best:
        return []
    parts = [
        f"{SIDES[kind]}, {one.words}, {verdict.relation(kind, 'nothing').word} it"
        for kind, one in verdict.best.items()
        if kind != "nothing"
    ]
    return [f"Against {sized(spec, verdict.best['nothing'])}: {'; '.join(parts)}."] if parts else []


def _together(spec: ComparisonTable, verdict: Verdict) -> list[str]:
    """How a compensator on a rotating rod does against the one of the two that the verdict names."""
    relation = verdict.together
    if relation is None:
        return []
    both, named = verdict.best["both"], verdict.best[NAMED[verdict.kind]]
    extra = both.paid - named.paid
    return [
        f"Both together, {sized(spec, both)}, {relation.word} it, at {'+' if extra >= 0.0 else '-'}{watts(abs(extra))} "
        f"paid: {margin(relation)}{needed(relation)}."
    ]


def _price(spec: ComparisonTable, verdict: Verdict) -> list[str]:
    """What the rotating candidate pays beside the one at rest."""
    one, still = verdict.turning, verdict.still
    if one is None:
        return []
    lines = [f"Price of {one.words}: {price(spec, one, still)}."]
    if cheapest := _cheaper(spec, verdict, one):
        lines.append(f"Level with it, the cheapest is {sized(spec, cheapest)}: {price(spec, cheapest, still)}.")
    return lines


def price(spec: ComparisonTable, one: Candidate, still: Candidate | None) -> str:
    """What a rotating candidate pays: motor, its loss, pump, and torque where it is above the nominal."""
    motor, pump = one.mean("motor_electric_power_W"), one.mean("supply_power_W")
    parts = [f"{watts(motor)} at the motor's terminals"]
    loss = one.mean("motor_loss_W")
    if not pd.isna(loss):
        parts[0] += f", {watts(loss)} of it lost before the rod"
    parts.append(f"{watts(one.paid)} paid with the pump")
    if still is not None:
        parts.append(f"the pump {watts(pump)}, against {watts(still.mean('supply_power_W'))} for {still.words}")
    torque = one.mean("motor_torque_rms_N_m")
    if torque > spec.nominal_torque:
        parts.append(f"{torque:.2g} N m rms, above the nominal {spec.nominal_torque:g} N m")
    return "; ".join(parts)


def _cheaper(spec: ComparisonTable, verdict: Verdict, best: Candidate) -> Candidate | None:
    """The candidate on a rod that turns that is level with the best and pays least, if it pays less by what counts."""
    others = [one for one in sound(verdict.candidates) if one.rpm > 0 and one is not best]
    alike = [one for one in others if related(spec, one, best).word in ("is level with", "beats")]
    least = min(alike, key=lambda one: one.paid, default=None)
    return least if least is not None and least.paid < (1.0 - ALIKE) * best.paid else None


def _without_model(spec: ComparisonTable, verdict: Verdict) -> list[str]:
    """Whether inverting the valve by the measured load pressure does as well as any friction model, at rest."""
    pair = families(verdict)
    if verdict.kind in ("nothing needed", "no comparison") or pair is None:
        return []
    pressure, model = pair
    relation = related(spec, pressure, model)
    said = {
        "beats": "No friction model is needed",
        "is level with": "No friction model is needed",
        "loses to": "A friction model is worth having",
        "cannot be told from": "Whether a friction model is needed cannot be told",
    }[relation.word]
    return [
        f"{said}: measured load pressure without one, {sized(spec, pressure)}, {relation.word} the best with one, "
        f"{sized(spec, model)}: {margin(relation)}{needed(relation)}."
    ]


def families(verdict: Verdict) -> tuple[Candidate, Candidate] | None:
    """The best compensators at rest without and with a friction model, None where one is missing."""
    there = [one for one in sound(verdict.candidates) if one.kind == "compensate"]
    pressure, model = (
        next((one for one in there if one.family == name), None) for name in ("pressure", "friction model")
    )
    return None if pressure is None or model is None else (pressure, model)
