"""Equations within loops that numba compiles: `njit`, had from here, knows every equation of plants and controllers.

The program itself compiles equations otherwise (`workbench.recording`); here they are run as they stand.
"""

import functools
from collections.abc import Callable
from typing import Any

from numba import njit, types
from numba.extending import intrinsic, overload, register_jitable

import controllers.registry  # noqa: F401  # all equations are there
import plants.registry  # noqa: F401
from plants.compiled import INNER
from plants.equation import changed, equations, extended, gathered, select, when

__all__ = ["njit"]

for _equation in equations():
    register_jitable(forceinline=True, **INNER)(_equation)

_inside = functools.partial(overload, jit_options=INNER)


@_inside(select)
def _compiled_select(condition: Any, when_true: Any, when_false: Any) -> Callable[..., Any]:
    def choose(condition: Any, when_true: Any, when_false: Any) -> Any:
        return when_true if condition else when_false

    return choose


@_inside(when)
def _compiled_when(condition: Any, function: Any, otherwise: Any, *arguments: Any) -> Callable[..., Any]:
    def choose(condition: Any, function: Any, otherwise: Any, *arguments: Any) -> Any:
        if condition:
            return function(*arguments)
        return otherwise

    return choose


@_inside(changed, prefer_literal=True)
def _compiled_changed(value: Any, place: Any, new: Any) -> Callable[..., Any]:
    def change(value: Any, place: Any, new: Any) -> Any:
        return _changed(value, place, new)

    return change


@intrinsic(prefer_literal=True)
def _changed(typingctx: Any, value: Any, place: Any, new: Any) -> Any:
    index = place.literal_value

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        given, place = signature.args[2], value.types[index]
        alike = context.get_value_type(given) == context.get_value_type(place)  # a tuple of another class, other units
        member = args[2] if alike else context.cast(builder, args[2], given, place)
        return builder.insert_value(args[0], member, index)

    return value(value, place, new), codegen


@_inside(extended)
def _compiled_extended(cls: Any, value: Any, last: Any) -> Callable[..., Any]:
    def extend(cls: Any, value: Any, last: Any) -> Any:
        return _extended(cls, value, last)

    return extend


@intrinsic
def _extended(typingctx: Any, cls: Any, value: Any, last: Any) -> Any:
    result = types.BaseTuple.from_types([*value.types, last], cls.instance_class)

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        members = [builder.extract_value(args[1], i) for i in range(len(value.types))]
        return context.make_tuple(builder, result, [*members, args[2]])

    return result(cls, value, last), codegen


@_inside(gathered)
def _compiled_gathered(cls: Any, members: Any) -> Callable[..., Any]:
    def gather(cls: Any, members: Any) -> Any:
        return _gathered(cls, members)

    return gather


@intrinsic
def _gathered(typingctx: Any, cls: Any, members: Any) -> Any:
    result = types.BaseTuple.from_types(members.types, cls.instance_class)

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        values = [builder.extract_value(args[1], i) for i in range(len(members.types))]
        return context.make_tuple(builder, result, values)

    return result(cls, members), codegen
