"""The result of a comparison: the verdict of each cell, what it rests on, and what would change it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import pandas as pd

from workbench.compare.candidates import CLASSES, Candidate, Cell, Class
from workbench.compare.cells import of_tuned
from workbench.compare.intervals import Interval, Relation, Word
from workbench.compare.schema import ComparisonTable
from workbench.study.study import Study

Kind = Literal[
    "compensate", "avoid", "both", "nothing needed", "level", "cannot be told", "none holds", "no comparison"
]

NAMED: Mapping[Kind, Class] = {
    "nothing needed": "nothing",
    "compensate": "compensate",
    "avoid": "avoid",
    "both": "both",
}
"""The class that a verdict names, where it names one."""

AGAINST: frozenset[frozenset[Kind]] = frozenset({frozenset({"compensate", "avoid"})})
"""Verdicts that say the opposite of each other."""


@dataclass(frozen=True, eq=False)
class Verdict:
    """The verdict of one cell.

    `best` has the candidate of each class as measured for the verdict, none for a class whose candidates all have a
    flaw; `flawed` has those candidates, as they were measured last; `candidates` all that were measured for the
    verdict, in the order in which they were chosen.
    `fresh`: whether the plant samples are ones that no choice has seen. `rare` has of each class the best that may hunt
    rarely, where it errs less than whoever holds; `otherwise` is the verdict if these did hold, where it is another,
    and the verdict then is that this cannot be told; `strictly` is the one if none of them does.
    """

    kind: Kind
    best: Mapping[Class, Candidate]
    relations: Mapping[tuple[Class, Class], Relation]
    flawed: Mapping[Class, Sequence[Candidate]] = field(default_factory=dict)
    candidates: Sequence[Candidate] = ()
    fresh: bool = False
    rare: Mapping[Class, Candidate] = field(default_factory=dict)
    strictly: Kind | None = None
    otherwise: Kind | None = None

    def relation(self, first: Class, second: Class) -> Relation:
        """How the candidate of one class does against that of another."""
        known = self.relations.get((first, second))
        return known if known is not None else self.relations[second, first].reversed

    @property
    def pair(self) -> tuple[Class, Class] | None:
        """The two classes whose difference the verdict tells: the one that is named, and its rival."""
        if self.kind == "level":
            return self._first("is level with")
        if self.kind == "cannot be told":
            return None if self.otherwise else self._first("cannot be told from")
        if self.kind not in NAMED:
            return None
        named = NAMED[self.kind]
        rivals = CLASSES[1:] if named == "nothing" else ("compensate", "avoid")
        there = [kind for kind in rivals if kind in self.best and kind != named]
        return (named, min(there, key=lambda kind: self.best[kind].size)) if there else None

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
    def samples(self) -> int:
        """The plant samples that every candidate of the cell has met."""
        return min((candidate.samples for candidate in self.best.values()), default=0)

    def to_json(self, table: ComparisonTable) -> dict[str, object]:
        """As JSON holds it, SI; null for what is not finite."""
        return {
            "verdict": self.kind,
            "strictly": self.strictly,
            "otherwise": self.otherwise,
            "fresh": self.fresh,
            "best": {kind: _candidate_json(each, table) for kind, each in self.best.items()},
            "rare": {kind: _candidate_json(each, table) for kind, each in self.rare.items()},
            "relations": [
                {
                    "first": first,
                    "second": second,
                    "word": relation.word,
                    "ratio": _interval_json(relation.ratio),
                    "difference_m": _interval_json(relation.difference),
                    "draws": relation.samples,
                    "draws_needed": relation.needed,
                }
                for (first, second), relation in self.relations.items()
            ],
        }


def _candidate_json(candidate: Candidate, table: ComparisonTable) -> dict[str, object]:
    return {
        "controller": candidate.controller,
        "rpm": candidate.rpm,
        "family": candidate.family,
        "draws": candidate.samples,
        "hunting_draws": candidate.hunting.hunts,
        "error_m": _interval_json(candidate.mean_error(table.probability)),
        "paid_power_W": _finite(candidate.paid_power),
    }


def _interval_json(interval: Interval) -> dict[str, float | None]:
    return {"mean": _finite(interval.mean), "low": _finite(interval.low), "high": _finite(interval.high)}


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


@dataclass(frozen=True)
class Agreement:
    """The cells of two comparisons: how many both have, of how many; whose verdict moved, from which to which."""

    cells: int
    all_cells: int
    moved: Mapping[Cell, tuple[Kind, Kind]]

    @property
    def turned(self) -> dict[Cell, tuple[Kind, Kind]]:
        """The cells in which one says compensate and the other avoid."""
        return {cell: pair for cell, pair in self.moved.items() if frozenset(pair) in AGAINST}


@dataclass(frozen=True)
class Change:
    """What another condition makes of the verdicts: which of them, and what they would be in place of what they are."""

    condition: str
    agreement: Agreement


@dataclass(frozen=True, eq=False)
class Comparison:
    """Compensation against rotation in each cell of a study, by what [comparison] says, its `table`.

    `results` has a row a case, with a column for each axis, `fresh` the same of who was measured again on plant samples
    that no choice has seen; None where nobody was. `candidates` are those of `results`, but for the gains before.
    """

    study: Study
    table: ComparisonTable
    results: pd.DataFrame
    fresh: pd.DataFrame | None
    candidates: Mapping[Cell, Sequence[Candidate]]
    verdicts: Mapping[Cell, Verdict]
    changes: Sequence[Change]

    @cached_property
    def tuned(self) -> pd.DataFrame:
        """The results without controllers whose gains are those before."""
        return of_tuned(self.table, self.results)

    @cached_property
    def every_run(self) -> pd.DataFrame:
        """The same, and what was measured again."""
        return self.tuned if self.fresh is None else pd.concat([self.tuned, self.fresh], ignore_index=True)

    @property
    def machines(self) -> list[str]:
        """The machines by name, in the order of the results; one without a name where the study has no such axis."""
        return list(dict.fromkeys(cell.machine for cell in self.verdicts))

    @property
    def samples(self) -> int:
        """The plant samples from which the best were chosen."""
        return self.tuned["draw"].nunique()

    def of(self, machine: str) -> dict[Cell, Verdict]:
        """The verdicts of one machine."""
        return {cell: verdict for cell, verdict in self.verdicts.items() if cell.machine == machine}

    def at(self, scenario: str, reference: str, machine: str = "") -> Verdict:
        """The verdict of one cell; `machine` where the study has several."""
        return self.verdicts[Cell(machine, scenario, reference)]

    def to_json(self) -> dict[str, object]:
        """What was asked, and under `cells` the verdict of each, as JSON holds it."""
        return {
            "title": self.study.file.title,
            "study": self.study.fingerprint,
            "comparison": self.table.model_dump(mode="json"),
            "cells": [{**cell._asdict(), **verdict.to_json(self.table)} for cell, verdict in self.verdicts.items()],
            "changes": [
                {
                    "condition": change.condition,
                    "cells": change.agreement.cells,
                    "verdicts": [
                        {**cell._asdict(), "verdict": now, "would_be": other}
                        for cell, (now, other) in change.agreement.moved.items()
                    ],
                }
                for change in self.changes
            ],
        }
