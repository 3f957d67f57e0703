"""The parameter sets that come with the program: every value with its source and what was mended."""

from pathlib import Path

from builder.markdown import cell, table
from workbench.parameters.sets import ParameterFile, known_units, named_sets
from workbench.toml.reading import read_toml, validate


def page(folder: Path) -> str:
    """A table a set."""
    parts = [
        "# Parameter sets",
        "What `[plant] parameters` may name, as it stands in `plants/parameters/`. A value that was mended says why. "
        "[Machines](../machines.md) says what each parameter is.",
    ]
    units = known_units("m") | known_units("rad")
    for name, path in named_sets().items():
        data, text = read_toml(path)
        found = validate(ParameterFile, data, path, text)
        rows = [
            [f"`{key}`", _shown(entry.value, units.get(key, "")), _shown(entry.std, units.get(key, "")), _said(entry)]
            for key, entry in found.parameters.items()
        ]
        parts += [f"## {name}", f"{found.title}. {found.source}."]
        parts += [table(["parameter", "value", "deviation", "source"], rows)]
    return "\n\n".join(parts) + "\n"


def _shown(value: float | str | None, unit: str) -> str:
    """A quantity as it is written; a bare number with its SI unit."""
    if value is None or isinstance(value, str):
        return value or ""
    return f"{value:g} {'' if unit == '1' else unit}".strip()


def _said(entry: object) -> str:
    """Where a value comes from, and what was mended or is to be noted."""
    words = [getattr(entry, name) for name in ("source", "correction", "note")]
    return cell(". ".join(str(word).rstrip(".") for word in words if word))
