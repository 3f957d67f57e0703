"""The result of a decision: at each speed and spread the candidates, those measured again, and what suffices."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import pandas as pd

from workbench.decide.candidate import KINDS, CandidateResult, Kind
from workbench.decide.order import contenders, ordered, possible
from workbench.decide.plan import Plan
from workbench.decide.schema import DecideTable


@dataclass(frozen=True)
class Answer:
    """What suffices: the first of `KINDS` of which a candidate surely does, with that `best`; None: nothing does.

    Where nothing surely does, `best` is the nearest. `open` are those of which the draws cannot tell, that would come
    before the best. `settled`: they leave the kind as it is.
    """

    kind: Kind | None
    best: CandidateResult
    open: tuple[CandidateResult, ...]
    settled: bool

    @property
    def doubtful(self) -> tuple[Kind, ...]:
        """The kinds simpler than that of the choice of which the draws cannot tell."""
        last = 0 if self.kind is None else KINDS.index(self.kind)
        return tuple(kind for kind in KINDS[:last] if any(row.kind == kind for row in self.open))


@dataclass(frozen=True, eq=False)
class Cell:
    """A speed (m/s) and a spread: what the search found of each candidate, and those `measured` again, in order."""

    speed: float
    spread: float
    table: DecideTable
    search: Sequence[CandidateResult]
    measured: Sequence[CandidateResult] = ()

    def with_measured(self, rows: Iterable[CandidateResult]) -> "Cell":
        """The same with these measured after those that are."""
        return replace(self, measured=(*self.measured, *rows))

    def next(self) -> CandidateResult | None:
        """The contender to be measured now; None once one is sure to meet what is asked, or all are measured."""
        if any(row.standing(self.table) == "meets" for row in self.measured):
            return None
        return next(iter(self._waiting()), None)

    def next_to_compare(self) -> CandidateResult | None:
        """The first contender of a kind of which none is measured yet; None once there is none."""
        kinds = {row.kind for row in self.measured}
        return next((row for row in self._waiting() if row.kind not in kinds), None)

    def _waiting(self) -> list[CandidateResult]:
        measured = {row.candidate for row in self.measured}
        return [row for row in contenders(self.search, self.table) if row.candidate not in measured]

    @property
    def rows(self) -> list[CandidateResult]:
        """Every candidate by its fresh draws where it has such, else by those of the search."""
        fresh = {row.candidate: row for row in self.measured}
        return [fresh.get(row.candidate, row) for row in self.search]

    @property
    def ordered(self) -> list[CandidateResult]:
        """The same from the best on: the choice, what was measured in order of its standing, then the others."""
        best = self.answer().best
        rest = [row for row in self.rows if row is not best]
        ranks = {"meets": 0, "open": 1, "fails": 2}
        fresh = [row for row in rest if row.stage == "fresh" and row.standing(self.table) != "fails"]
        last = [row for row in rest if row not in fresh]
        return [
            best,
            *sorted(ordered(fresh, self.table), key=lambda row: ranks[row.standing(self.table)]),
            *ordered(last, self.table),
        ]

    def answer(self) -> Answer:
        """What suffices, by the fresh draws alone; what they rule out is out."""
        standing = {row.candidate: row.standing(self.table) for row in self.measured}
        sure = next((row for row in self.measured if standing[row.candidate] == "meets"), None)
        before = self.measured if sure is None else self.measured[: self.measured.index(sure)]
        told_not = tuple(row for row in before if standing[row.candidate] == "open")
        unmeasured = len(possible(self.search, self.table)) > len(self.measured) and sure is None
        if sure is not None:
            given = Answer(sure.kind, sure, told_not, True)
            return replace(given, settled=not given.doubtful)
        nearest = max(told_not, key=lambda row: row.probability) if told_not else ordered(self.rows, self.table)[0]
        return Answer(None, nearest, told_not, not told_not and not unmeasured)

    def to_json(self) -> dict[str, object]:
        """What suffices there, and every candidate, as JSON holds it."""
        answer = self.answer()
        return {
            "speed_m_per_s": self.speed,
            "spread": self.spread,
            "kind": answer.kind,
            "settled": answer.settled,
            "best": answer.best.to_json(self.table),
            "open": [row.to_json(self.table) for row in answer.open],
            "candidates": [row.to_json(self.table) for row in self.rows],
        }


@dataclass(frozen=True, eq=False)
class Decision:
    """The runs of a plan (a row each), and what they say at each speed and spread."""

    plan: Plan
    draws: pd.DataFrame
    cells: Sequence[Cell]

    @property
    def table(self) -> DecideTable:
        """What was asked."""
        return self.plan.table

    @property
    def asked(self) -> Cell:
        """The speed and spread that were asked for."""
        return self.at(self.table.speed, self.table.spread)

    def at(self, speed: float, spread: float) -> Cell:
        """A speed (m/s) and a spread of the map."""
        return next(cell for cell in self.cells if (cell.speed, cell.spread) == (speed, spread))

    def answer(self, speed: float, spread: float) -> Answer:
        """What suffices there."""
        return self.at(speed, spread).answer()

    @property
    def provenance(self) -> dict[str, object]:
        """What was asked, and of which machines, as JSON holds it."""
        file = self.plan.study.file
        return {
            "title": file.title,
            "study": self.plan.study.fingerprint,
            "decide": self.table.model_dump(mode="json"),
            "uncertainty": None if file.uncertainty is None else file.uncertainty.model_dump(mode="json"),
            "runs": len(self.draws),
        }

    def to_json(self) -> dict[str, object]:
        """What was asked, and under `cells` what suffices at each speed and spread, as JSON holds it."""
        return {**self.provenance, "cells": [cell.to_json() for cell in self.cells]}
