"""The tables of a case: a study's at one point of its axes, its controllers with what their gain files say."""

import functools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from workbench.errors import UserError
from workbench.study.layers import LAYERS, MACHINE
from workbench.study.study import Study, axes_key, rpm_of
from workbench.toml.gain_file import KEY, read_gain_file, with_gains
from workbench.toml.units import QuantityError


def merged(base: Mapping[str, object], overrides: Mapping[str, object]) -> dict[str, Any]:
    """`base` with `overrides` laid over it, table by table; lists and values are replaced.

    Neither is changed, and the tables of one of them alone are shared with the result: a study has many cases.
    """
    result = dict(base)
    for key, value in overrides.items():
        below = result.get(key)
        if isinstance(value, Mapping) and isinstance(below, Mapping):
            value = merged(below, value)
        result[key] = value
    return result


def at_point(
    study: Study,
    case: str | None,
    tables: Mapping[str, Any],
    point: Mapping[str, Any],
    gains: "Gains",
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The tables of a case at one point of its axes, and the plant that is declared there."""
    result = dict(tables)
    declared = result["plant"]
    for axis, layer in LAYERS.items():
        if axis in point:
            result = merged(result, getattr(study.file, layer.section)[point[axis]])
        if layer is MACHINE:
            declared = result["plant"]
    for axis, value in point.items():
        if axis in ("rpm", "controller", "reference"):
            result[axis] = value
        elif axis not in LAYERS:
            *parents, last = axis.split(".")
            table = result
            for part in parents:
                below = table.get(part, {})
                if not isinstance(below, dict):
                    raise study.error((*axes_key(study, case), axis), f'"{part}" is not a table')
                table[part] = dict(below)  # what is shared with other cases stays as it is
                table = table[part]
            table[last] = value
    result["controllers"] = _with_gains(study, case, result, point.get(MACHINE.axis), gains)
    return result, declared


def _with_gains(
    study: Study, case: str | None, tables: Mapping[str, Any], machine: str | None, gains: "Gains"
) -> dict[str, object]:
    """Controllers with what their gain files say for a case's speed and machine.

    Of controllers beside the case's own a file that has nothing for this speed is left: they have cases of their own.
    """
    controllers = tables["controllers"]
    found: dict[str, object] = dict(controllers)
    own = tables.get("controller") or next(iter(controllers), None)
    filed = {name: table for name, table in controllers.items() if isinstance(table, dict) and KEY in table}
    if not filed:
        return found  # what is no table is told when the case is resolved
    try:
        rpm = rpm_of(tables)
    except QuantityError as error:
        raise study.error((*axes_key(study, case), "rpm"), str(error)) from None
    for name, table in filed.items():
        filled = gains(name, table, study.path.parent, rpm, machine)
        if not isinstance(filled, UserError):
            found[name] = filled
        elif name == own:
            raise study.error(("controllers", name, KEY), str(filled))
    return found


class Gains:
    """Controllers with what their gain files say, or why these say nothing; each file is read once."""

    def __init__(self) -> None:
        self._read = functools.cache(read_gain_file)
        self._known: dict[object, tuple[object, dict[str, object] | UserError]] = {}

    def __call__(
        self, name: str, table: dict[str, Any], folder: Path, rpm: float, machine: str | None
    ) -> dict[str, object] | UserError:
        """The table of the controller of this name, filled; cases share the tables that no axis changes."""
        of, filled = self._known.get((name, rpm, machine), (None, {}))
        if of is not table:
            try:
                filled = with_gains(table, folder, rpm, machine, self._read)
            except UserError as error:
                filled = error
            self._known[name, rpm, machine] = table, filled
        return filled
