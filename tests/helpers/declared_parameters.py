"""The file that says what is believed of a plant."""

from collections.abc import Mapping
from pathlib import Path

from plants.equation import fields
from plants.interface import Plant
from workbench.parameters.sets import known_units


def write_declared(path: Path, plant: Plant, values: Mapping[str, float]) -> None:
    """A parameter file of those of the `values` (SI) that the plant has."""
    own, units = {item.name for item in fields(plant.Parameters)}, known_units(plant.axis)
    lines = ['title = "a machine"', 'source = "made up"']
    for name, value in values.items():
        if name in own:
            lines += [f"[parameters.{name}]", f'value = "{value!r} {units[name]}"', 'source = "made up"']
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
