"""Diagnoses that differ from one that was made, for tests of what is said of them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from workbench.diagnose.readiness import check_experiment, declared_values, motions_of
from workbench.diagnose.residual_stage import ResidualStage, baselines, with_effects, with_floors
from workbench.diagnose.result import ENDED, VAGUE, Diagnosis, Errors
from workbench.diagnose.selection.selection import BalanceResult
from workbench.diagnose.selection.unexplained import Dependence, OfferedTerm, TermErrors, Unexplained
from workbench.progress import silent
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records


def balances_with_effects(path: Path) -> ResidualStage:
    """The balances of an experiment file with the effects that they find by themselves, whatever a simulation says."""
    experiment = read_experiment(path)
    check_experiment(experiment)
    motions = motions_of(experiment, read_records(experiment))
    stage = baselines(experiment, motions, declared_values(experiment), None, silent)
    return with_effects(with_floors(stage, experiment, silent), experiment, silent)


def without_effects(diagnosis: Diagnosis) -> Diagnosis:
    """Nothing was found, and nothing is unexplained."""
    return replace(diagnosis, effects=[], unexplained=None)


def unexplained(
    diagnosis: Diagnosis, balance: str, shares: Mapping[str, float], gain: float | None = None
) -> Diagnosis:
    """Nothing was found, and a balance depends on signals; of a simulated plant with what a curve would `gain`."""
    term = OfferedTerm(next(iter(shares)), np.zeros(2), np.zeros(2), "N", TermErrors(1.0, 0.5))
    return replace(diagnosis, effects=[], unexplained=Unexplained(Dependence(balance, shares, gain), term))


def rejected(diagnosis: Diagnosis) -> Diagnosis:
    """What was found doubles the error of each balance and of a free run on held-out records."""
    before = diagnosis.errors.held_out.before
    assert before.position is not None
    balances = {name: 2.0 * rms for name, rms in before.balances.items()}
    return with_held_out(diagnosis, balances, 2.0 * before.position)


def with_held_out(diagnosis: Diagnosis, balances: Mapping[str, float], position: float | None = None) -> Diagnosis:
    """These errors (SI) of balances, and of a free run's position if one is given, on held-out records, with what was
    found.
    """
    tested = diagnosis.errors.held_out
    run = tested.after.position if position is None else position
    after: Errors = replace(tested.after, balances={**tested.after.balances, **balances}, position=run)
    return replace(diagnosis, errors=replace(diagnosis.errors, held_out=replace(tested, after=after)))


def with_left(diagnosis: Diagnosis, floors: Mapping[str, float]) -> Diagnosis:
    """So many noise floors (rms) are left of these balances on the records that were fitted."""
    return replace(diagnosis, results=_scaled(diagnosis.results, floors))


def _scaled(results: Sequence[BalanceResult], floors: Mapping[str, float]) -> list[BalanceResult]:
    scaled = []
    for result in results:
        share = floors.get(result.balance.name, result.after.rms) / result.after.rms
        scaled.append(replace(result, after=replace(result.after, residual=share * result.after.residual)))
    return scaled


def doubting(
    diagnosis: Diagnosis, fit: Literal["baseline_parameters", "fitted_parameters"], name: str, **changes: Any
) -> Diagnosis:
    """One of both fits does not identify a parameter."""
    parameters = getattr(diagnosis, fit)
    doubt = VAGUE if changes.get("std") else ENDED
    doubted = replace(parameters[name], doubt=doubt, **changes)
    return replace(diagnosis, **{fit: {**parameters, name: doubted}})
