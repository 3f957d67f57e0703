"""Diagnoses that read the truth: they show that the suite scores right and wrong answers as what they are."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from .effects import EFFECTS, UNLISTED
from .scoring import FIGURES


def perfect(path: Path) -> Any:
    """Names all that is there and removes it, down to a floor of 1 from 10."""
    truth = json.loads((path.parent / "truth.json").read_text(encoding="utf-8"))
    effects = [{"name": name, "balance": EFFECTS[name].balance, "alternatives": []} for name in truth["effects"]]
    unexplained = None
    for name in truth["unlisted"]:
        unexplained = {"balance": UNLISTED[name].balance, "depends_on": [UNLISTED[name].signals[0], "velocity"]}
    error = {"before": dict.fromkeys(FIGURES, 10.0 if effects else 1.0), "after": dict.fromkeys(FIGURES, 1.0)}
    verdict = "effect_found" if effects else "unexplained" if unexplained else "none_missing"
    report = {"verdict": verdict, "effects": effects, "unexplained": unexplained, "error": {"held_out": error}}
    return SimpleNamespace(report=report)


def stubborn(path: Path) -> Any:
    """Always blames a constant load, with a drag as its alternative, and changes nothing."""
    effects = [{"name": "constant_load", "balance": "force", "alternatives": ["quadratic_drag"]}]
    error = {"before": dict.fromkeys(FIGURES, 10.0), "after": dict.fromkeys(FIGURES, 10.0)}
    report = {"verdict": "ambiguous", "effects": effects, "unexplained": None, "error": {"held_out": error}}
    return SimpleNamespace(report=report)


def failing(path: Path) -> Any:
    """Fails."""
    raise ArithmeticError("no")
