"""Who is measured again on fresh plant samples: of each class of each cell those that may turn out to be its best.

The choice is made once, from the samples that all candidates met; the verdict rests on samples that no choice has seen,
so that having picked the best does not flatter it. The best of a class is that with the least geometric mean of its
errors: on this scale ratios are judged, and one bad sample does not decide. Where a candidate that was measured again
turns out to hunt, those behind it are measured in further rounds, until one holds that nobody stands in front of.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from workbench.compare.candidates import CLASSES, Candidate, Cell, Class, by_class, sound
from workbench.compare.cells import cells_of, of_tuned
from workbench.compare.intervals import CLOSE, Relation, paired
from workbench.compare.schema import ComparisonTable

ROUND = 3
"""At most so many of a class are measured in a further round."""


@dataclass(frozen=True)
class Finalist:
    """A controller at a speed of rotation (rpm) that is measured again in a cell."""

    cell: Cell
    controller: str
    rpm: float


def finalists(table: ComparisonTable, frame: pd.DataFrame, fresh: pd.DataFrame | None = None) -> list[Finalist]:
    """Who is to be measured again, each once, in the order of the results.

    With the results of the rounds before in `fresh`, those of the next round: none if every class is settled. Whoever
    is measured again in motion is so in the references that hold still too, in which it might hunt.
    """
    cells = cells_of(table, of_tuned(table, frame))
    measured = {} if fresh is None else cells_of(table, fresh)
    chosen: set[Finalist] = set()
    for cell, candidates in cells.items():
        for kind in CLASSES:
            again = measured.get(cell, [])
            wanted = of_class(table, candidates, kind) if fresh is None else behind(candidates, again, kind)
            chosen.update(Finalist(cell, *candidate.key) for candidate in wanted)
    for finalist in list(chosen):
        for steps in table.steps:
            if (still := finalist.cell._replace(reference=steps)) in cells:
                chosen.add(Finalist(still, finalist.controller, finalist.rpm))
    chosen -= {Finalist(cell, *candidate.key) for cell, candidates in measured.items() for candidate in candidates}
    everyone = (Finalist(cell, *candidate.key) for cell, candidates in cells.items() for candidate in candidates)
    return [finalist for finalist in everyone if finalist in chosen]


def of_class(table: ComparisonTable, candidates: Sequence[Candidate], kind: Class) -> list[Candidate]:
    """Of one class: the best; the best of the other family of compensators; the cheapest of those level with the best;
    where that is one candidate, the next one if the samples do not tell it from the best."""
    ranked = list(sound(by_class(candidates)[kind]))
    if not ranked:
        return []
    best = ranked[0]
    chosen = [best]
    chosen += [candidate for candidate in ranked if candidate.family != best.family][:1]
    alike = [candidate for candidate in ranked if is_close(table, candidate, best)]
    if best.rpm > 0:
        chosen.append(min(alike, key=lambda candidate: candidate.paid_power))
    chosen = list(dict.fromkeys(chosen))
    if len(chosen) == 1:
        chosen += [
            candidate
            for candidate in ranked[1:2]
            if candidate in alike or related(table, best, candidate).word == "cannot be told from"
        ]
    return chosen


def behind(candidates: Sequence[Candidate], measured: Sequence[Candidate], kind: Class) -> list[Candidate]:
    """Of one class who is to be measured next: those in front of the first that holds on the samples of `measured`.

    Where all have a flaw there and none of them hunts rarely, the next that may hunt rarely.
    """
    ranked, again = by_class(candidates)[kind], {candidate.key: candidate for candidate in measured}
    waiting = []
    for candidate in sound(ranked):
        if candidate.key not in again:
            waiting.append(candidate)
        elif not again[candidate.key].flaw:
            return waiting[:ROUND]
    if not waiting and not any(candidate.rare for candidate in measured if candidate.kind == kind):
        waiting = [candidate for candidate in ranked if candidate.rare and candidate.key not in again][:1]
    return waiting[:ROUND]


def is_close(table: ComparisonTable, candidate: Candidate, best: Candidate) -> bool:
    """Whether the mean errors of two candidates differ by less than what counts."""
    return candidate.size - best.size <= CLOSE * candidate.size + table.negligible


def related(table: ComparisonTable, first: Candidate, second: Candidate, comparisons: int = 1) -> Relation:
    """How `first` does against `second` on the plant samples that both have met."""
    common = first.rows.index.intersection(second.rows.index)
    return paired(
        first.rows.loc[common, first.error_column].to_numpy(float),
        second.rows.loc[common, second.error_column].to_numpy(float),
        negligible=table.negligible,
        solver_error=first.solver_error + second.solver_error,
        probability=table.probability,
        comparisons=comparisons,
    )
