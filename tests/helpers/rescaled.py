"""The same experiment in other units of mass, length and time: as it would be on a larger or a slower machine."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd
import pint

BASES = {"[mass]": 1.0, "[length]": 1.0, "[time]": 1.0}

_units: "pint.UnitRegistry[float]" = pint.UnitRegistry(cache_folder=None)


def factor(unit: str, scale: Mapping[str, float]) -> float:
    """What a quantity of that unit is multiplied with; volts stay as they are."""
    whole = 1.0
    if unit != "V":
        for base, power in _units.Quantity(1.0, unit.replace("^", "**")).dimensionality.items():
            whole *= scale.get(base, 1.0) ** float(power)
    return whole


def rescaled(path: Path, folder: Path, mass: float = 1.0, length: float = 1.0, time: float = 1.0) -> Path:
    """Write the experiment at `path` to a folder with every quantity times what its unit asks for: its path."""
    scale = {"[mass]": mass, "[length]": length, "[time]": time}
    folder.mkdir(parents=True)
    declared = tomllib.loads((path.parent / "declared.toml").read_text(encoding="utf-8"))
    lines = [f'title = "{declared["title"]}"', 'source = "drawn"']
    for name, entry in declared["parameters"].items():
        number, _, unit = str(entry["value"]).partition(" ")
        size = factor(_without_volts(unit), scale) if unit else 1.0
        lines += [f"[parameters.{name}]", f'value = "{(float(number) * size)!r} {unit}"'.replace(' "', '"')]
        lines += ['source = "drawn"']
    (folder / "declared.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    text = path.read_text(encoding="utf-8")
    described: dict[str, Any] = tomllib.loads(text)
    for given in described["records"]:
        frame = pd.read_parquet(path.parent / given["file"])
        for channel in described["channels"].values():
            frame[channel["column"]] *= factor(_without_volts(channel["unit"]), scale)
        frame.to_parquet(folder / given["file"], index=False)
    (folder / path.name).write_text(text, encoding="utf-8")
    return folder / path.name


def _without_volts(unit: str) -> str:
    """Volts are signals here, whatever a machine's size."""
    return unit.replace("/V", "").replace("V", "1") if "V" in unit else unit
