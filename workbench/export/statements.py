"""What was recorded, as the lines of a C function that compute it, under the names that the equations have for it."""

import re
import textwrap
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from workbench.export.c_words import RESERVED
from workbench.export.operations import ATOM, LEAST, OPERATIONS, UNARY
from workbench.export.recorded import Function
from workbench.recording.operations import CONDITIONS
from workbench.recording.symbols import INPUT, NUMBER, Recording, Source, needed

WIDTH = 100
"""Columns of a line of C."""

INDENT = "    "

BEHIND_COMMENT = "   "

TIED = "\N{NO-BREAK SPACE}"
"""A space at which no line ends."""

OPERAND = re.compile(r"\{(\d)(:[<~])?\}")

LEAST_FLOAT, LARGEST_FLOAT = 1.1754943508222875e-38, 3.4028234663852886e38
"""Range of normal numbers of single precision; a guard against division by 0 is kept within it."""


@dataclass(frozen=True)
class Precision:
    """How numbers are written: the C type, what stands behind a number and a function of math.h, and infinity."""

    type: str
    suffix: str
    infinity: str

    def number(self, value: float) -> str:
        """A number in C."""
        if value != value:
            return f"({self.type})NAN"
        if abs(value) == float("inf"):
            return self.infinity if value > 0.0 else f"-{self.infinity}"
        if self.suffix and value and not LEAST_FLOAT <= abs(value) <= LARGEST_FLOAT:
            size = min(max(abs(value), LEAST_FLOAT), LARGEST_FLOAT)
            value = size if value > 0.0 else -size
        return repr(value) + self.suffix


DOUBLE, SINGLE = Precision("double", "", "HUGE_VAL"), Precision("float", "f", "HUGE_VALF")


def statements(recording: Recording, function: Function, precision: Precision) -> list[str]:
    """The lines of a function: what is used twice or has a name is a constant, then comes what it gives."""
    writer = _Writer(recording, function, precision)
    return [line for part in writer.lines() for line in wrapped(part)]


def wrapped(line: str) -> list[str]:
    """A statement on as many lines as it takes."""
    parts = textwrap.wrap(
        line,
        WIDTH,
        initial_indent=INDENT,
        subsequent_indent=INDENT + (BEHIND_COMMENT if line.startswith("/*") else INDENT),
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [part.replace(TIED, " ") for part in parts]


def helpers_of(recording: Recording, functions: tuple[Function, ...]) -> list[str]:
    """The helpers that functions call."""
    places = needed(recording, (place for function in functions for place in function.values()))
    called = {OPERATIONS[name].helper for name in _operations(recording, places)}
    return sorted(called - {""})


def counts(recording: Recording, *functions: Function) -> Counter[str]:
    """How many operations of each kind the functions take together, all branches counted."""
    found: Counter[str] = Counter()
    for function in functions:
        found.update(OPERATIONS[name].counted for name in _operations(recording, needed(recording, function.values())))
    return found


def _operations(recording: Recording, places: list[int]) -> Iterator[str]:
    names = (recording.instructions[place].operation for place in places)
    return (name for name in names if name not in (INPUT, NUMBER))


class _Writer:
    def __init__(self, recording: Recording, function: Function, precision: Precision) -> None:
        self._recording, self._function, self._precision = recording, function, precision
        self._places = needed(recording, function.values())
        uses = Counter(place for at in self._places for place in recording.instructions[at].operands)
        uses.update(function.values())
        taken = set(RESERVED)
        self._bound: dict[int, str] = {}
        for place in self._places:
            if recording.instructions[place].operation in (INPUT, NUMBER):
                continue
            name = recording.name(place)
            if name or uses[place] > 1:
                self._bound[place] = _free(name or "part", taken)

    def lines(self) -> Iterator[str]:
        """Constants in the order of the recording, then what the function sets and returns."""
        last, told = None, set[Source]()
        for place, name in self._bound.items():
            source = self._recording.source.get(place)
            if source is not None and source != last:
                said = f": {comment(source.summary)}" if source.summary and source not in told else ""
                yield f"/* {comment(source.name)}{said} */"
                told.add(source)
                last = source
            kind = "int" if self._is_condition(place) else self._precision.type
            yield f"const {kind} {name} = {self._expression(place, LEAST)};"
        for target, place in self._function.items():
            if target:
                yield f"{target} = {self._text(place, LEAST)};"
        if "" in self._function:
            yield f"return {self._text(self._function[''], LEAST)};"

    def _is_condition(self, place: int) -> bool:
        return self._recording.instructions[place].operation in CONDITIONS

    def _text(self, place: int, binding: int) -> str:
        return self._bound[place] if place in self._bound else self._expression(place, binding)

    def _expression(self, place: int, binding: int) -> str:
        """The operation at a place, in parentheses where it binds less closely than `binding`."""
        instruction = self._recording.instructions[place]
        if instruction.operation == INPUT:
            return instruction.text
        if instruction.operation == NUMBER:
            text = self._precision.number(float(instruction.text))
            binds = UNARY if text.startswith("-") else ATOM
        else:
            operation = OPERATIONS[instruction.operation]
            binds = operation.binds
            closeness = {None: binds + 1, ":<": binds, ":~": LEAST}

            def operand(found: re.Match[str]) -> str:
                return self._text(instruction.operands[int(found[1])], closeness[found[2]])

            text = OPERAND.sub(operand, operation.text.replace("$", self._precision.suffix).replace("_", TIED))
        return text if binds >= binding else f"({text})"


def _free(name: str, taken: set[str]) -> str:
    """The name, or that with a number behind it; it is taken then."""
    number, found = 1, name
    while found in taken:
        number += 1
        found = f"{name}_{number}"
    taken.add(found)
    return found


def comment(text: str) -> str:
    """Text that may stand in a comment of C."""
    return re.sub(r"\?{2,}", "?", text.replace("*/", "* /").replace("/*", "/ *")).rstrip("\\")
