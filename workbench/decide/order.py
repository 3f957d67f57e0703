"""The order of candidates: which comes first, which may be chosen, and which no other beats in error and power."""

import math
from collections.abc import Callable, Sequence

from workbench.decide.candidate import KINDS, CandidateResult, Kind
from workbench.decide.schema import DecideTable

ALIKE = 0.05
"""Powers that differ by less than this share are one power: which of them is less does not decide."""


def ordered(rows: Sequence[CandidateResult], table: DecideTable) -> list[CandidateResult]:
    """First those that seem to meet what is asked, from the least power on; then the others, the nearest to it first.

    Of those with about one power, or about equally near (`ALIKE`), the one with the least error quantile comes first.
    """
    chosen = _by_size([row for row in rows if row.seems_to_meet(table)], lambda row: row.mean_power)
    rest = [row for row in rows if not row.seems_to_meet(table)]
    for share in sorted({row.probability for row in rest}, reverse=True):
        chosen += _by_size([row for row in rest if row.probability == share], lambda row: row.excess(table))
    return chosen


def _by_size(rows: Sequence[CandidateResult], size: Callable[[CandidateResult], float]) -> list[CandidateResult]:
    """From the least size on; of those whose sizes are alike the one with the least error first."""
    left, chosen = sorted(rows, key=size), list[CandidateResult]()
    while left:
        least = size(left[0])
        alike = [row for row in left if size(row) <= (1.0 + ALIKE) * least]
        chosen += sorted(alike, key=lambda row: row.error)
        left = left[len(alike) :]
    return chosen


def of_kind(rows: Sequence[CandidateResult], kind: Kind, table: DecideTable) -> CandidateResult | None:
    """The first of a kind in that order."""
    return next(iter(ordered([row for row in rows if row.kind == kind], table)), None)


def possible(rows: Sequence[CandidateResult], table: DecideTable) -> list[CandidateResult]:
    """Those that may be chosen, in the order in which they would be: by kind, within one in the order above.

    Out is what the draws of the search rule out: their interval is below what is asked, or it hunts on one of them.
    """
    left = [row for row in rows if row.standing(table) != "fails"]
    return [row for kind in KINDS for row in ordered([row for row in left if row.kind == kind], table)]


def contenders(rows: Sequence[CandidateResult], table: DecideTable) -> list[CandidateResult]:
    """Of those the first of each kind, as many as [decide] says: they are measured again, in this order."""
    left = possible(rows, table)
    return [row for kind in KINDS for row in [row for row in left if row.kind == kind][: table.contenders]]


def non_dominated(rows: Sequence[CandidateResult]) -> list[CandidateResult]:
    """From the least mean power on, those whose error quantile is below that of all that need less.

    Of those with about one power (`ALIKE`) the one with the least error stands for all; those without a finite error
    do not count.
    """
    left = sorted((row for row in rows if math.isfinite(row.error)), key=lambda row: row.mean_power)
    front: list[CandidateResult] = []
    while left:
        alike = [row for row in left if row.mean_power <= (1.0 + ALIKE) * left[0].mean_power]
        left = left[len(alike) :]
        least = min(alike, key=lambda row: row.error)
        if not front or least.error < front[-1].error:
            front.append(least)
    return front
