"""What suffices at a speed and a spread: the candidates of the search, those measured again, and the choice."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from workbench.decide.judged import KINDS, Judged, Kind
from workbench.decide.order import contenders, ordered, possible
from workbench.decide.schema import DecideTable


@dataclass(frozen=True)
class Answer:
    """What suffices: the first of `KINDS` of which a candidate surely does, with that `best`; None: nothing does.

    Where nothing surely does, `best` is the nearest. `open` are those of which the draws cannot tell, that would come
    before the best. `settled`: they leave the kind as it is.
    """

    kind: Kind | None
    best: Judged
    open: tuple[Judged, ...]
    settled: bool

    @property
    def doubtful(self) -> tuple[Kind, ...]:
        """The kinds simpler than that of the choice of which the draws cannot tell."""
        last = 0 if self.kind is None else KINDS.index(self.kind)
        return tuple(kind for kind in KINDS[:last] if any(row.kind == kind for row in self.open))


@dataclass(eq=False)
class Cell:
    """A speed (m/s) and a spread: what the search found of each candidate, and those `measured` again, in order."""

    speed: float
    spread: float
    table: DecideTable
    search: Sequence[Judged]
    measured: list[Judged] = field(default_factory=list)

    def next(self) -> Judged | None:
        """The contender to be measured now; None once one is sure to meet what is asked, or all are measured."""
        if any(row.standing(self.table) == "meets" for row in self.measured):
            return None
        return next(iter(self._waiting()), None)

    def next_to_compare(self) -> Judged | None:
        """The first contender of a kind of which none is measured yet; None once there is none."""
        kinds = {row.kind for row in self.measured}
        return next((row for row in self._waiting() if row.kind not in kinds), None)

    def _waiting(self) -> list[Judged]:
        measured = {row.candidate for row in self.measured}
        return [row for row in contenders(self.search, self.table) if row.candidate not in measured]

    @property
    def rows(self) -> list[Judged]:
        """Every candidate by its fresh draws where it has such, else by those of the search."""
        fresh = {row.candidate: row for row in self.measured}
        return [fresh.get(row.candidate, row) for row in self.search]

    @property
    def ordered(self) -> list[Judged]:
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
