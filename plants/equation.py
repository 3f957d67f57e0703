"""An equation is written once and runs in NumPy, in compiled code and in CasADi.

An equation is a plain function of scalars that uses NumPy ufuncs and `select` in place of `if`.
Decorated with `@equation` it

- runs as it stands on floats and NumPy arrays (tests, plots, signals after a run),
- is compiled when compiled code calls it (simulation),
- accepts CasADi symbols (exact Jacobians, sensitivities, linearisation).

States, inputs and parameters are NamedTuples of floats, possibly nested, whose fields carry their unit:

    class State(NamedTuple):
        position: Annotated[float, "m", 0.01]      # unit, and for states a typical magnitude

The simulation engine knows only C functions over pointers to doubles; `entry_point` makes one out of an
equation. All of an engine's plants and controllers have the same C signatures, so that the engine is compiled
once and they plug in.
"""

import functools
import hashlib
import inspect
import operator
import os
import secrets
import sys
import typing
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core.bytecode import FunctionIdentity
from numba.extending import intrinsic, overload, register_jitable

Scalar: TypeAlias = Any
"""A float, a NumPy array of floats, or a CasADi symbol: whatever the caller works in."""


EQUATION_FOLDERS = ("plants", "controllers", "workbench/simulation")
"""Folders of the source files that compiled code may be made of."""


@functools.cache
def source_hash(folders: tuple[str, ...] = EQUATION_FOLDERS) -> str:
    """A hash of the program's source files in these folders.

    Numba's cache notices an edit in the file of a compiled function, not in the files that it calls; a cache
    directory named by this hash does.
    """
    root = Path(__file__).parent.parent
    digest = hashlib.sha256(f"{numba.__version__} {np.__version__}".encode())
    for folder in folders:
        for path in sorted((root / folder).glob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _cache_folder() -> Path:
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "friction-workbench" / "compiled" / source_hash()


if not os.environ.get("NUMBA_CACHE_DIR"):
    numba.config.CACHE_DIR = str(_cache_folder())

FunctionIdentity._unique_ids = iter(functools.partial(secrets.randbits, 64), None)
# Numba numbers functions from 1 on in each process, and the numbers are all that tells the symbols of closures of the
# same name apart: of two that two processes have cached, a third would run one for both (numba issue 10486).

equation = register_jitable
"""Marks a function as an equation: callable from Python with anything, and from compiled code."""


def select(condition: Scalar, when_true: Scalar, when_false: Scalar) -> Scalar:
    """`when_true` where `condition` holds, else `when_false`: the `if` of an equation (both are evaluated)."""
    return np.where(condition, when_true, when_false)


@overload(select)
def _compiled_select(condition: Any, when_true: Any, when_false: Any) -> Callable[..., Any]:
    def choose(condition: Any, when_true: Any, when_false: Any) -> Any:
        return when_true if condition else when_false

    return choose


def when(condition: Scalar, function: Callable[..., Scalar], otherwise: Scalar, *arguments: Any) -> Scalar:
    """`function(*arguments)` where `condition` holds, else `otherwise`: a `select` that compiled code need not pay for.

    For an equation whose result is known without it, such as that of an effect which a plant has not.
    """
    return select(condition, function(*arguments), otherwise)


@overload(when)
def _compiled_when(condition: Any, function: Any, otherwise: Any, *arguments: Any) -> Callable[..., Any]:
    def choose(condition: Any, function: Any, otherwise: Any, *arguments: Any) -> Any:
        if condition:
            return function(*arguments)
        return otherwise

    return choose


class Field(NamedTuple):
    """One number of a (nested) NamedTuple: its name, unit, typical magnitude, and default (None: required)."""

    name: str
    unit: str
    scale: float
    default: float | None


NEGATIVE = "negative"
"""A nested tuple in a field of this name holds the values for motion in the negative direction; its numbers
are known to users by their plain name with `_negative` behind it."""

ROTARY = "rotary"
"""The same for what acts around the rod: `_rotary`."""


@functools.cache
def fields(cls: Any) -> tuple[Field, ...]:
    """The numbers of a NamedTuple class in their order in memory, nested ones spread out."""
    return tuple(_walk(cls, ""))


def _walk(cls: Any, suffix: str) -> Iterator[Field]:
    hints = typing.get_type_hints(cls, include_extras=True)
    for name in cls._fields:
        hint = hints[name]
        if typing.get_origin(hint) is typing.Annotated:
            unit, *scale = hint.__metadata__
            default = cls._field_defaults.get(name)
            yield Field(name + suffix, unit, scale[0] if scale else 1.0, default)
        else:
            yield from _walk(hint, suffix + (f"_{name}" if name in (NEGATIVE, ROTARY) else ""))


def to_array(value: Any) -> np.ndarray:
    """A (nested) NamedTuple of floats as one vector, in the order of `fields`."""
    return np.array(list(leaves(value)), dtype=float)


def leaves(value: Any) -> Iterator[Any]:
    """The numbers, arrays or symbols of a (nested) NamedTuple, in the order of `fields`."""
    if isinstance(value, tuple):
        for item in value:
            yield from leaves(item)
    else:
        yield value


def from_array(cls: Any, values: Any) -> Any:
    """The inverse of `to_array`; a value may be a float, an array over time or a CasADi symbol."""
    return _build(cls, iter(values))


@functools.cache
def _plain_hints(cls: Any) -> dict[str, Any]:
    return typing.get_type_hints(cls)


def _build(cls: Any, values: Iterator[Any]) -> Any:
    hints = _plain_hints(cls)
    return cls(*(next(values) if hints[n] is float else _build(hints[n], values) for n in cls._fields))


# --- compiled code -------------------------------------------------------------------------------------------

POINTER = types.CPointer(types.float64)


def _numba_type(cls: Any) -> Any:
    hints = typing.get_type_hints(cls)
    members = [types.float64 if hints[n] is float else _numba_type(hints[n]) for n in cls._fields]
    return (
        types.NamedUniTuple(types.float64, len(members), cls)
        if all(member == types.float64 for member in members)
        else types.NamedTuple(members, cls)
    )


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


def caller(signature: Any) -> Any:
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


@overload(operator.getitem)
def _pointer_item(pointer: Any, index: Any) -> Any:
    """In compiled code a pointer is read like an array. Arrays themselves cost a reference count at each call."""
    if pointer == POINTER and isinstance(index, types.Integer):
        return lambda pointer, index: _load(pointer, index)
    return None


@overload(operator.setitem)
def _set_pointer_item(pointer: Any, index: Any, value: Any) -> Any:
    if pointer == POINTER and isinstance(index, types.Integer):
        return lambda pointer, index, value: _store(pointer, index, value)
    return None


def fingerprint(function: Callable[..., Any]) -> str:
    """A hash of the source of the package that `function` is from: a plug-in's lies outside the cache's key."""
    return package_hash(inspect.unwrap(function).__module__)


def package_hash(module: str) -> str:
    """A hash of the source files of the package that holds `module`, or of the module where that is all there is."""
    top = sys.modules[module.partition(".")[0]]
    files = [path for folder in getattr(top, "__path__", ()) for path in sorted(Path(folder).rglob("*.py"))]
    if not files and top.__file__:
        files = [Path(top.__file__)]
    digest = hashlib.sha256()
    for path in files:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def compiled(signature: Any) -> Callable[[Callable[..., Any]], Any]:
    """Decorator: a C function of `signature`, cached on disk; dividing by zero gives infinity, as in NumPy."""
    return numba.cfunc(signature, cache=True, error_model="numpy")
