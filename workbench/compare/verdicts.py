"""What the draws say of each cell: compensate, avoid, both, neither, or that they do not tell.

Each class sends one candidate, the best of the draws that all candidates met; they are compared in pairs on the fresh
draws, where there are any. A difference counts only if its whole interval lies beyond what counts, so chance moves a
verdict to "cannot be told" before it turns it around.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Literal

import pandas as pd

from workbench.compare.candidates import CLASSES, Candidate, Cell, Class, by_class, cells_of, of_tuned, order, sound
from workbench.compare.finalists import related
from workbench.compare.intervals import Interval, Relation, Word, interval_of_mean
from workbench.compare.schema import ComparisonTable

Kind = Literal[
    "compensate", "avoid", "both", "nothing needed", "level", "cannot be told", "none holds", "no comparison"
]

COMPARISONS = len(list(combinations(CLASSES, 2)))
"""Pairs of classes that a verdict may rest on."""


NAMED: Mapping[Kind, Class] = {
    "nothing needed": "nothing",
    "compensate": "compensate",
    "avoid": "avoid",
    "both": "both",
}
"""The class that a verdict names, where it names one."""


@dataclass(frozen=True, eq=False)
class Verdict:
    """What is said of one cell.

    `best` has the candidate of each class as measured for the verdict, none for a class whose candidates all have a
    flaw; `flawed` has those candidates, as they were measured last; `candidates` all that were measured for the
    verdict, in the order in which they were chosen.
    `fresh`: whether the draws are ones that no choice has seen. `rare` has of each class the best that may hunt rarely,
    where it errs less than whoever holds; `otherwise` is the verdict if these did hold, where it is another, and the
    verdict then is that this cannot be told; `strictly` is the one if none of them does.
    """

    kind: Kind
    best: Mapping[Class, Candidate]
    relations: Mapping[tuple[Class, Class], Relation]
    flawed: Mapping[Class, list[Candidate]] = field(default_factory=dict)
    candidates: list[Candidate] = field(default_factory=list)
    fresh: bool = False
    rare: Mapping[Class, Candidate] = field(default_factory=dict)
    strictly: Kind | None = None
    otherwise: Kind | None = None

    def relation(self, one: Class, other: Class) -> Relation:
        """How the candidate of one class does against that of another."""
        found = self.relations.get((one, other))
        return found if found is not None else self.relations[other, one].reversed

    @property
    def pair(self) -> tuple[Class, Class] | None:
        """The two classes whose difference the verdict tells: the one that is named, and its rival."""
        if self.kind == "level":
            return self._first("is level with")
        if self.kind == "cannot be told":
            return None if self.otherwise else self._first("cannot be told from")
        if self.kind not in NAMED:
            return None
        one = NAMED[self.kind]
        rivals = CLASSES[1:] if one == "nothing" else ("compensate", "avoid")
        there = [kind for kind in rivals if kind in self.best and kind != one]
        return (one, min(there, key=lambda kind: self.best[kind].size)) if there else None

    @property
    def turning(self) -> Candidate | None:
        """The rotating candidate that is, or would be, chosen; None where there is none or nothing is to be chosen."""
        if self.kind in ("nothing needed", "no comparison", "none holds"):
            return None
        return self.best.get("both" if self.kind == "both" else "avoid")

    @property
    def still(self) -> Candidate | None:
        """The candidate at rest beside which it has its price."""
        return self.best.get("compensate", self.best.get("nothing"))

    @property
    def together(self) -> Relation | None:
        """How compensation with rotation does against the one of the two that the verdict names."""
        if self.kind not in ("compensate", "avoid") or "both" not in self.best:
            return None
        return self.relation("both", NAMED[self.kind])

    def _first(self, word: Word) -> tuple[Class, Class]:
        """The first pair with this relation, compensation against rotation in front."""
        pairs = sorted(self.relations, key=lambda pair: pair != ("compensate", "avoid"))
        return next(pair for pair in pairs if self.relations[pair].word == word)

    @property
    def draws(self) -> int:
        """The draws that every candidate of the cell has met."""
        return min((len(one.rows) for one in self.best.values()), default=0)


def verdicts(spec: ComparisonTable, frame: pd.DataFrame, fresh: pd.DataFrame | None = None) -> dict[Cell, Verdict]:
    """The verdict of each cell: chosen from `frame`, and measured in `fresh` where there is such a frame."""
    found = cells_of(spec, of_tuned(spec, frame))
    again = {} if fresh is None else cells_of(spec, of_tuned(spec, fresh))
    return {cell: _verdict(spec, candidates, again.get(cell)) for cell, candidates in found.items()}


def _verdict(spec: ComparisonTable, searched: list[Candidate], fresh: list[Candidate] | None) -> Verdict:
    """The verdict of one cell."""
    measured = searched if fresh is None else fresh
    best, flawed, rare = _standing(searched, measured)
    places = {one.key: i for i, one in enumerate(sound(sorted(searched, key=order)))}
    measured = sorted(measured, key=lambda one: places.get(one.key, len(places)))
    relations = _relations(spec, best)
    made = Verdict("no comparison", best, relations, flawed, measured, fresh is not None, rare)
    strictly = _kind(spec, made)
    among = best | rare
    otherwise = _kind(spec, replace(made, best=among, relations=_relations(spec, among))) if rare else strictly
    if strictly == otherwise:
        return replace(made, kind=strictly)
    return replace(made, kind="cannot be told", strictly=strictly, otherwise=otherwise)


def _standing(
    searched: list[Candidate], measured: list[Candidate]
) -> tuple[dict[Class, Candidate], dict[Class, list[Candidate]], dict[Class, Candidate]]:
    """`best`, `flawed` and `rare` of a verdict: by class the first that holds, all where none does, and the first that
    may hunt rarely in front of it.
    """
    again = {one.key: one for one in measured}
    best: dict[Class, Candidate] = {}
    flawed: dict[Class, list[Candidate]] = {}
    rare: dict[Class, Candidate] = {}
    for side, ranked in by_class(searched).items():
        known = [_both(one, again[one.key]) for one in ranked if one.key in again]
        holds = next((i for i, one in enumerate(known) if not one.flaw), len(known))
        if holds < len(known):
            best[side] = known[holds]
        elif ranked:
            flawed[side] = [again.get(one.key, one) for one in ranked]
        rarely = next((one for one in known[:holds] if one.rare), None)
        if rarely is not None and (side not in best or rarely.size < best[side].size):
            rare[side] = rarely
    return best, flawed, rare


def _both(searched: Candidate, measured: Candidate) -> Candidate:
    """A candidate as it was measured; one that has a flaw on the draws of the search alone keeps it."""
    if measured is searched or measured.flaw or not searched.flaw:
        return measured
    hunting = searched.hunting[0] + measured.hunting[0], searched.hunting[1] + measured.hunting[1]
    return replace(measured, flaw=searched.flaw, hunting=hunting)


def _relations(spec: ComparisonTable, best: Mapping[Class, Candidate]) -> dict[tuple[Class, Class], Relation]:
    """Each class that has a candidate against each other."""
    pairs = [(one, other) for one, other in combinations(CLASSES, 2) if one in best and other in best]
    return {(one, other): related(spec, best[one], best[other], COMPARISONS) for one, other in pairs}


def _kind(spec: ComparisonTable, made: Verdict) -> Kind:
    """What the relations of a cell say. A class whose candidates all have a flaw loses to whoever has none."""
    if not made.best:
        return "none holds"
    for side in ("compensate", "avoid"):
        if side not in made.best and side not in made.flawed:
            return "no comparison"

    def beats(one: Class, other: Class) -> bool:
        if one not in made.best:
            return False
        return other not in made.best or made.relation(one, other).word == "beats"

    if "nothing" in made.best and _suffices(spec, made):
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


def _suffices(spec: ComparisonTable, made: Verdict) -> bool:
    """Whether a plain controller at rest errs less than what may be neglected, or is beaten by nothing."""
    others = [kind for kind in CLASSES[1:] if kind in made.best]
    words = [made.relation("nothing", kind).word for kind in others]
    return within(spec, made.best["nothing"]) or all(word in ("beats", "is level with") for word in words)


def within(spec: ComparisonTable, one: Candidate) -> bool:
    """Whether the mean error of a candidate is negligible, up to the end of its interval."""
    return size_of(spec, one).high <= spec.negligible


def size_of(spec: ComparisonTable, one: Candidate) -> Interval:
    """The mean error of a candidate (m) over the draws, with its interval: no error is below 0."""
    found = interval_of_mean(one.errors, spec.probability)
    return replace(found, low=max(found.low, 0.0))
