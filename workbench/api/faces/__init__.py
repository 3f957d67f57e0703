"""Results of the questions as a notebook shows them: the objects that the rooms make, each with its face."""

from collections.abc import Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T", bound="DataclassInstance")


def told(title: str, lines: Sequence[str]) -> str:
    """A result as a terminal shows it: what was found, in words."""
    return "\n".join([title, *lines])


def shown_as(kind: type[T], result: "DataclassInstance") -> T:
    """`result` as the subclass `kind` of its class, which only adds a face."""
    return kind(**{item.name: getattr(result, item.name) for item in fields(result)})
