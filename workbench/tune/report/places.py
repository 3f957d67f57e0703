"""What a tuning for several machines and speeds says: each place for itself, since each has its own unit."""

import math
from collections.abc import Sequence

from workbench.tune.report.rows import Basis, objective_of
from workbench.tune.report.tables import differ_words, number
from workbench.tune.result import ControllerTuning, Tuning

NAMED = 5
"""Controllers that are named of a place, the best first."""


def place_lines(tuning: Tuning, basis: Basis) -> list[str]:
    """A line a place: who is best there, the next, and by how much tuning lowered the best's objective."""
    places: dict[str, list[ControllerTuning]] = {}
    for tuned in tuning.tuned:
        places.setdefault(", ".join(f"{axis} {value}" for axis, value in tuned.task.at.items()), []).append(tuned)
    return [_place(place, own, basis) for place, own in places.items()]


def _place(place: str, own: Sequence[ControllerTuning], basis: Basis) -> str:
    ranking = [(after.value, tuned) for tuned in own if (after := objective_of(tuned, "after", basis)) is not None]
    if not ranking:
        return f"{place}: no controller has gains that keep all constraints."
    ranking.sort(key=lambda each: each[0])
    named = ", ".join(f"{tuned.task.name} {number(value)}" for value, tuned in ranking[:NAMED])
    rest = f"; {len(ranking) - NAMED} others up to {number(ranking[-1][0])}" if len(ranking) > NAMED else ""
    return f"{place}: objective of {named}{rest}."


def seeds_line(tuning: Tuning) -> list[str]:
    """By how much the searches of one controller differ at most, and how many of them by how much."""
    known = [(tuned.seeds_differ, tuned.task.label) for tuned in tuning.tuned if tuned.seeds_differ is not None]
    if not known:
        return []
    lacking = [label for share, label in known if math.isinf(share)]
    finite = sorted((each for each in known if math.isfinite(each[0])), reverse=True)
    lines = []
    if finite:
        share, label = finite[0]
        median = finite[len(finite) // 2][0]
        most = f"at most, of {label}; half of them differ by {differ_words(median)} or less"
        most = most if len(finite) > 1 else f"of {label}"
        lines.append(f"Searches from other seeds differ by {differ_words(share)} {most}.")
    if lacking:
        lines.append(f"A seed found no gains where another did: {', '.join(lacking)}.")
    return lines
