"""Ratios as they were stored the last time, and which of them are others now."""

import json
from collections.abc import Mapping
from pathlib import Path

from suite.part import Ratio, shown

LEAST = 0.05
"""Share by which a ratio has to move at least: one that was measured once has no spread of its own."""


def stored(path: Path) -> dict[str, Ratio]:
    """Those in a file that `store` wrote; none where there is none yet."""
    if not path.exists():
        return {}
    found = json.loads(path.read_text(encoding="utf-8"))
    return {name: Ratio(tuple(values)) for name, values in found.items()}


def store(path: Path, ratios: Mapping[str, Ratio]) -> None:
    """Write the ratios of this time, those of each round, by name."""
    rounded = {name: [float(f"{value:.4g}") for value in ratio.values] for name, ratio in ratios.items()}
    path.write_text(json.dumps(rounded, indent=2) + "\n", encoding="utf-8")


def changes(before: Mapping[str, Ratio], now: Mapping[str, Ratio]) -> list[str]:
    """A line for each ratio whose rounds all lie beyond those of the last time, its median by `LEAST` at least."""
    lines = []
    for name, ratio in now.items():
        old = before.get(name)
        if old is None:
            continue
        apart = min(ratio.values) > max(old.values) or max(ratio.values) < min(old.values)
        if apart and abs(ratio.middle - old.middle) > LEAST * abs(old.middle):
            lines.append(f"{name}: {shown(ratio.middle)}, was {shown(old.middle)}")
    return lines
