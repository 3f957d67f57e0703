"""NamedTuples of numbers as C: a struct a class, without the numbers that do not count, and their values."""

import inspect
import re
from collections.abc import Callable, Collection
from typing import Any, NamedTuple

from workbench.errors import UserError
from workbench.export.c_words import KEYWORDS
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
    taken: set[str],
) -> list[Struct]:
    """The structs for a class and those nested in it, each before the first that holds it.

    Args:
        cls: a NamedTuple class.
        used: the paths of its numbers that count.
        name: of its struct; those of nested ones are made of their classes' names, and of their fields' where these
            do not tell them apart.
        prefix: before every name.
        number: the C type of a number.
        unit: what a unit is called here.
        taken: names that structs have; theirs are added.
    """
    called = {cls: f"{prefix}_{name}"}
    nested = _nested(cls, used)
    for one, field in nested.items():
        own = snake(one.__name__)
        called[one] = f"{prefix}_{own}" if own not in taken else f"{prefix}_{field}_{own}"
        taken.add(called[one].removeprefix(f"{prefix}_"))
    return [_struct(one, _used_fields(one, cls, used), called, number, unit) for one in (*nested, cls)]


def _struct(
    cls: type[NamedTuple],
    kept: Collection[str],
    called: dict[type[NamedTuple], str],
    number: str,
    unit: Callable[[str], str],
) -> Struct:
    kept_members = [item for item in members_of(cls) if item.name in kept]
    for item in kept_members:
        if item.name in KEYWORDS:
            raise UserError(f"{cls.__name__}.{item.name}: C knows this word as its own; give the field another name")
    members = [
        StructMember(number, item.name, unit(item.unit))
        if item.nested is None
        else StructMember(called[item.nested], item.name, "")
        for item in kept_members
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


def _nested(cls: type[NamedTuple], used: Collection[Path]) -> dict[type[NamedTuple], str]:
    """The classes nested in a class of which anything counts, innermost first, each with the field that holds it."""
    found = dict[type[NamedTuple], str]()
    for member in members_of(cls):
        below = [path[1:] for path in used if path[0] == member.name]
        if below and member.nested is not None:
            for one, field in (*_nested(member.nested, below).items(), (member.nested, member.name)):
                found.setdefault(one, field)
    return found


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
