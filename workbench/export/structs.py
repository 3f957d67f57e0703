"""NamedTuples of numbers as C: a struct a class, without the numbers that do not count, and their values."""

import inspect
import re
from collections.abc import Callable, Collection, Iterator
from typing import Any, NamedTuple

from workbench.export.statements import INDENT, Precision, comment
from workbench.export.walk import Path, members_of

EMPTY = ("char", "none", "nothing counts here, and C has no empty struct")
"""The member of a struct that would have none."""


class StructMember(NamedTuple):
    """A member of a struct: its C type, its name, and what is said of it: a unit."""

    type: str
    name: str
    note: str


class Struct(NamedTuple):
    """A struct: its C type, what the class says of itself, its members."""

    type: str
    summary: str
    members: tuple[StructMember, ...]


def structs(
    cls: type[NamedTuple],
    used: Collection[Path],
    name: str,
    prefix: str,
    number: str,
    unit: Callable[[str], str],
) -> list[Struct]:
    """The structs for a class and those nested in it, each before the first that holds it.

    Args:
        cls: a NamedTuple class.
        used: the paths of its numbers that count.
        name: of its struct; those of nested ones are made of their classes' names.
        prefix: before every name.
        number: the C type of a number.
        unit: what a unit is called here.
    """
    fields = {one: _used_fields(one, cls, used) for one in _classes(cls, used)}
    called = {one: f"{prefix}_{name if one is cls else snake(one.__name__)}" for one in fields}
    return [_struct(one, kept, called, number, unit) for one, kept in fields.items()]


def _struct(
    cls: type[NamedTuple],
    kept: Collection[str],
    called: dict[type[NamedTuple], str],
    number: str,
    unit: Callable[[str], str],
) -> Struct:
    members = [
        StructMember(number, item.name, unit(item.unit))
        if item.nested is None
        else StructMember(called[item.nested], item.name, "")
        for item in members_of(cls)
        if item.name in kept
    ]
    return Struct(called[cls], _said(cls), tuple(members) or (StructMember(*EMPTY),))


def initializer(value: Any, used: Collection[Path], precision: Precision, indent: str = INDENT) -> list[str]:
    """The members of a struct with the values of a tuple, by name, a line each."""
    lines: list[str] = []
    cls: Any = type(value)
    for member in members_of(cls):
        below = [path[1:] for path in used if path[0] == member.name]
        item = getattr(value, member.name)
        if below and member.nested is not None:
            inner = initializer(item, below, precision, indent + INDENT)
            lines += [f"{indent}.{member.name} = {{", *inner, f"{indent}}},"]
        elif below:
            lines.append(f"{indent}.{member.name} = {precision.number(float(item))},")
    return lines


def snake(name: str) -> str:
    """The name of a class as C has names: "EstimatorState" is "estimator_state"."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def _classes(cls: type[NamedTuple], used: Collection[Path]) -> Iterator[type[NamedTuple]]:
    """The class and those nested in it of which anything counts, innermost first."""
    found = dict[type[NamedTuple], None]()
    for member in members_of(cls):
        below = [path[1:] for path in used if path[0] == member.name]
        if below and member.nested is not None:
            found |= dict.fromkeys(_classes(member.nested, below))
    yield from [*found, cls]


def _used_fields(one: type[NamedTuple], cls: type[NamedTuple], used: Collection[Path]) -> set[str]:
    """The fields of a class that count wherever it is nested in `cls`."""
    found = {path[0] for path in used} if one is cls else set()
    for member in members_of(cls):
        below = [path[1:] for path in used if path[0] == member.name]
        if below and member.nested is not None:
            found |= _used_fields(one, member.nested, below)
    return found


def _said(cls: type[NamedTuple]) -> str:
    """The first paragraph of what a class says of itself, "" where that is only Python's own."""
    said = inspect.cleandoc(cls.__doc__ or "")
    if said.startswith(f"{cls.__name__}("):
        return ""
    return comment(" ".join(said.partition("\n\n")[0].split()))
