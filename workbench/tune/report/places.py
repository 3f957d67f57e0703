"""What a tuning for several machines and speeds says: each place for itself, since each has its own unit."""

import math
from collections.abc import Sequence

from workbench.tune.report.rows import Basis, objective_of
from workbench.tune.report.tables import differ_words, number
from workbench.tune.study import Tuning
from workbench.tune.tuning import Tuned

NAMED = 5
"""Controllers that are named of a place, the best first."""


def place_lines(tuning: Tuning, basis: Basis) -> list[str]:
    """A line a place: who is best there, the next, and by how much tuning lowered the best's objective."""
    places: dict[str, list[Tuned]] = {}
    for one in tuning.found:
        places.setdefault(", ".join(f"{axis} {value}" for axis, value in one.task.at.items()), []).append(one)
    return [_place(place, own, basis) for place, own in places.items()]


def _place(place: str, own: Sequence[Tuned], basis: Basis) -> str:
    found = [(after.value, one) for one in own if (after := objective_of(one, "after", basis)) is not None]
    if not found:
        return f"{place}: no controller has gains that keep all constraints."
    found.sort(key=lambda each: each[0])
    named = ", ".join(f"{one.task.name} {number(value)}" for value, one in found[:NAMED])
    rest = f"; {len(found) - NAMED} others up to {number(found[-1][0])}" if len(found) > NAMED else ""
    return f"{place}: objective of {named}{rest}."


def seeds_line(tuning: Tuning) -> list[str]:
    """By how much the searches of one controller differ at most, and how many of them by how much."""
    known = [(one.seeds_differ, one.task.label) for one in tuning.found if one.seeds_differ is not None]
    if not known:
        return []
    lacking = [label for share, label in known if math.isinf(share)]
    finite = sorted((each for each in known if math.isfinite(each[0])), reverse=True)
    said = []
    if finite:
        share, label = finite[0]
        median = finite[len(finite) // 2][0]
        most = f"at most, of {label}; half of them differ by {differ_words(median)} or less"
        most = most if len(finite) > 1 else f"of {label}"
        said.append(f"Searches from other seeds differ by {differ_words(share)} {most}.")
    if lacking:
        said.append(f"A seed found no gains where another did: {', '.join(lacking)}.")
    return said
