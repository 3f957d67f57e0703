"""From a point of what is tuned to everything that its runs depend on."""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import pi
from typing import NamedTuple

from controllers.interface import Controller
from controllers.settings import settings_of
from plants.axis import LINEAR
from workbench.study.overrides import Overrides
from workbench.study.resolve import ParsedCase, Resolved
from workbench.study.study import Study
from workbench.study.uncertainty import plant_sample
from workbench.study.uncertainty_schema import UncertaintyTable
from workbench.tune.space import RPM, THRESHOLD, Dimension, Point

SAMPLES = 4096
"""Plant samples that are kept resolved."""


@dataclass(frozen=True, eq=False)
class Task:
    """One controller of a study, to be tuned: its cases on the declared machine, and what is tuned.

    `settings` are those that the study gives it. `at` are the values of the axes that [tune] per names: each
    combination of them has a task of its own. `axis` is the unit of the plant's positions, "m" or "rad".
    """

    study: Study
    name: str
    controller: Controller
    settings: NamedTuple
    cases: Sequence[ParsedCase]
    dimensions: Sequence[Dimension]
    uncertainty: UncertaintyTable
    at: Mapping[str, object] = field(default_factory=dict)
    axis: str = LINEAR

    @property
    def label(self) -> str:
        """The task in words: the controller, and where it is tuned."""
        return ", ".join([self.name, *(f"{axis} {value}" for axis, value in self.at.items())])

    @property
    def rpm(self) -> float | None:
        """The speed of rotation (rpm) for which it is tuned; None where it is tuned for all of them."""
        return self.cases[0].case.rpm if RPM in self.at else None

    @property
    def rotates(self) -> bool:
        """Whether the rotation is tuned too."""
        return any(dimension.name in (RPM, THRESHOLD) for dimension in self.dimensions)

    @property
    def start(self) -> dict[str, float]:
        """The study's own point; nearest to it within the limits."""
        return {
            dimension.name: min(max(dimension.start, dimension.low), dimension.high) for dimension in self.dimensions
        }

    def settings_at(self, point: Point) -> NamedTuple:
        """The controller's settings at a point."""
        return self.settings._replace(**{name: value for name, value in point.items() if name not in (RPM, THRESHOLD)})

    def declared(self, point: Point) -> list[Resolved]:
        """The cases at a point, on the declared machine."""
        return _at(self, tuple(sorted(point.items())))

    def sampled(self, point: Point, number: int, stream: int = 0) -> list[Resolved]:
        """The cases at a point, on the plant sample of that number."""
        rotation = tuple((name, point[name]) for name in (RPM, THRESHOLD) if name in point)
        samples = _samples(self, rotation, number, stream)
        loops = [case.setup.loop for case in self.declared(point)]
        return [
            replace(sample, setup=replace(sample.setup, loop=loop)) for sample, loop in zip(samples, loops, strict=True)
        ]


@functools.lru_cache(maxsize=64)
def _at(task: Task, point: tuple[tuple[str, float], ...]) -> list[Resolved]:
    overrides = overrides_at(dict(point))
    return [case.resolve(overrides) for case in task.cases]


@functools.lru_cache(maxsize=SAMPLES)
def _samples(task: Task, rotation: tuple[tuple[str, float], ...], number: int, stream: int) -> list[Resolved]:
    """The cases of a task on a plant sample, with the gains of the study."""
    sample = plant_sample(task.uncertainty, number, stream, task.axis)
    overrides = replace(overrides_at(dict(rotation)), sample=sample)
    return [case.resolve(overrides) for case in task.cases]


def overrides_at(point: Point) -> Overrides:
    """What a point changes of a case."""
    settings = {name: value for name, value in point.items() if name not in (RPM, THRESHOLD)}
    rpm = point[RPM] * 30.0 / pi if RPM in point else None
    return Overrides(settings, rpm, point.get(THRESHOLD))


def in_user_units(task: Task, point: Point) -> Mapping[str, float | str]:
    """A point as a study writes it: numbers with units."""
    written: dict[str, float | str] = {}
    declared = settings_of(task.controller.Settings)
    for dimension in task.dimensions:
        value = point[dimension.name]
        if dimension.name == RPM:
            written[dimension.name] = f"{value * 30.0 / pi:.12g} rpm"
        elif dimension.name in declared and declared[dimension.name].unit == "1":
            written[dimension.name] = float(f"{value:.12g}")
        else:
            written[dimension.name] = f"{value:.12g} {dimension.unit}"
    return written
