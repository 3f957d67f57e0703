"""Diagnoses that read the truth: they show that the suite scores right and wrong answers as what they are."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from workbench.diagnose.result import BeforeAfter, Diagnosis, Errors, ErrorsByUse, Evidence, FoundEffect
from workbench.diagnose.selection.unexplained import Dependence, OfferedTerm, Unexplained
from workbench.records.experiment import read_experiment

from .effects import EFFECTS, UNLISTED


def _errors(rms: float) -> Errors:
    units = {"flow": "m^3/s", "force": "N"}
    return Errors({"flow": rms, "force": rms}, position=rms, load_pressure=rms, units=units)


def _diagnosis(
    path: Path, effects: Sequence[FoundEffect], unexplained: Unexplained | None, before: float, after: float
) -> Diagnosis:
    """A diagnosis of nothing but its effects, what is unexplained, and its errors on held-out records."""
    nothing = BeforeAfter(Errors({}), Errors({}))
    return Diagnosis(
        experiment=read_experiment(path),
        held_out=[],
        results=[],
        simulation=None,
        effects=effects,
        unexplained=unexplained,
        errors=ErrorsByUse(nothing, BeforeAfter(_errors(before), _errors(after))),
        declared={},
        baseline={},
        corrected={},
        baseline_parameters={},
        fitted_parameters={},
    )


def perfect(path: Path) -> Diagnosis:
    """Names all that is there and removes it, down to a floor of 1 from 10."""
    truth = json.loads((path.parent / "truth.json").read_text(encoding="utf-8"))
    effects = [FoundEffect(name, EFFECTS[name].balance, {}, [], Evidence()) for name in truth["effects"]]
    unexplained = None
    for name in truth["unlisted"]:
        signal, none = UNLISTED[name].signals[0], np.zeros(0)
        dependence = Dependence(UNLISTED[name].balance, {signal: 0.8, "velocity": 0.2})
        unexplained = Unexplained(dependence, OfferedTerm(signal, none, none, "N"))
    return _diagnosis(path, effects, unexplained, 10.0 if effects else 1.0, 1.0)


def stubborn(path: Path) -> Diagnosis:
    """Always blames a constant load, with a drag as its alternative, and changes nothing."""
    effect = FoundEffect("constant_load", "force", {}, ["quadratic_drag"], Evidence())
    return _diagnosis(path, [effect], None, 10.0, 10.0)


def failing(path: Path) -> Diagnosis:
    """Fails."""
    raise ArithmeticError("no")
