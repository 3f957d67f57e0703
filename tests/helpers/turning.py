"""A plant whose axis turns, of which no more than the units count."""

from dataclasses import replace
from typing import Annotated, NamedTuple

import pytest

from plants.interface import Plant
from plants.registry import PLANTS


class TurningState(NamedTuple):
    position: Annotated[float, "rad"]
    velocity: Annotated[float, "rad/s"]
    bristle_deflection: Annotated[float, "rad"]


def register_turning(monkeypatch: pytest.MonkeyPatch, plant: Plant) -> None:
    """Make `plant` known, with an axis that turns, as "turning"."""
    ours = {**PLANTS.ours, "turning": replace(plant, name="turning", State=TurningState)}
    monkeypatch.setitem(PLANTS.__dict__, "ours", ours)
