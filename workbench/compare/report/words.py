"""The words of a cell: its verdict with the margin, how the others do, the price, whether a friction model is needed.

Every number is of the rows behind it: an error is the mean over the plant samples, a ratio the geometric mean of the
ratios on each sample, and what stands in brackets is where they lie.
"""

import math

from workbench.compare.candidates import HUNTS, MM, Candidate, Class, sound
from workbench.compare.finalists import related
from workbench.compare.intervals import LEAST, MOST_PROPOSED, Interval, Relation
from workbench.compare.result import NAMED, Verdict
from workbench.compare.schema import ComparisonTable
from workbench.compare.verdicts import within
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
    """Where a mean lies, in brackets; nothing where there is one plant sample."""
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


def sized(table: ComparisonTable, candidate: Candidate) -> str:
    """A candidate with its error: "pi at rest, 0.05 mm (0.04 to 0.06)"."""
    return f"{candidate.words}, {lying(candidate.mean_error(table.probability))}"


def sentences(table: ComparisonTable, verdict: Verdict) -> list[str]:
    """All that is said of a cell, the verdict first."""
    lines = [_verdict(table, verdict), *_flawed(verdict), *_rare(table, verdict)]
    lines += _against_nothing(table, verdict)
    lines += _together(table, verdict)
    lines += _price(table, verdict)
    lines += _without_model(table, verdict)
    return lines


def _verdict(table: ComparisonTable, verdict: Verdict) -> str:
    """The verdict with what it rests on."""
    word = verdict.kind.capitalize()
    if verdict.kind == "no comparison":
        return f"{word}: the study has no {_absent(verdict)}."
    if verdict.kind == "none holds":
        return f"{word}: every candidate hunts or does not complete."
    if verdict.otherwise is not None:
        told = "; ".join(f"{sized(table, candidate)}, {hunts_on(candidate)}" for candidate in verdict.rare.values())
        return (
            f"{word}: {verdict.strictly} without what hunts on any draw, {verdict.otherwise} with what hunts rarely: "
            f"{told}."
        )
    if verdict.kind == "nothing needed" and within(table, verdict.best["nothing"]):
        return f"{word}: {sized(table, verdict.best['nothing'])}, is within {millimetres(table.negligible)}."
    pair = verdict.pair
    if pair is None:
        (only,) = verdict.best.values() if len(verdict.best) == 1 else [verdict.best[NAMED.get(verdict.kind, "avoid")]]
        return f"{word}: {sized(table, only)}; no other class has a candidate that holds."
    named, rival = (verdict.best[kind] for kind in pair)
    relation = verdict.relation(*pair)
    return (
        f"{word}: {sized(table, named)}, {relation.word} {sized(table, rival)}: {margin(relation)}{needed(relation)}."
    )


def _absent(verdict: Verdict) -> str:
    sides: tuple[Class, ...] = ("compensate", "avoid")
    absent = [SIDES[side] for side in sides if side not in verdict.best and side not in verdict.flawed]
    return " and no ".join(absent)


def margin(relation: Relation) -> str:
    """Ratio and difference with their intervals: "ratio 1.8 (1.6 to 2.1), difference 0.04 mm (0.03 to 0.05)"."""
    ratio, difference = relation.ratio, relation.difference
    return f"ratio {_end(ratio.mean)}{spread(ratio)}, difference {lying(difference)}"


def needed(relation: Relation) -> str:
    """How many plant samples would tell, where these do not."""
    if relation.word != "cannot be told from":
        return ""
    if relation.needed is None:
        return f"; {relation.samples} draws do not tell, nor would {MOST_PROPOSED}"
    return f"; {relation.samples} draws do not tell, about {relation.needed} would"


def hunts_on(candidate: Candidate) -> str:
    """On how many plant samples a candidate hunts, and on what share of all plants with that."""
    count, samples = candidate.hunting
    low, high = (_end(100.0 * share) for share in candidate.hunting.share)
    return f"hunts at a standstill on {count} of {samples} draws, so on {low} to {high} % of such machines"


def _flawed(verdict: Verdict) -> list[str]:
    """Which classes have no candidate that holds, and why; who hunts least often."""
    lines = []
    for kind, candidates in verdict.flawed.items():
        flaws = list(dict.fromkeys(candidate.flaw for candidate in candidates if candidate.flaw))
        hunters = [candidate for candidate in candidates if candidate.flaw == HUNTS]
        if hunters:
            least = min(hunters, key=_hunting_order)
            count, samples = least.hunting
            flaws[flaws.index(HUNTS)] = f"{HUNTS} (least often {least.words}, on {count} of {samples} draws)"
        lines.append(f"No candidate of {SIDES[kind]} holds: {', '.join(flaws)}.")
    return lines if verdict.kind != "none holds" else []


def _hunting_order(candidate: Candidate) -> tuple[float, int]:
    """By how often a candidate hunts, the least first; of the same share that of more plant samples."""
    count, samples = candidate.hunting
    return count / samples, -samples


def _rare(table: ComparisonTable, verdict: Verdict) -> list[str]:
    """Who would stand in front of who holds, but hunts, if rarely; where that changes the verdict, it is told there."""
    if verdict.otherwise is not None:
        return []
    return [
        f"Of {SIDES[kind]}, {sized(table, candidate)}, would stand in front, but {hunts_on(candidate)}."
        for kind, candidate in verdict.rare.items()
        if kind in verdict.best
    ]


def _against_nothing(table: ComparisonTable, verdict: Verdict) -> list[str]:
    """How compensation, rotation and both together do against a plain controller at rest."""
    if verdict.kind in ("nothing needed", "no comparison") or "nothing" not in verdict.best:
        return []
    parts = [
        f"{SIDES[kind]}, {candidate.words}, {verdict.relation(kind, 'nothing').word} it"
        for kind, candidate in verdict.best.items()
        if kind != "nothing"
    ]
    return [f"Against {sized(table, verdict.best['nothing'])}: {'; '.join(parts)}."] if parts else []


def _together(table: ComparisonTable, verdict: Verdict) -> list[str]:
    """How a compensator on a rotating rod does against the one of the two that the verdict names."""
    relation = verdict.together
    if relation is None:
        return []
    both, named = verdict.best["both"], verdict.best[NAMED[verdict.kind]]
    extra = both.paid_power - named.paid_power
    sign = "+" if extra >= 0.0 else "-"
    return [
        f"Both together, {sized(table, both)}, {relation.word} it, at {sign}{watts(abs(extra))} paid: "
        f"{margin(relation)}{needed(relation)}."
    ]


def _price(table: ComparisonTable, verdict: Verdict) -> list[str]:
    """What the rotating candidate pays beside the one at rest."""
    turning, still = verdict.turning, verdict.still
    if turning is None:
        return []
    lines = [f"Price of {turning.words}: {price(table, turning, still)}."]
    if cheapest := _cheaper(table, verdict, turning):
        lines.append(f"Level with it, the cheapest is {sized(table, cheapest)}: {price(table, cheapest, still)}.")
    return lines


def price(table: ComparisonTable, turning: Candidate, still: Candidate | None) -> str:
    """What a rotating candidate pays: motor, its loss, pump, and torque where it is above the nominal."""
    parts = [f"{watts(turning.terminal_power)} at the motor's terminals"]
    if not math.isnan(turning.motor_loss):
        parts[0] += f", {watts(turning.motor_loss)} of it lost before the rod"
    parts.append(f"{watts(turning.paid_power)} paid with the pump")
    if still is not None:
        parts.append(f"the pump {watts(turning.pump_power)}, against {watts(still.pump_power)} for {still.words}")
    if turning.motor_torque > table.nominal_torque:
        parts.append(f"{turning.motor_torque:.2g} N m rms, above the nominal {table.nominal_torque:g} N m")
    return "; ".join(parts)


def _cheaper(table: ComparisonTable, verdict: Verdict, best: Candidate) -> Candidate | None:
    """The candidate on a rod that turns that is level with the best and pays least, if it pays less by what counts."""
    others = [candidate for candidate in sound(verdict.candidates) if candidate.rpm > 0 and candidate is not best]
    alike = [candidate for candidate in others if related(table, candidate, best).word in ("is level with", "beats")]
    least = min(alike, key=lambda candidate: candidate.paid_power, default=None)
    return least if least is not None and least.paid_power < (1.0 - ALIKE) * best.paid_power else None


def _without_model(table: ComparisonTable, verdict: Verdict) -> list[str]:
    """Whether inverting the valve by the measured load pressure does as well as any friction model, at rest."""
    pair = families(verdict)
    if verdict.kind in ("nothing needed", "no comparison") or pair is None:
        return []
    pressure, model = pair
    relation = related(table, pressure, model)
    start = {
        "beats": "No friction model is needed",
        "is level with": "No friction model is needed",
        "loses to": "A friction model is worth having",
        "cannot be told from": "Whether a friction model is needed cannot be told",
    }[relation.word]
    return [
        f"{start}: measured load pressure without one, {sized(table, pressure)}, {relation.word} the best with one, "
        f"{sized(table, model)}: {margin(relation)}{needed(relation)}."
    ]


def families(verdict: Verdict) -> tuple[Candidate, Candidate] | None:
    """The best compensators at rest without and with a friction model, None where one is missing."""
    there = [candidate for candidate in sound(verdict.candidates) if candidate.kind == "compensate"]
    pressure, model = (
        next((candidate for candidate in there if candidate.family == name), None)
        for name in ("pressure", "friction model")
    )
    return None if pressure is None or model is None else (pressure, model)
