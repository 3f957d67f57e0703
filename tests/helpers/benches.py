"""Loops on the bench, for its tests."""

from collections.abc import Mapping
from typing import Any

from command import STUDIES

from plants.equation import fields, to_array
from workbench.bench.groups import controls_of, groups_of
from workbench.bench.knobs import Control, Knob
from workbench.bench.loop import BenchLoop
from workbench.bench.opened import opened
from workbench.bench.outcome import Outcome

SHORT: Mapping[str, Any] = {"simulation.duration": 1.2, "simulation.transient": 0.0}


def short(name: str = "thesis_chapter3", **where: object) -> BenchLoop:
    """A case of a study that comes with the program, cut short."""
    return opened(STUDIES / f"{name}.toml", where).changed(SHORT)


def of_name(parameters: Any, name: str) -> float:
    """One of a plant's parameters."""
    return dict(zip((item.name for item in fields(type(parameters))), to_array(parameters).tolist(), strict=True))[name]


def knob_of(outcome: Outcome, key: str) -> Knob:
    """The knob of that key."""
    return next(one for one in controls(outcome) if isinstance(one, Knob) and one.key == key)


def controls(outcome: Outcome) -> list[Control]:
    """All that can be turned."""
    return [control for group in groups_of(outcome.loop) for control in controls_of(group, outcome)]
