"""Equations as compiled code: C functions over pointers to doubles, cached on disk.

The simulation engine knows only such functions. All plants and controllers have the same C signatures, so that the
engine is compiled once and they plug in. This module imports numba, which takes as long as all else that a command
needs: what only names plants, or checks a file, does without it.
"""

import functools
import operator
import os
import secrets
import typing
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numba
from llvmlite import ir
from numba import types
from numba.core.bytecode import FunctionIdentity
from numba.core.typing import Signature
from numba.extending import intrinsic, overload, register_jitable

from plants.cache import cache_folder
from plants.equation import Equation, changed, extended, gathered, select, source_hash, tell_compiler, when

if not os.environ.get("NUMBA_CACHE_DIR"):
    numba.config.CACHE_DIR = str(cache_folder() / "compiled" / source_hash())

FunctionIdentity._unique_ids = iter(functools.partial(secrets.randbits, 64), None)
# Numba numbers functions from 1 on in each process, and the numbers are all that tells the symbols of closures of the
# same name apart: of two that two processes have cached, a third would run one for both (numba issue 10486).

INNER = {"no_cfunc_wrapper": True, "no_cpython_wrapper": True}
"""Options of a function that compiled code alone calls: nothing else needs a way in, which would double its cost."""

tell_compiler(register_jitable(forceinline=True, **INNER))
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


POINTER = types.CPointer(types.float64)


def _numba_type(cls: type[NamedTuple]) -> types.BaseTuple:
    hints = typing.get_type_hints(cls)
    members = [types.float64 if hints[n] is float else _numba_type(hints[n]) for n in cls._fields]
    return types.BaseTuple.from_types(members, cls)


@intrinsic
def unpack(typingctx: Any, cls: Any, pointer: Any) -> Any:
    """In compiled code: read a (nested) NamedTuple of class `cls` from consecutive doubles at `pointer`."""
    result = _numba_type(cls.instance_class)

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        position = iter(range(10_000))

        def load(kind: Any) -> Any:
            if isinstance(kind, types.Float):
                index = context.get_constant(types.intp, next(position))
                return builder.load(builder.gep(args[1], [index]))
            return context.make_tuple(builder, kind, [load(member) for member in kind.types])

        return load(result)

    return result(cls, pointer), codegen


@intrinsic
def pack(typingctx: Any, value: Any, pointer: Any) -> Any:
    """In compiled code: write the numbers of a (nested) tuple to consecutive doubles at `pointer`."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        position = iter(range(10_000))

        def store(kind: Any, item: Any) -> None:
            if isinstance(kind, types.BaseTuple):
                for i, member in enumerate(kind.types):
                    store(member, builder.extract_value(item, i))
            else:
                index = context.get_constant(types.intp, next(position))
                number = context.cast(builder, item, kind, types.float64)
                builder.store(number, builder.gep(args[1], [index]))

        store(signature.args[0], args[0])
        return context.get_dummy_value()

    return types.void(value, pointer), codegen


@intrinsic
def address(typingctx: Any, array: Any) -> Any:
    """In compiled code: the pointer to the first element of a contiguous float64 array."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return context.make_array(signature.args[0])(context, builder, args[0]).data

    return POINTER(array), codegen


@intrinsic
def shift(typingctx: Any, pointer: Any, count: Any) -> Any:
    """In compiled code: the pointer `count` doubles further on."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.gep(args[0], [args[1]])

    return POINTER(POINTER, types.intp), codegen


@intrinsic
def _load(typingctx: Any, pointer: Any, index: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.load(builder.gep(args[0], [args[1]]))

    return types.float64(POINTER, types.intp), codegen


@intrinsic
def _store(typingctx: Any, pointer: Any, index: Any, value: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        builder.store(args[2], builder.gep(args[0], [args[1]]))
        return context.get_dummy_value()

    return types.void(POINTER, types.intp, types.float64), codegen


@intrinsic
def flagged(typingctx: Any, address: Any) -> Any:
    """In compiled code: whether the 64-bit integer at an address is other than 0, read anew each time: another thread
    may set it.
    """

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        flag = builder.inttoptr(args[0], ir.IntType(64).as_pointer())
        return builder.icmp_unsigned("!=", builder.load_atomic(flag, "monotonic", 8), ir.Constant(ir.IntType(64), 0))

    return types.boolean(types.int64), codegen


def caller(signature: Signature) -> Any:
    """An intrinsic `call(address, *arguments)`: in compiled code, call the C function of `signature` at an address.

    Addresses are plain integers, so that an engine takes them at no cost.
    """

    @intrinsic
    def call(typingctx: Any, address: Any, *arguments: Any) -> Any:
        def codegen(context: Any, builder: Any, _: Any, args: Any) -> Any:
            kinds = [context.get_value_type(kind) for kind in signature.args]
            result = ir.VoidType() if signature.return_type == types.void else ir.DoubleType()
            function = builder.inttoptr(args[0], ir.FunctionType(result, kinds).as_pointer())
            values = [builder.extract_value(args[1], i) for i in range(len(kinds))]
            returned = builder.call(function, values)
            return context.get_dummy_value() if signature.return_type == types.void else returned

        return signature.return_type(types.int64, types.Tuple(signature.args)), codegen

    return call


@_inside(operator.getitem)
def _pointer_item(pointer: Any, index: Any) -> Any:
    """In compiled code a pointer is read like an array. Arrays themselves cost a reference count at each call."""
    if pointer == POINTER and isinstance(index, types.Integer):
        return lambda pointer, index: _load(pointer, index)
    return None


@_inside(operator.setitem)
def _set_pointer_item(pointer: Any, index: Any, value: Any) -> Any:
    if pointer == POINTER and isinstance(index, types.Integer):
        return lambda pointer, index, value: _store(pointer, index, value)
    return None


class CFunction(Protocol):
    """Compiled code, which lives as long as this object does."""

    @property
    def address(self) -> int:
        """Where it stands."""


def compiled(signature: Signature) -> Callable[[Equation], CFunction]:
    """Decorator: a C function of `signature`, cached on disk; dividing by zero gives infinity, as in NumPy."""
    return numba.cfunc(signature, cache=True, error_model="numpy")


njit = numba.njit
"""For loops over arrays. Had from here, it finds the folder of the cache set."""
