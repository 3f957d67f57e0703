"""Takes the place of what is made elsewhere."""

from typing import Any, NamedTuple


class Bound(NamedTuple):
    low: float
    high: float
    logarithmic: bool


class PolishCase(NamedTuple):
    setup: Any
    first: int
    last: int
    scale: float


class PolishProblem(NamedTuple):
    cases: Any
    controller: Any
    settings: Any
    belief: Any
    bounds: Any


class Polished(NamedTuple):
    settings: Any
    start_value: float
    value: float
    gradient_evaluations: int
    reason: str


def polish(problem: PolishProblem) -> Polished:
    return Polished(problem.settings, 1.0, 1.0, 0, "not there yet")
