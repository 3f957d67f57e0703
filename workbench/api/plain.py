"""What a caller gives, as the plain data of a TOML file."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import UnionType
from typing import Protocol, runtime_checkable

import numpy as np

from workbench.errors import UserError

Quantity = float | str
"""A number in SI, or text with a unit: 0.03 or "30 mm"."""

Plain = str | float | int | bool | list["Plain"] | dict[str, "Plain"]
"""What a TOML file holds."""


@runtime_checkable
class HasTable(Protocol):
    """What stands for a table of a study: a controller, a reference."""

    @property
    def table(self) -> Mapping[str, object]:
        """The table."""


def expect(value: object, kind: type | UnionType, name: str, expected: str) -> None:
    """Raise UserError where an argument is not of the kind that a function takes.

    Args:
        value: the argument.
        kind: what it has to be.
        name: of the function and, where it takes several, of the argument.
        expected: what it has to be in words, and how one is made.
    """
    if isinstance(value, kind):
        return
    shown = f"the class {value.__name__}" if isinstance(value, type) else f"a {type(value).__name__}"
    if value is None or isinstance(value, str | int | float):
        shown = f'"{value}"' if isinstance(value, str) else str(value)
    raise UserError(f"{name}: got {shown}, expected {expected}")


def plain(value: object, name: str) -> Plain:
    """`value` as plain data; keys without a value (None) are left out.

    Raises:
        UserError: something in it that no study file can hold; `name` says where.
    """
    if isinstance(value, HasTable):
        return plain(value.table, name)
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(item, f"{name}.{key}") for key, item in value.items() if item is not None}
    if isinstance(value, Sequence):
        return [plain(item, f"{name}[{i}]") for i, item in enumerate(value)]
    raise UserError(
        f"{name}: got a {type(value).__name__}, expected a number, text, a list or a dictionary of these, a controller "
        "such as wb.pid(kp=500), or a reference such as wb.sine(0.03, 0.9)"
    )


def plain_table(value: Mapping[str, object], name: str) -> dict[str, Plain]:
    """A dictionary as plain data; see `plain`."""
    table = plain(value, name)
    if not isinstance(table, dict):
        raise UserError(f"{name}: got {value!r}, expected a dictionary")
    return table
