"""What the wizard proposes: lines of an experiment file, each with its reason, and a question where nobody can know."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

Ask = Callable[[str, str], str]
"""Puts a question to a user, with the guess as what is taken without an answer, and returns the answer."""


@dataclass(frozen=True)
class Question:
    """What is asked of a line: in words, and which of its keys the answer is for."""

    words: str
    key: str = ""


@dataclass(frozen=True)
class Line:
    """A key of a table with values, the reason for them, and what has to be asked.

    A line with several values is an inline table; the one value of a plain key has the name "". Values are text, or
    numbers.
    """

    name: str
    values: dict[str, str | float | int]
    reason: str
    questions: tuple[Question, ...] = ()

    def asked(self, ask: Ask | None) -> "Line":
        """A plain key as a user answers its questions; as it is where nobody can be asked."""
        if ask is None or not self.questions:
            return self
        value = ask(self.questions[0].words, str(self.values[""]))
        return replace(self, values={"": value}, reason="answered", questions=())


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
    def questions(self) -> list[Question]:
        """All that is left to be answered."""
        return [question for line in (self.plant, *self.values, *self.channels) for question in line.questions]
