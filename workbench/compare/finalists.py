"""Who is measured again on fresh draws: of each class of each cell those that may turn out to be its best.

The choice is made once, from the draws that all candidates met; the verdict rests on draws that no choice has seen, so
that having picked the best does not flatter it. The best of a class is that with the least geometric mean of its
errors: on this scale ratios are judged, and one bad draw does not decide.
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
from workbench.study.report_schema import ComparisonTable


def finalists(spec: ComparisonTable, frame: pd.DataFrame) -> list[dict[str, object]]:
    """The cases to be measured again: values of the axes machine and scenario (where the results have them),
    reference, controller and rpm, each once, in the order of the results.

    Whoever is measured again in motion is so in the references that hold still too, in which it might hunt.
    """
    frame = of_tuned(spec, frame)
    chosen: dict[tuple[Cell, str, float], None] = {}
    found = cells_of(spec, frame)
    for cell, candidates in found.items():
        for kind in CLASSES:
            for one in of_class(spec, candidates, kind):
                chosen[cell, one.controller, one.rpm] = None
    for cell, controller, rpm in list(chosen):
        for steps in spec.steps:
            if (still := cell._replace(reference=steps)) in found:
                chosen[still, controller, rpm] = None
    axes = [name for name in ("machine", "scenario") if name in frame]
    rows: list[dict[str, object]] = [
        {name: getattr(cell, name) for name in axes}
        | {"reference": cell.reference, "controller": one.controller, "rpm": one.rpm}
        for cell, candidates in found.items()
        for one in candidates
        if (cell, one.controller, one.rpm) in chosen
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
