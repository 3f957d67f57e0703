"""What may stand under a key, in words: from the type and the limits that pydantic checks."""

import functools
import types
import typing
from collections.abc import Iterator
from typing import Any, Literal, Union

from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from workbench.toml.quantities import AxisNumber, rpm_si
from workbench.toml.units import si

WORDS: dict[object, str] = {
    float: "number",
    int: "whole number",
    str: "text",
    bool: "`true` or `false`",
    Any: "any",
    dict: "table",
}


def kind_of(field: FieldInfo) -> str:
    """What may stand there, with unit and limits."""
    return _kind(field.annotation, tuple(field.metadata))


def models_in(annotation: object) -> Iterator[type[BaseModel]]:
    """The schemas that an annotation holds."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in typing.get_args(annotation):
        yield from models_in(inner)


def _kind(annotation: object, metadata: tuple[object, ...] = ()) -> str:
    if typing.get_origin(annotation) is typing.Annotated:
        inner, *more = typing.get_args(annotation)
        return _kind(inner, (*more, *metadata))
    limits = " and ".join(word for word in map(_limit, metadata) if word)
    unit = next((word for word in map(_unit, metadata) if word), "")
    return f"{unit or _plain(annotation)}{', ' if limits else ''}{limits}"


def _plain(annotation: object) -> str:
    origin, arguments = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is Literal:
        return " ".join(f'`"{item}"`' for item in arguments if item)
    if origin in (Union, types.UnionType):
        kinds = dict.fromkeys(_kind(item) for item in arguments if item is not type(None))
        return "quantity" if tuple(kinds) == ("number", "text") else " or ".join(kinds)
    if origin is list:
        return f"list: {_kind(arguments[0])}"
    if origin is tuple:
        return ", ".join(map(_kind, arguments))
    if origin is dict:
        return "table" if arguments[1] is Any else f"by name: {_kind(arguments[1])}"
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return "table"
    return WORDS.get(annotation, getattr(annotation, "__name__", str(annotation)))


def _unit(validator: object) -> str:
    """The unit of a quantity, from what reads it."""
    function = getattr(validator, "func", None)
    if function is rpm_si:
        return "rpm"
    bound = function.func if isinstance(function, functools.partial) else function
    keywords = function.keywords if isinstance(function, functools.partial) else {}
    if bound is si:
        return f"quantity, {keywords['unit']}"
    if getattr(bound, "__func__", None) is getattr(AxisNumber.read, "__func__", bound):
        return f"quantity, m{keywords.get('per', '')} or rad{keywords.get('per', '')}"
    return ""


def _number(value: Any) -> str:
    return f"{value:g}"


def _limit(limit: object) -> str:
    if isinstance(limit, Ge):
        return f"at least {_number(limit.ge)}"
    if isinstance(limit, Gt):
        return f"above {_number(limit.gt)}"
    if isinstance(limit, Le):
        return f"at most {_number(limit.le)}"
    if isinstance(limit, Lt):
        return f"below {_number(limit.lt)}"
    if isinstance(limit, MinLen):
        return f"{limit.min_length} or more"
    if isinstance(limit, MaxLen):
        return f"{limit.max_length} at most"
    return ""
