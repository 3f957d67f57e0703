"""What the wizard proposes: lines of an experiment file, each with its reason, and a question where nobody can know."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path


@dataclass(frozen=True)
class Question:
    """What is asked of a line: in words, and which of its keys the answer is for."""

    words: str
    key: str


@dataclass(frozen=True)
class Line:
    """A key of a table with values, the reason for them, and what has to be asked.

    A line with several values is an inline table. Values are text, or numbers.
    """

    name: str
    values: dict[str, str | float | int]
    reason: str
    questions: tuple[Question, ...] = ()

    def answered(self, question: Question, answer: str) -> "Line":
        """The line with an answer to a question of it; one that is a guess confirmed stays a guess confirmed."""
        old = self.values[question.key]
        value: str | float | int = answer
        if not isinstance(old, str) or question.key in ("scale", "column"):
            value = _number(answer)
        left = tuple(other for other in self.questions if other is not question)
        reason = self.reason if value == old else "answered"
        return replace(self, values={**self.values, question.key: value}, questions=left, reason=reason)


def _number(text: str) -> str | float | int:
    try:
        return int(text)
    except ValueError:
        pass
    try:
        return float(text)
    except ValueError:
        return text


@dataclass(frozen=True)
class Proposal:
    """A whole experiment file; `unused` are columns that became no channel, and why."""

    title: str
    plant: Line
    parameters: str
    values: Sequence[Line]
    fit: Sequence[Line]
    channels: Sequence[Line]
    records: Sequence[tuple[Path, str, str]]
    unused: Sequence[str] = field(default=())

    @property
    def questions(self) -> list[tuple[Line, Question]]:
        """All questions, with their lines."""
        return [(line, question) for line in self.lines for question in line.questions]

    @property
    def lines(self) -> list[Line]:
        """All lines that may be asked for."""
        return [self.plant, *self.values, *self.channels]

    def replaced(self, old: Line, new: Line) -> "Proposal":
        """The proposal with one line in another's place."""
        swap = {id(old): new}
        return replace(
            self,
            plant=swap.get(id(self.plant), self.plant),
            values=[swap.get(id(line), line) for line in self.values],
            channels=[swap.get(id(line), line) for line in self.channels],
        )
