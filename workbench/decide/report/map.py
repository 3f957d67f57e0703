"""The matrix of a decision: speed by spread, a field each with what suffices and what fails of what is simpler."""

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from workbench.decide.candidate import KINDS, CandidateResult, Kind
from workbench.decide.report.answer import failed_draws, nearest
from workbench.decide.report.names import MM, NAMES, SHORT, choice, interval, share, watts
from workbench.decide.result import Answer, Cell, Decision

OPEN = "cannot be told"

COLOURS: dict[str, tuple[str, str]] = {
    "plain control": ("#ffffff", ""),
    "compensation": ("#9fc6e6", "///"),
    "rotation": ("#f2b48a", "..."),
    "rotation with compensation": ("#dfa9c6", "xx"),
    "nothing": ("#8c8c8c", "\\\\\\"),
    OPEN: ("#f5e79e", ""),
}
"""Colour (Okabe and Ito's, lightened) and hatch of each word: hatches keep them apart in grey print."""

MEANING = {
    "plain control": "plain control suffices",
    "compensation": "compensation suffices (rod at rest)",
    "rotation": "only rotation suffices",
    "rotation with compensation": "only rotation with compensation suffices",
    "nothing": "nothing suffices (named: the nearest)",
    OPEN: "cannot be told with these draws",
}


@dataclass(frozen=True)
class Field:
    """One field: its word, the choice (or nearest) with its probability, and a line for each kind that fails.

    `doubtful` are the kinds that are simpler than the choice's, of which the draws do not tell whether they suffice.
    """

    word: str
    choice: str
    chance: str
    price: str
    fails: tuple[tuple[Kind, str], ...]
    doubtful: tuple[Kind, ...]
    asked: bool

    @property
    def colour(self) -> str:
        """Its background."""
        return COLOURS[self.word][0]

    @property
    def lines(self) -> list[str]:
        """What stands under its word."""
        failing = [f"{SHORT[kind]} fails by {what}" for kind, what in self.fails]
        open_ = [f"of {SHORT[kind]} it cannot be told" for kind in self.doubtful]
        return [line for line in (self.choice, self.chance, self.price, *failing, *open_) if line]


def word_of(given: Answer) -> str:
    """What a field says in a word."""
    return NAMES[given.kind] if given.settled else OPEN


def fields(decision: Decision) -> dict[str, list[Field]]:
    """The matrix: a row a spread, a column a speed."""
    plan = decision.plan
    return {
        f"{spread:g} std": [_field(decision, decision.at(speed, spread)) for speed in plan.speeds]
        for spread in plan.spreads
    }


def heads(decision: Decision) -> list[str]:
    """Its columns."""
    return [f"{speed * MM:g} mm/s" for speed in decision.plan.speeds]


def _field(decision: Decision, cell: Cell) -> Field:
    given = cell.answer()
    best, several = given.best, decision.plan.several
    chance = f"{share(best.probability)} ({interval(best)})" if best.stage == "fresh" else share(best.probability)
    return Field(
        word_of(given),
        choice(best) if given.kind is not None or given.open else f"nearest: {choice(best)}",
        chance if several else "",
        watts(best.mean_power) if best.mean_power == best.mean_power else "",
        tuple((row.kind, failed_draws(row)) for row in failing(decision, cell)),
        given.doubtful,
        cell is decision.asked,
    )


def failing(decision: Decision, cell: Cell) -> list[CandidateResult]:
    """The best of each kind that is simpler than the choice, or of every kind where nothing suffices, that fails."""
    given = cell.answer()
    last = len(KINDS) if given.kind is None else KINDS.index(given.kind)
    rows = [nearest(decision, cell.speed, cell.spread, kind) for kind in KINDS[:last]]
    return [row for row in rows if row is not None and row.standing(decision.table) == "fails"]


def map_table(decision: Decision) -> pd.DataFrame:
    """The same as a table of text."""
    rows = fields(decision)
    return pd.DataFrame(
        [
            {"spread of friction": name, **dict(zip(heads(decision), map(_cell, row), strict=True))}
            for name, row in rows.items()
        ]
    )


def _cell(field: Field) -> str:
    return f"{field.word}: {'; '.join(field.lines)}"


def key(decision: Decision) -> Sequence[tuple[str, str, str]]:
    """Word, colour and meaning of each word that the matrix holds."""
    used = {field.word for row in fields(decision).values() for field in row}
    return [(word, COLOURS[word][0], MEANING[word]) for word in COLOURS if word in used]
