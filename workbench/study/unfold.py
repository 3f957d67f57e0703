"""The cases of a study: its [cases], times the product of its axes, on each machine that it draws."""

import json
from collections.abc import Mapping
from typing import Any

from workbench.errors import nearest, shortened, spelled
from workbench.study.at_point import merged
from workbench.study.cases import Block, Cases
from workbench.study.layers import LAYERS
from workbench.study.schema import OVERRIDES
from workbench.study.study import NAMED_AXES, Study, axes_key

MOST_CASES = 4_000_000
"""Of a study, draws included: some gigabytes of results."""

FEWER = "leave an axis out, or values of it"


def unfold(study: Study) -> Cases:
    """All cases of a study as it declares its machine, in order.

    Raises:
        UserError: an axis that is empty, unknown, or names something that the file does not hold; what is no table
            where a case, a machine or a scenario is to change one.
    """
    file = study.file
    for section in ("cases", *(layer.section for layer in LAYERS.values())):
        _check_tables(study, section)
    base = {name: getattr(file, name) for name in OVERRIDES}
    named: list[tuple[str | None, dict[str, Any]]] = [*file.cases.items()] or [(None, {})]
    blocks = []
    for name, overrides in named:
        tables = merged(base, {key: value for key, value in overrides.items() if key != "axes"})
        given = overrides.get("axes", tables.pop("axes"))
        tables.pop("axes", None)
        axes = _checked_axes(study, name, given, tables)
        blocks.append(Block(name, tables, axes))
        if (count := sum(block.size for block in blocks)) > MOST_CASES:
            raise study.error(axes_key(study, name), f"make {count} cases, expected at most {MOST_CASES}: {FEWER}")
    return Cases(study, blocks)


def _check_tables(study: Study, section: str) -> None:
    """That what is laid over a study's tables is tables: others look into them before all are checked."""
    for name, overrides in getattr(study.file, section).items():
        for key in OVERRIDES:
            if not isinstance(overrides.get(key, {}), dict):
                raise study.error((section, name, key), f"got {spelled(overrides[key])}, expected a table")


def _key(value: object) -> object:
    """What is equal where two values of an axis are: text itself, as there may be very much of it, all else as JSON."""
    return value if isinstance(value, str) else (json.dumps(value, sort_keys=True, default=str),)


def _checked_axes(study: Study, case: str | None, axes: object, tables: Mapping[str, Any]) -> dict[str, list[object]]:
    """The axes, each a list of values that there are."""
    place = axes_key(study, case)
    if not isinstance(axes, dict):
        raise study.error(place, "expected a table of lists")
    for axis, values in axes.items():
        key = (*place, axis)
        if not isinstance(values, list):
            raise study.error(key, f"got {spelled(values)}, expected a list")
        if not values:
            raise study.error(key, "is empty: expected at least one value (or leave the axis out)")
        if len({_key(value) for value in values}) < len(values):
            raise study.error(key, "holds a value twice")
        known = _known(study, axis, tables)
        if known is not None:
            for value in values:
                if not isinstance(value, str) or value not in known:
                    where = ""
                    if axis in LAYERS:
                        folder = study.path.parent / LAYERS[axis].section
                        where = f" (looked in this file, {folder} and the program's own)"
                    raise study.error(
                        key, f'unknown {axis} "{shortened(str(value))}"; {nearest(str(value), known)}{where}'
                    )
        elif axis not in NAMED_AXES and axis.split(".")[0] not in OVERRIDES:
            roots = [*NAMED_AXES, *(f"{name}. ..." for name in OVERRIDES if name != "axes")]
            raise study.error(key, f"unknown axis; {nearest(axis, roots)} (or a dotted key of the file)")
        elif (section := axis.split(".")[0]) in ("controllers", "references"):
            name = axis.partition(".")[2].split(".")[0]
            if name not in tables[section]:
                raise study.error(key, f'unknown {section[:-1]} "{name}"; {nearest(name, tables[section])}')
    return axes


def _known(study: Study, axis: str, tables: Mapping[str, Any]) -> Mapping[str, object] | None:
    """What an axis names by name; None where its values are no names."""
    if axis in LAYERS:
        layer = LAYERS[axis]
        return {**getattr(study.file, layer.section), **layer.files(study.path.parent)}
    return tables[f"{axis}s"] if axis in ("controller", "reference") else None
