"""NamedTuples of numbers, walked through by path: ("estimator", "first")."""

import functools
import typing
from typing import Any, NamedTuple, TypeAlias

Path: TypeAlias = tuple[str, ...]
"""The names of fields that lead to a number, or to a tuple of numbers."""


class Member(NamedTuple):
    """A field: its name, the NamedTuple class of what it holds, None for a number, and then that number's unit."""

    name: str
    nested: type[NamedTuple] | None
    unit: str


@functools.cache
def members_of(cls: type[NamedTuple]) -> tuple[Member, ...]:
    """The fields of a NamedTuple class."""
    hints = typing.get_type_hints(cls, include_extras=True)
    return tuple(_member(name, hints[name]) for name in cls._fields)


def _member(name: str, hint: Any) -> Member:
    if typing.get_origin(hint) is typing.Annotated:
        return Member(name, None, str(hint.__metadata__[0]))
    return Member(name, None, "") if hint is float else Member(name, hint, "")


@functools.cache
def number_paths(cls: type[NamedTuple]) -> tuple[Path, ...]:
    """The paths of all numbers of a (nested) NamedTuple class, in their order in memory."""
    found: list[Path] = []
    for member in members_of(cls):
        inner = [()] if member.nested is None else number_paths(member.nested)
        found += [(member.name, *rest) for rest in inner]
    return tuple(found)
