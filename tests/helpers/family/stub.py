"""Diagnoses that read the truth: they show that the suite scores right and wrong answers as what they are."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .making import truth_of
from .scoring import FRICTION
from .unlisted import UNLISTED

SPREAD = 0.1
"""Standard deviation of every parameter, as a share of its true value."""


@dataclass(frozen=True)
class Report:
    """What a diagnosis says."""

    content: Mapping[str, Any]

    def to_json(self) -> dict[str, object]:
        """As report.json holds it."""
        return dict(self.content)


def _effect(name: str, parameters: Mapping[str, float], off: float, alternatives: Sequence[str] = ()) -> dict[str, Any]:
    numbers = {key: _number(value, off) for key, value in parameters.items()}
    return {"name": name, "balance": "", "parameters": numbers, "alternatives": list(alternatives)}


def _number(true: float, off: float) -> dict[str, Any]:
    """A parameter that is `off` by so many standard deviations."""
    std = SPREAD * abs(true)
    return {"value": true + off * std, "unit": "", "std": std, "identified": True}


def _report(
    truth: Mapping[str, Any], effects: Sequence[Mapping[str, Any]], unexplained: object, off: float, after: float
) -> Report:
    """Errors of position are twice the noise before, and `after` times it after, free of noise."""
    noise = truth["noise"]["position"]
    errors = {
        when: {"position_rms_m": noise * (1.0 + times**2) ** 0.5} for when, times in (("before", 2.0), ("after", after))
    }
    return Report(
        {
            "verdict": "effect_found" if effects else "none_missing",
            "effects": effects,
            "unexplained": unexplained,
            "error": {"held_out": errors},
            "floor": {"force": {"after": 1.0 + after}, "flow": {"after": 1.0}},
            "fitted": {name: _number(truth["values"][name], off) for name in FRICTION},
        }
    )


def perfect(path: Path) -> Report:
    """Names all that is there and removes it; every interval holds its true value."""
    truth, effects, unexplained = truth_of(path.parent), [], None
    for name, one in truth["effects"].items():
        if name in UNLISTED:
            unexplained = {"balance": UNLISTED[name].balance, "depends_on": ["acceleration", UNLISTED[name].signals[0]]}
        else:
            effects.append(_effect(name, one["parameters"], 1.6))
    return _report(truth, effects, unexplained, 1.6, 0.0)


def stubborn(path: Path) -> Report:
    """Always blames a drift with a delay as its alternative, changes nothing, and is too sure of itself."""
    truth = truth_of(path.parent)
    return _report(truth, [_effect("viscous_drift", {}, 0.0, ["command_delay"])], None, 1.7, 2.0)


def failing(path: Path) -> Report:
    """Fails."""
    raise ArithmeticError("no")
