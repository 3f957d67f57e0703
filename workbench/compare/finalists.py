"""Who is measured again on fresh draws: of each class of each cell those that may turn out to be its best.

The choice is made once, from the draws that all candidates met; the verdict rests on draws that no choice has seen, so
that having picked the best does not flatter it. The best of a class is that with the least geometric mean of its
errors: on this scale ratios are judged, and one bad draw does not decide. Where one that was measured again turns out
to hunt, those behind it are measured in further rounds, until one holds that nobody stands in front of.
"""

import pandas as pd

from workbench.compare.candidates import (
    CLASSES,
    Candidate,
    Cell,
    Class,
    by_class,
    cells_of,
    of_tuned,
    sound,
)
from workbench.compare.intervals import CLOSE, Relation, paired
from workbench.compare.schema import ComparisonTable

ROUND = 3
"""At most so many of a class are measured in a further round."""


def finalists(spec: ComparisonTable, frame: pd.DataFrame, fresh: pd.DataFrame | None = None) -> list[dict[str, object]]:
    """The cases to be measured again: values of the axes machine and scenario (where the results have them),
    reference, controller and rpm, each once, in the order of the results.

    With the results of the rounds before in `fresh`, those of the next round: none if every class is settled. Whoever
    is measured again in motion is so in the references that hold still too, in which it might hunt.
    """
    frame = of_tuned(spec, frame)
    chosen: set[tuple[Cell, str, float]] = set()
    found = cells_of(spec, frame)
    measured = {} if fresh is None else cells_of(spec, fresh)
    for cell, candidates in found.items():
        for kind in CLASSES:
            again = measured.get(cell, [])
            wanted = of_class(spec, candidates, kind) if fresh is None else behind(candidates, again, kind)
            chosen.update((cell, *one.key) for one in wanted)
    for cell, controller, rpm in list(chosen):
        for steps in spec.steps:
            if (still := cell._replace(reference=steps)) in found:
                chosen.add((still, controller, rpm))
    chosen -= {(cell, *one.key) for cell, candidates in measured.items() for one in candidates}
    axes = [name for name in ("machine", "scenario") if name in frame]
    rows: list[dict[str, object]] = [
        {name: getattr(cell, name) for name in axes}
        | {"reference": cell.reference, "controller": one.controller, "rpm": one.rpm}
        for cell, candidates in found.items()
        for one in candidates
        if (cell, *one.key) in chosen
    ]
    return rows


def of_class(spec: ComparisonTable, candidates: list[Candidate], kind: Class) -> list[Candidate]:
    """Of one class: the best; the best of the other family of compensators; the cheapest of those level with the best;
    where that is one candidate, the next one if the draws do not tell it from the best."""
    ranked = list(sound(by_class(candidates)[kind]))
    if not ranked:
        return []
    best = ranked[0]
    chosen = [best]
    chosen += [one for one in ranked if one.family != best.family][:1]
    alike = [one for one in ranked if is_close(spec, one, best)]
    if best.rpm > 0:
        chosen.append(min(alike, key=lambda one: one.paid))
    chosen = list(dict.fromkeys(chosen))
    if len(chosen) == 1:
        chosen += [one for one in ranked[1:2] if one in alike or related(spec, best, one).word == "cannot be told from"]
    return chosen


def behind(candidates: list[Candidate], measured: list[Candidate], kind: Class) -> list[Candidate]:
    """Of one class who is to be measured next: those in front of the first that holds on the draws `measured`.

    Where all have a flaw there and none of them hunts rarely, the next that may hunt rarely.
    """
    ranked, again = by_class(candidates)[kind], {one.key: one for one in measured}
    waiting = []
    for one in sound(ranked):
        if one.key not in again:
            waiting.append(one)
        elif not again[one.key].flaw:
            return waiting[:ROUND]
    if not waiting and not any(one.rare for one in measured if one.kind == kind):
        waiting = [one for one in ranked if one.rare and one.key not in again][:1]
    return waiting[:ROUND]


def is_close(spec: ComparisonTable, one: Candidate, best: Candidate) -> bool:
    """Whether the mean errors of two candidates differ by less than what counts."""
    return one.size - best.size <= CLOSE * one.size + spec.negligible


def related(spec: ComparisonTable, one: Candidate, other: Candidate, comparisons: int = 1) -> Relation:
    """How `one` does against `other` on the draws that both have met."""
    common = one.rows.index.intersection(other.rows.index)
    first, second = one.rows.loc[common], other.rows.loc[common]
    return paired(
        first[one.error_column].to_numpy(float),
        second[other.error_column].to_numpy(float),
        negligible=spec.negligible,
        solver_error=one.solver_error + other.solver_error,
        probability=spec.probability,
        comparisons=comparisons,
    )
