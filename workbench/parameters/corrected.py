"""A corrected plant as a parameter file, as `workbench.parameters.sets` reads it."""

import json
import math
from collections.abc import Iterable
from typing import NamedTuple

from workbench.parameters.sets import WORDS, known_units


class Entry(NamedTuple):
    """One parameter: its value and standard deviation (SI; None: it has none), and where they are from."""

    name: str
    value: float
    std: float | None
    source: str


def parameter_file(title: str, source: str, entries: Iterable[Entry], axis: str) -> str:
    """The text of a parameter file with these entries, in their order, for plants of that axis."""
    lines = [f"title = {_text(title)}", f"source = {_text(source)}"]
    for entry in entries:
        unit = known_units(axis)[entry.name]
        words = {number: word for word, number in WORDS.get(entry.name, {}).items()}
        value = _text(words[entry.value]) if words else _quantity(entry.value, unit)
        lines += ["", f"[parameters.{entry.name}]", f"value = {value}"]
        if entry.std is not None:
            lines.append(f"std = {_quantity(entry.std, unit)}")
        lines.append(f"source = {_text(entry.source)}")
    return "\n".join(lines) + "\n"


def _quantity(value: float, unit: str) -> str:
    if math.isinf(value):
        return '"inf"'
    return f"{value:.10g}" if unit == "1" else f'"{value:.10g} {unit}"'


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
