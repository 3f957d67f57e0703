"""The cases of a study: its [cases], times the product of its axes."""

import functools
import itertools
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from workbench.errors import UserError, nearest
from workbench.study.layers import LAYERS, MACHINE
from workbench.study.schema import OVERRIDES
from workbench.study.study import (
    NAMED_AXES,
    Case,
    Study,
    axes_key,
    rpm_of,
)
from workbench.toml.gain_file import KEY, GainFile, read_gain_file, with_gains


def unfold(study: Study) -> list[Case]:
    """All cases, in order: [cases] first, then the axes as they stand, the last one changing fastest.

    Raises:
        UserError: an axis that is empty, unknown, or names something that the file does not hold.
    """
    file = study.file
    base = {name: getattr(file, name) for name in OVERRIDES}
    cases: list[Case] = []
    read = functools.cache(read_gain_file)
    named: list[tuple[str | None, dict[str, Any]]] = [*file.cases.items()] or [(None, {})]
    for name, overrides in named:
        tables = merged(base, {key: value for key, value in overrides.items() if key != "axes"})
        given = overrides.get("axes", tables.pop("axes"))
        tables.pop("axes", None)
        axes = _checked_axes(study, name, given, tables)
        for values in itertools.product(*axes.values()):
            point = dict(zip(axes, values, strict=True))
            filled, declared = _at_point(study, name, tables, point, read)
            cases.append(Case(len(cases), name, point, filled, declared, study.path.parent))
    return cases


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


def _checked_axes(study: Study, case: str | None, axes: object, tables: Mapping[str, Any]) -> dict[str, list[object]]:
    """The axes, each a list of values that there are."""
    place = axes_key(study, case)
    if not isinstance(axes, dict):
        raise study.error(place, "expected a table of lists")
    for axis, values in axes.items():
        key = (*place, axis)
        if not isinstance(values, list):
            raise study.error(key, f"got {values!r}, expected a list")
        if not values:
            raise study.error(key, "is empty: expected at least one value (or leave the axis out)")
        if len({json.dumps(value, sort_keys=True) for value in values}) < len(values):
            raise study.error(key, "holds a value twice")
        known = {
            "controller": tables["controllers"],
            "reference": tables["references"],
            **{
                layer.axis: {**getattr(study.file, layer.section), **layer.files(study.path.parent)}
                for layer in LAYERS.values()
            },
        }
        if axis in known:
            for value in values:
                if not isinstance(value, str) or value not in known[axis]:
                    where = ""
                    if axis in LAYERS:
                        folder = study.path.parent / LAYERS[axis].section
                        where = f" (looked in this file, {folder} and the program's own)"
                    raise study.error(key, f'unknown {axis} "{value}"; {nearest(str(value), known[axis])}{where}')
        elif axis not in NAMED_AXES and axis.split(".")[0] not in OVERRIDES:
            roots = [*NAMED_AXES, *(f"{name}. ..." for name in OVERRIDES if name != "axes")]
            raise study.error(key, f"unknown axis; {nearest(axis, roots)} (or a dotted key of the file)")
        elif (section := axis.split(".")[0]) in ("controllers", "references"):
            name = axis.partition(".")[2].split(".")[0]
            if name not in tables[section]:
                raise study.error(key, f'unknown {section[:-1]} "{name}"; {nearest(name, tables[section])}')
    return axes


def _at_point(
    study: Study,
    case: str | None,
    tables: Mapping[str, Any],
    point: Mapping[str, Any],
    read: Callable[[Path], GainFile],
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
    result["controllers"] = _with_gains(study, result, point.get(MACHINE.axis), read)
    return result, declared


def _with_gains(
    study: Study, tables: Mapping[str, Any], machine: str | None, read: Callable[[Path], GainFile]
) -> dict[str, object]:
    """Controllers with what their gain files say for a case's speed and machine.

    Of controllers beside the case's own a file that has nothing for this speed is left: they have cases of their own.
    """
    controllers = tables["controllers"]
    found: dict[str, object] = dict(controllers)
    own = tables.get("controller") or next(iter(controllers), None)
    for name, table in controllers.items():
        if not isinstance(table, dict) or KEY not in table:
            continue  # what is no table is told when the case is resolved
        try:
            found[name] = with_gains(table, study.path.parent, rpm_of(tables), machine, read)
        except UserError as error:
            if name == own:
                raise study.error(("controllers", name, KEY), str(error)) from None
    return found
