"""What compiled loops are made with: pointers to doubles, and calls of C functions at an address.

Loops over samples are compiled by numba, once, and cached on disk: they know equations only as C functions
(`workbench.recording.machine_code`), all plants' and all controllers' of the same signatures. This module imports
numba, which takes as long as all else that a command needs: what only names plants, or checks a file, does without it.
"""

import functools
import operator
import os
from typing import Any

import numba
from llvmlite import ir
from numba import types
from numba.core.typing import Signature
from numba.extending import intrinsic, overload

from plants.cache import cache_folder
from plants.equation import source_hash

if not os.environ.get("NUMBA_CACHE_DIR"):
    numba.config.CACHE_DIR = str(cache_folder() / "compiled" / source_hash())

INNER = {"no_cfunc_wrapper": True, "no_cpython_wrapper": True}
"""Options of a function that compiled code alone calls: nothing else needs a way in, which would double its cost."""

_inside = functools.partial(overload, jit_options=INNER)

POINTER = types.CPointer(types.float64)


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


njit = numba.njit
"""For loops over arrays. Had from here, it finds the folder of the cache set."""

inner = functools.partial(numba.njit, cache=True, nogil=True, **INNER)
"""Of a function that such loops alone call."""


@inner()
def copy(of: Any, to: Any) -> None:
    """The numbers of an array, into another one: an assignment to a slice takes seconds to compile, for its errors."""
    for i in range(to.size):
        to[i] = of[i]
