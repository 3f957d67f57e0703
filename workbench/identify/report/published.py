"""The printed tables of friction beside what the thesis's method finds in the records."""

from collections.abc import Mapping

import pandas as pd

from plants.axis import unit_along
from workbench.identify.thesis.method import Estimate, doubt
from workbench.identify.thesis.records import ThesisFit
from workbench.parameters.sets import known_units
from workbench.publish.along import SHOWN as ALONG
from workbench.publish.tables import shown_number
from workbench.records.schema import PUBLISHED, STATIC, SUFFIXES, PublishedTable
from workbench.toml.units import factor

SHOWN = {unit: shown for along in ALONG.values() for unit, shown in along.units.items()} | {"Pa": "kPa"}
"""Units that tables show in the place of SI ones."""

DIGITS = 3
FOUND, PRINTED = "this program", "published"


def unit_shown(name: str, axis: str) -> str:
    """The unit in which a friction parameter is shown."""
    unit = unit_along("N", axis) if name.startswith(STATIC) else known_units(axis)[name]
    return SHOWN.get(unit, unit)


def scale_shown(name: str, axis: str) -> float:
    """What to multiply its SI value with."""
    unit = unit_along("N", axis) if name.startswith(STATIC) else known_units(axis)[name]
    return factor(unit, SHOWN.get(unit, unit))


def published_table(spec: PublishedTable, fit: ThesisFit, truth: Mapping[str, float] | None, axis: str) -> pd.DataFrame:
    """A printed table as text: a row a speed of rotation, or of one speed a row a parameter; "mean (std)".

    Where the truth is known and the rod does not turn under an axial motion, its values stand beside.
    """
    names = [name for name in PUBLISHED if name in spec.values]
    groups = [fit.groups.get(rpm, {}) for rpm in spec.rpm]
    suffix = SUFFIXES[spec.direction]
    if len(groups) > 1:
        return pd.DataFrame([_line_of_speed(spec, i, names, group, suffix, axis) for i, group in enumerate(groups)])
    lines = []
    for name in names:
        line = {"parameter": name, "unit": unit_shown(name, axis)}
        line |= {FOUND: _estimated(groups[0].get(name + suffix), name, axis), PRINTED: _printed(spec, name, 0, axis)}
        if truth is not None and spec.rpm[0] == 0.0:
            line["truth"] = _mean_and_std(_true(truth, name, suffix), None, name, axis)
        lines.append(line)
    return pd.DataFrame(lines)


def _line_of_speed(
    spec: PublishedTable, i: int, names: list[str], group: Mapping[str, Estimate], suffix: str, axis: str
) -> dict[str, str]:
    line = {"rpm": f"{spec.rpm[i]:g}"}
    for name in names:
        label = name.replace("_", " ")
        line[f"{label} ({unit_shown(name, axis)})"] = _estimated(group.get(name + suffix), name, axis)
        line[f"{label}, {PRINTED}"] = _printed(spec, name, i, axis)
    return line


def _true(truth: Mapping[str, float], name: str, suffix: str) -> float | None:
    if name == STATIC:
        parts = [_true(truth, part, suffix) for part in ("coulomb", "stribeck")]
        return None if None in parts else sum(part for part in parts if part is not None)
    return truth.get(name + suffix, None if suffix == SUFFIXES["rotary"] else truth.get(name))


def _estimated(estimate: Estimate | None, name: str, axis: str) -> str:
    if estimate is None:
        return ""
    text = _mean_and_std(estimate.value, estimate.std_of_repeats, name, axis)
    return f"{text}, {doubted}" if (doubted := remark(estimate)) else text


def remark(estimate: Estimate) -> str:
    """What to say beside a value that the records do not give."""
    return "" if not doubt(estimate) else "none seen" if estimate.value == 0.0 else "not identified"


def _printed(spec: PublishedTable, name: str, i: int, axis: str) -> str:
    return _mean_and_std(spec.values[name][i], spec.std[name][i] if name in spec.std else None, name, axis)


def _mean_and_std(value: float | None, std: float | None, name: str, axis: str) -> str:
    """`mean (std)` in the unit shown; nothing smaller than a thousandth of its unit is told from 0."""
    if value is None or value != value:
        return ""
    scale = scale_shown(name, axis)
    text = _number(scale * value)
    return text if std is None or std != std else f"{text} ({_number(scale * std)})"


def _number(value: float) -> str:
    if abs(value) < 1e-3:
        return "0"
    return f"{value:.0f}" if 100.0 <= abs(value) < 1e6 else shown_number(value, DIGITS)


def published_notes(spec: PublishedTable, fit: ThesisFit) -> list[str]:
    """How to read the table, and what the experiment says of it."""
    suffix = SUFFIXES[spec.direction]
    groups = [fit.groups.get(rpm, {}) for rpm in spec.rpm]
    counts = {group[STATIC + suffix].count for group in groups if STATIC + suffix in group}
    repeats = "no" if not counts else f"{min(counts)}" if len(counts) == 1 else f"{min(counts)} to {max(counts)}"
    source = f" Published: {spec.source}." if spec.source else ""
    means = "Of one run" if counts == {1} else f"Means and, in brackets, standard deviations over {repeats} runs"
    return [
        f"{means}, by the thesis's method.{source}",
        *([spec.note] if spec.note else []),
    ]
