"""What the plant samples say of each cell: compensate, avoid, both, neither, or that they do not tell.

Each class sends one candidate, the best of the samples that all candidates met; they are compared in pairs on the fresh
samples, where there are any. A difference counts only if its whole interval lies beyond what counts, so chance moves a
verdict to "cannot be told" before it turns it around.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import pandas as pd

from workbench.compare.candidates import CLASSES, Candidate, Cell, Class, HuntingCount, by_class, order, sound
from workbench.compare.cells import Cells, cells_of, of_tuned
from workbench.compare.finalists import related
from workbench.compare.intervals import Relation
from workbench.compare.result import Kind, Verdict
from workbench.compare.schema import ComparisonTable

COMPARISONS = len(list(combinations(CLASSES, 2)))
"""Pairs of classes that a verdict may rest on."""


def verdicts_of(table: ComparisonTable, frame: pd.DataFrame, fresh: pd.DataFrame | None = None) -> dict[Cell, Verdict]:
    """The verdict of each cell: chosen from `frame`, and measured in `fresh` where there is such a frame."""
    measured = None if fresh is None else cells_of(table, of_tuned(table, fresh))
    return judged(table, cells_of(table, of_tuned(table, frame)), measured)


def judged(table: ComparisonTable, searched: Cells, measured: Cells | None) -> dict[Cell, Verdict]:
    """The same of the candidates of each cell."""
    again = {} if measured is None else measured
    return {cell: _verdict(table, candidates, again.get(cell)) for cell, candidates in searched.items()}


def _verdict(table: ComparisonTable, searched: Sequence[Candidate], fresh: Sequence[Candidate] | None) -> Verdict:
    """The verdict of one cell."""
    measured = searched if fresh is None else fresh
    best, flawed, rare = _standing(searched, measured)
    places = {candidate.key: i for i, candidate in enumerate(sound(sorted(searched, key=order)))}
    measured = sorted(measured, key=lambda candidate: places.get(candidate.key, len(places)))
    relations = _relations(table, best)
    made = Verdict("no comparison", best, relations, flawed, measured, fresh is not None, rare)
    strictly = _kind(table, made)
    among = best | rare
    otherwise = _kind(table, replace(made, best=among, relations=_relations(table, among))) if rare else strictly
    if strictly == otherwise:
        return replace(made, kind=strictly)
    return replace(made, kind="cannot be told", strictly=strictly, otherwise=otherwise)


def _standing(
    searched: Sequence[Candidate], measured: Sequence[Candidate]
) -> tuple[dict[Class, Candidate], dict[Class, list[Candidate]], dict[Class, Candidate]]:
    """`best`, `flawed` and `rare` of a verdict: by class the first that holds, all where none does, and the first that
    may hunt rarely in front of it.
    """
    again = {candidate.key: candidate for candidate in measured}
    best: dict[Class, Candidate] = {}
    flawed: dict[Class, list[Candidate]] = {}
    rare: dict[Class, Candidate] = {}
    for side, ranked in by_class(searched).items():
        known = [_both(candidate, again[candidate.key]) for candidate in ranked if candidate.key in again]
        holds = next((i for i, candidate in enumerate(known) if not candidate.flaw), len(known))
        if holds < len(known):
            best[side] = known[holds]
        elif ranked:
            flawed[side] = [again.get(candidate.key, candidate) for candidate in ranked]
        rarely = next((candidate for candidate in known[:holds] if candidate.rare), None)
        if rarely is not None and (side not in best or rarely.size < best[side].size):
            rare[side] = rarely
    return best, flawed, rare


def _both(searched: Candidate, measured: Candidate) -> Candidate:
    """A candidate as it was measured; one that has a flaw on the samples of the search alone keeps it."""
    if measured is searched or measured.flaw or not searched.flaw:
        return measured
    hunting = HuntingCount(
        searched.hunting.hunts + measured.hunting.hunts, searched.hunting.samples + measured.hunting.samples
    )
    return replace(measured, flaw=searched.flaw, hunting=hunting)


def _relations(table: ComparisonTable, best: Mapping[Class, Candidate]) -> dict[tuple[Class, Class], Relation]:
    """Each class that has a candidate against each other."""
    pairs = [(first, second) for first, second in combinations(CLASSES, 2) if first in best and second in best]
    return {(first, second): related(table, best[first], best[second], COMPARISONS) for first, second in pairs}


def _kind(table: ComparisonTable, made: Verdict) -> Kind:
    """What the relations of a cell say. A class whose candidates all have a flaw loses to whoever has none."""
    if not made.best:
        return "none holds"
    for side in ("compensate", "avoid"):
        if side not in made.best and side not in made.flawed:
            return "no comparison"

    def beats(first: Class, second: Class) -> bool:
        if first not in made.best:
            return False
        return second not in made.best or made.relation(first, second).word == "beats"

    if "nothing" in made.best and _suffices(table, made):
        return "nothing needed"
    if beats("both", "compensate") and beats("both", "avoid") and beats("both", "nothing"):
        return "both"
    if beats("compensate", "avoid") and beats("compensate", "nothing"):
        return "compensate"
    if beats("avoid", "compensate") and beats("avoid", "nothing"):
        return "avoid"
    told = all(relation.word != "cannot be told from" for relation in made.relations.values())
    level = made.relations.get(("compensate", "avoid"))
    alike = level is not None and level.word == "is level with"
    if alike and (beats("compensate", "nothing") or beats("avoid", "nothing")):
        return "level"
    return "level" if told else "cannot be told"


def _suffices(table: ComparisonTable, made: Verdict) -> bool:
    """Whether a plain controller at rest errs less than what may be neglected, or is beaten by nothing."""
    others = [kind for kind in CLASSES[1:] if kind in made.best]
    words = [made.relation("nothing", kind).word for kind in others]
    return within(table, made.best["nothing"]) or all(word in ("beats", "is level with") for word in words)


def within(table: ComparisonTable, candidate: Candidate) -> bool:
    """Whether the mean error of a candidate is negligible, up to the end of its interval."""
    return candidate.mean_error(table.probability).high <= table.negligible
