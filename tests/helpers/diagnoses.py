"""Diagnoses that differ from one that was made, for tests of what is said of them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from workbench.diagnose.result import Diagnosis, Errors
from workbench.diagnose.selection.selection import BalanceResult
from workbench.diagnose.selection.unexplained import Dependence, OfferedTerm, TermErrors, Unexplained


def without_effects(diagnosis: Diagnosis) -> Diagnosis:
    """Nothing was found, and nothing is unexplained."""
    return replace(diagnosis, effects=[], unexplained=None)


def unexplained(diagnosis: Diagnosis, balance: str, shares: Mapping[str, float]) -> Diagnosis:
    """Nothing was found, and a balance depends on signals."""
    term = OfferedTerm(next(iter(shares)), np.zeros(2), np.zeros(2), "N", TermErrors(1.0, 0.5))
    return replace(diagnosis, effects=[], unexplained=Unexplained(Dependence(balance, shares), term))


def rejected(diagnosis: Diagnosis) -> Diagnosis:
    """What was found doubles the error of each balance on held-out records."""
    before = diagnosis.errors.held_out.before
    return with_held_out(diagnosis, {name: 2.0 * rms for name, rms in before.balances.items()})


def with_held_out(diagnosis: Diagnosis, balances: Mapping[str, float]) -> Diagnosis:
    """These errors (SI) of balances on held-out records, with what was found."""
    tested = diagnosis.errors.held_out
    after: Errors = replace(tested.after, balances={**tested.after.balances, **balances})
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
    doubted = replace(parameters[name], identified=False, **changes)
    return replace(diagnosis, **{fit: {**parameters, name: doubted}})
