"""An equation is written once and runs in NumPy, in compiled code and in CasADi.

An equation is a plain function of scalars that uses NumPy ufuncs and `select` in place of `if`.
Decorated with `@equation` it

- runs as it stands on floats and NumPy arrays (tests, plots, signals after a run),
- is recorded, and becomes machine code (simulation) or C (export),
- accepts CasADi symbols (exact Jacobians, sensitivities, linearisation).

States, inputs and parameters are NamedTuples of floats, possibly nested, whose fields carry their unit:

    class State(NamedTuple):
        position: Annotated[float, "m", 0.01]      # unit, and for states a typical magnitude

Nothing here imports a compiler: `workbench.recording` is where equations are compiled.
"""

import functools
import hashlib
import inspect
import sys
import typing
from collections import namedtuple
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias, TypeVar, TypeVarTuple
from weakref import WeakSet

import numpy as np

Scalar: TypeAlias = Any
"""A float, a NumPy array of floats, or a CasADi symbol: whatever the caller works in."""

Equation: TypeAlias = Callable[..., Any]
"""A function of scalars and of NamedTuples of them, which NumPy, compiled code and CasADi run alike."""

Function = TypeVar("Function", bound=Equation)

NumbersT = TypeVar("NumbersT", bound=NamedTuple)
"""States, inputs, parameters or gains: floats, and tuples of them."""

Arguments = TypeVarTuple("Arguments")

EQUATION_FOLDERS = (
    "plants",
    "plants/actuators",
    "plants/effects",
    "plants/laws",
    "controllers",
    "workbench/recording",
    "workbench/simulation",
    "workbench/simulation/integrators",
)
"""Folders of the source files that compiled code may be made of."""


@functools.cache
def source_hash(folders: tuple[str, ...] = EQUATION_FOLDERS) -> str:
    """A hash of the program's source files in these folders.

    Numba's cache notices an edit in the file of a compiled function, not in the files that it calls; a cache
    directory named by this hash does.
    """
    root = Path(__file__).parent.parent
    digest = hashlib.sha256(f"{version('numba')} {np.__version__}".encode())
    for folder in folders:
        for path in sorted((root / folder).glob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


_marked: WeakSet[Equation] = WeakSet()


def equation(function: Function) -> Function:
    """Marks a function as an equation: of numbers, arrays and symbols alike."""
    _marked.add(function)
    return function


def equations() -> Iterator[Equation]:
    """All equations of the modules that were imported."""
    return iter(list(_marked))


def unmarked(functions: Iterable[Equation]) -> str:
    """Which of them lacks the mark, and the fix; "" if none does."""
    lacking = (item.__name__ for item in functions if inspect.isfunction(item) and item not in _marked)
    return next((f'function "{name}" is no equation; decorate it with @equation' for name in lacking), "")


def select(condition: Scalar, when_true: Scalar, when_false: Scalar) -> Scalar:
    """`when_true` where `condition` holds, else `when_false`: the `if` of an equation (both are evaluated)."""
    return np.where(condition, when_true, when_false)


def when(
    condition: Scalar, function: Callable[[*Arguments], Scalar], otherwise: Scalar, *arguments: *Arguments
) -> Scalar:
    """`function(*arguments)` where `condition` holds, else `otherwise`: a `select` that compiled code need not pay for.

    For an equation whose result is known without it, such as that of an effect which a plant has not.
    """
    return select(condition, function(*arguments), otherwise)


def changed(value: NumbersT, place: int, new: Scalar | tuple[Scalar, ...]) -> NumbersT:
    """The NamedTuple `value` with another member at a place, a constant: its `_replace` for compiled code too."""
    return value._replace(**{value._fields[place]: new})


def extended(cls: type[NumbersT], value: tuple[Scalar, ...], last: tuple[Scalar, ...]) -> NumbersT:
    """A NamedTuple of class `cls`: the members of another, and one behind them."""
    return cls._make((*value, last))


def gathered(cls: type[NumbersT], members: tuple[Any, ...]) -> NumbersT:
    """A NamedTuple of class `cls`, a constant, of its members: `cls._make` for compiled code too."""
    return cls._make(members)


class Field(NamedTuple):
    """One number of a (nested) NamedTuple: its name, unit, typical magnitude, and default (None: required)."""

    name: str
    unit: str
    scale: float
    default: float | None


@dataclass(frozen=True)
class Called:
    """In an annotation: what users call a number whose name in equations is another."""

    name: str


NEGATIVE = "negative"
"""A nested tuple in a field of this name holds the values for motion in the negative direction; its numbers
are known to users by their plain name with `_negative` behind it."""

ROTARY = "rotary"
"""The same for what acts around the rod: `_rotary`."""


def members(cls: type[NamedTuple]) -> tuple[str, ...]:
    """The fields of a NamedTuple class, nested ones as one each."""
    return cls._fields


@functools.cache
def fields(cls: type[NamedTuple]) -> tuple[Field, ...]:
    """The numbers of a NamedTuple class in their order in memory, nested ones spread out."""
    return tuple(_walk(cls, ""))


def _walk(cls: type[NamedTuple], suffix: str) -> Iterator[Field]:
    hints = typing.get_type_hints(cls, include_extras=True)
    for name in cls._fields:
        hint = hints[name]
        if typing.get_origin(hint) is typing.Annotated:
            unit, *others = hint.__metadata__
            scale = next((item for item in others if isinstance(item, float)), 1.0)
            called = next((item.name for item in others if isinstance(item, Called)), name)
            yield Field(called + suffix, unit, scale, cls._field_defaults.get(name))
        else:
            yield from _walk(hint, suffix + (f"_{name}" if name in (NEGATIVE, ROTARY) else ""))


_named_tuple: Any = namedtuple  # its names come from data here, which the type checker does not follow


def named_tuple(
    name: str,
    module: str,
    members: Mapping[str, type],
    defaults: Mapping[str, float | tuple[Scalar, ...]],
    doc: str | None,
) -> type:
    """A NamedTuple class with these members and their types, made once.

    It is an attribute of the module of that name, by which the cache of compiled code knows it.
    """
    place = sys.modules[module]
    if not hasattr(place, name):
        made = _named_tuple(name, members, defaults=tuple(defaults.values()), module=module)
        made.__annotations__ = dict(members)
        made.__doc__ = doc
        setattr(place, name, made)
    return getattr(place, name)


def retyped(template: type[NamedTuple], suffix: str, **nested: type) -> type:
    """The NamedTuple class `template` with other classes in its nested fields, or further ones behind its own.

    It is an attribute of the template's module, called TEMPLATE_SUFFIX. A further field has its class without arguments
    as default.
    """
    hints = typing.get_type_hints(template, include_extras=True)
    further = {name: cls for name, cls in nested.items() if name not in hints}
    defaults = {**template._field_defaults, **{name: cls() for name, cls in further.items()}}
    name = f"{template.__name__}_{suffix}"
    return named_tuple(name, template.__module__, {**hints, **nested}, defaults, template.__doc__)


def to_array(value: tuple[Scalar, ...]) -> np.ndarray:
    """A (nested) NamedTuple of floats as one vector, in the order of `fields`."""
    return np.array(_numbers(type(value))(value), dtype=float)


@functools.cache
def _numbers(cls: type[NamedTuple]) -> Callable[[tuple[Scalar, ...]], Iterable[Scalar]]:
    """What takes all numbers out of a (nested) NamedTuple, at once: one at a time is several times slower."""
    paths = list(_paths(cls))
    if len(paths) < 2 or None in paths:  # the getter of one gives no tuple
        return _flat
    return attrgetter(*(path for path in paths if path is not None))


def _paths(cls: type[NamedTuple], before: str = "") -> Iterator[str | None]:
    """Where the numbers of a (nested) NamedTuple are, as names behind names; None of what may be a tuple or none."""
    for name, inner in zip(cls._fields, _nested(cls), strict=True):
        if inner is None:
            yield before + name
        elif hasattr(inner, "_fields"):
            yield from _paths(inner, f"{before}{name}.")
        else:
            yield None


def replaced(value: NumbersT, numbers: Mapping[str, float]) -> NumbersT:
    """A (nested) NamedTuple with other values of some of its numbers, by their names in `fields`."""
    cls = type(value)
    names = [item.name for item in fields(cls)]
    return from_array(cls, [numbers.get(name, old) for name, old in zip(names, leaves(value), strict=True)])


def named(value: tuple[Scalar, ...]) -> dict[str, Scalar]:
    """The numbers, arrays or symbols of a (nested) NamedTuple by their names in `fields`."""
    return dict(zip((item.name for item in fields(type(value))), _flat(value), strict=True))


def leaves(value: Scalar | tuple[Scalar, ...]) -> Iterator[Scalar]:
    """The numbers, arrays or symbols of a (nested) NamedTuple, in the order of `fields`."""
    return iter(_flat(value) if isinstance(value, tuple) else [value])


def _flat(value: tuple[Scalar, ...]) -> list[Scalar]:
    numbers: list[Scalar] = []
    for item in value:
        if isinstance(item, tuple):
            numbers += _flat(item)
        else:
            numbers.append(item)
    return numbers


def from_array(cls: type[NumbersT], values: Iterable[Scalar]) -> NumbersT:
    """The inverse of `to_array`; a value may be a float, an array over time or a CasADi symbol."""
    return _build(cls, iter(values))


@functools.cache
def _nested(cls: type[NamedTuple]) -> tuple[type[NamedTuple] | None, ...]:
    """The class of each field that is a NamedTuple of its own; None of a number."""
    hints = typing.get_type_hints(cls)
    return tuple(None if hints[name] is float else hints[name] for name in cls._fields)


@functools.cache
def size_of(cls: type[NamedTuple]) -> int:
    """How many numbers a (nested) NamedTuple class holds."""
    return sum(1 if inner is None else size_of(inner) for inner in _nested(cls))


def _build(cls: type[NumbersT], values: Iterator[Scalar]) -> NumbersT:
    return cls._make([next(values) if inner is None else _build(inner, values) for inner in _nested(cls)])


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
