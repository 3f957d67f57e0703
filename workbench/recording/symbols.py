"""Equations recorded: numbers that remember how they were computed, so that code can be written of it.

    recording = Recording()
    a, b = recording.input("a"), recording.input("b")
    with recording.sources():
        total = equation(a, b)              # a Symbol; recording.instructions say how it is had

The order of operations is that of the equation, and nothing is rearranged: what is written of it rounds as NumPy does.
What the equation computes twice is recorded once. An equation that branches on a value cannot be recorded; `select`
can, and so can a loop whose length does not depend on one, which is written out.
"""

import inspect
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from workbench.recording.operations import CONDITIONS, NOT_THERE, OF_CONDITIONS, OPERATIONS, SAME

INPUT, NUMBER = "input", "number"
"""Instructions that compute nothing."""

PASSED = (str(Path(__file__).parents[1]), str(Path(np.__file__).parent), "equation.py")
"""Of the files of functions that are no equations: the workbench, NumPy, and `select` with its kin."""


class UnrecordableError(ValueError):
    """Why an equation cannot be recorded, in words that follow its name."""


@dataclass(frozen=True)
class Instruction:
    """One operation on results of earlier ones. `text`: the place of an input, or a number as Python spells it."""

    operation: str
    operands: tuple[int, ...] = ()
    text: str = ""


@dataclass(frozen=True)
class Source:
    """The equation in which an instruction stands: its name, and the first line of what it says of itself."""

    name: str
    summary: str


class Symbol(NDArrayOperatorsMixin):
    """The result of an instruction, which NumPy's functions and Python's operators take like a number."""

    __hash__ = None  # type: ignore[assignment]  # comparisons give symbols

    def __init__(self, recording: "Recording", place: int) -> None:
        self.recording, self.place = recording, place

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *values: Any, **options: Any) -> Any:
        if method != "__call__" or options:
            raise UnrecordableError(f"uses np.{ufunc.__name__} as no plain function of numbers")
        return self.recording.apply(SAME.get(ufunc.__name__, ufunc.__name__), values)

    def __array_function__(self, function: Callable[..., Any], types: Any, values: Any, options: Any) -> Any:
        if function is not np.where or len(values) != 3 or options:
            raise UnrecordableError(f"uses np.{function.__name__}, {NOT_THERE}")
        return self.recording.apply("where", values)

    def __bool__(self) -> bool:
        raise UnrecordableError(
            'branches on a value; in place of a condition ("if", "and", "max") use select(condition, a, b)'
        )

    def __float__(self) -> float:
        raise UnrecordableError("turns a value into a float; leave that out")


class Recording:
    """The instructions that equations were, in the order in which they were first met."""

    def __init__(self) -> None:
        self.instructions: list[Instruction] = []
        self.source: dict[int, Source] = {}
        self._known: dict[Instruction, int] = {}
        self._names: dict[int, str] = {}
        self._lent: dict[int, str] = {}
        self._within: list[Source] = []

    def input(self, text: str) -> Symbol:
        """A number that is given, at this place in C."""
        return self._symbol(Instruction(INPUT, (), text))

    def place(self, value: Any) -> int:
        """Where a symbol or a number stands.

        Raises:
            UnrecordableError: it is neither.
        """
        if isinstance(value, Symbol):
            return value.place
        if isinstance(value, bool | np.bool_ | str):
            raise UnrecordableError(f"computes with {value!r}, expected numbers")
        try:
            number = float(value)
        except (TypeError, ValueError):
            raise UnrecordableError(f"computes with a {type(value).__name__}, expected numbers") from None
        return self._symbol(Instruction(NUMBER, (), repr(number))).place

    def number_place(self, value: Any) -> int:
        """Where a symbol or a number stands, as a number: a condition is 1 where it holds, else 0.

        Raises:
            UnrecordableError: it is neither.
        """
        return self._as_number(self.place(float(value) if isinstance(value, bool | np.bool_) else value))

    def name(self, place: int) -> str:
        """What the equations call a result; "" where they have no name for it."""
        return self._names.get(place, self._lent.get(place, ""))

    def number(self, place: int) -> float | None:
        """The number at a place, None where it is computed or given."""
        instruction = self.instructions[place]
        return float(instruction.text) if instruction.operation == NUMBER else None

    def apply(self, operation: str, values: Sequence[object]) -> Any:
        """The result of an operation; of one that changes nothing, such as a product with 1, its operand.

        A condition of numbers alone is a bool.

        Raises:
            UnrecordableError: equations have no such operation.
        """
        if operation == "power" and isinstance(values[1], int):
            return self._whole_power(values[0], values[1])
        if operation == "square":
            return self._whole_power(values[0], 2)
        if operation not in OPERATIONS:
            raise UnrecordableError(f"uses np.{operation}, {NOT_THERE}")
        if operation == "where" and isinstance(values[0], bool | np.bool_):
            return self._symbol_at(self.place(values[1] if values[0] else values[2]))
        places = tuple(self.place(value) for value in values)
        if operation == "where" and self.instructions[places[0]].operation not in CONDITIONS:
            places = (self.apply("not_equal", (values[0], 0.0)).place, *places[1:])
        if operation == "where":
            places = (places[0], *(self._as_number(place) for place in places[1:]))
        if operation not in OF_CONDITIONS:
            places = tuple(self._as_number(place) for place in places)
        if operation != "where" and all(self.number(place) is not None for place in places):
            return self._computed(operation, places)
        kept = self._unchanged(operation, places)
        return Symbol(self, kept) if kept is not None else self._symbol(Instruction(operation, places))

    def _as_number(self, place: int) -> int:
        """A condition that is computed with: 1 where it holds, else 0."""
        if self.instructions[place].operation not in CONDITIONS:
            return place
        return self._symbol(Instruction("where", (place, self.place(1.0), self.place(0.0)))).place

    def _computed(self, operation: str, places: tuple[int, ...]) -> Any:
        """The result of an operation on numbers: a number, or a bool of a condition."""
        with np.errstate(all="ignore"):
            found = getattr(np, operation)(*(self.number(place) for place in places))
        return bool(found) if operation in CONDITIONS else self._symbol_at(self.place(found))

    def _unchanged(self, operation: str, places: tuple[int, ...]) -> int | None:
        """The operand that an operation gives as it is. A finite number times 0 is 0."""
        if operation == "where":
            return places[1] if places[1] == places[2] else None
        if operation not in ("add", "subtract", "multiply", "divide"):
            return None
        first, second = (self.number(place) for place in places)
        if operation == "multiply" and 0.0 in (first, second):
            return self.place(0.0)
        neutral = 0.0 if operation in ("add", "subtract") else 1.0
        if second == neutral:
            return places[0]
        return places[1] if first == neutral and operation in ("add", "multiply") else None

    def _whole_power(self, base: object, exponent: int) -> Any:
        """Repeated squaring, in the order in which compiled equations do it."""
        left, power = abs(exponent), self._symbol_at(self.place(base))
        result: Any = None
        while left:
            if left & 1:
                result = power if result is None else result * power
            left >>= 1
            if left:
                power = power * power
        if result is None:
            return self._symbol_at(self.place(1.0))
        return self.apply("divide", (1.0, result)) if exponent < 0 else self._symbol_at(result.place)

    def _symbol_at(self, place: int) -> Symbol:
        return Symbol(self, place)

    def _symbol(self, instruction: Instruction) -> Symbol:
        if instruction not in self._known:
            place = self._known[instruction] = len(self.instructions)
            self.instructions.append(instruction)
            if self._within:
                self.source[place] = self._within[-1]
        return Symbol(self, self._known[instruction])

    @contextmanager
    def sources(self) -> Iterator[None]:
        """Learn from the equations that run here what they call their results, and which of them computes what.

        What several of them name has the name that the innermost gives to a result of its own; one that is only
        handed to equations has that of the argument.
        """
        before = sys.getprofile()
        sys.setprofile(self._watch)
        try:
            yield
        finally:
            sys.setprofile(before)

    def _watch(self, frame: FrameType, event: str, _: object) -> None:
        if event not in ("call", "return") or frame.f_code.co_filename.startswith("<"):
            return
        if frame.f_code.co_filename.startswith(PASSED[:2]) or frame.f_code.co_filename.endswith(PASSED[2]):
            return
        code = frame.f_code
        if event == "call":
            self._within.append(Source(code.co_name, _summary(code.co_consts)))
            return
        if self._within:
            self._within.pop()
        arguments = code.co_varnames[: code.co_argcount]
        for name, value in frame.f_locals.items():
            names = self._lent if name in arguments else self._names
            for symbol, called in _named(value, name):
                names.setdefault(symbol.place, called)


def needed(recording: Recording, places: Iterable[int]) -> list[int]:
    """All places from which these are computed, themselves among them, in the order of the recording."""
    waiting, found = list(places), set[int]()
    while waiting:
        place = waiting.pop()
        if place not in found:
            found.add(place)
            waiting += recording.instructions[place].operands
    return sorted(found)


def _named(value: object, name: str) -> Iterator[tuple[Symbol, str]]:
    """The symbols in a local variable, each with a name: of a tuple with that of its field."""
    if isinstance(value, Symbol):
        yield value, name
    elif isinstance(value, tuple) and hasattr(value, "_fields"):
        for field, item in zip(value._fields, value, strict=True):
            if isinstance(item, Symbol):
                yield item, f"{name}_{field}"


def _summary(constants: tuple[object, ...]) -> str:
    """The first line of a function's docstring."""
    first = constants[0] if constants else None
    return inspect.cleandoc(first).partition("\n")[0] if isinstance(first, str) else ""
