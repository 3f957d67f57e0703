"""The whole diagnosis of an experiment: honest baseline, flow before force, the plant simulated, held-out records,
verdict."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from workbench.diagnose.before_after import KEYS, behind_backlash, errors_of
from workbench.diagnose.readiness import check_experiment, declared_values, motions_of
from workbench.diagnose.residuals.balances import balances_of
from workbench.diagnose.residuals.fitting import Balance, Fit, fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.null import floored
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.result import (
    IDENTIFIED,
    Found,
    fitted_data,
    found_by_both,
    found_on,
    sensor_offset,
)
from workbench.diagnose.selection.selection import BalanceResult, Step, is_circular, select
from workbench.diagnose.selection.unexplained import Dependence, data_driven_term, dependence, strongest
from workbench.diagnose.simulation.simulated import FirstLook, Simulated, second_look
from workbench.diagnose.stages import Tell
from workbench.parameters.sets import SIGNED
from workbench.records.experiment import Experiment, read_experiment
from workbench.records.reading import read_records

WORSE = 1.02
"""Held-out error, after over before, beyond which what was found is rejected."""

LEFT_OVER = 1.5
"""Floors above which a residual is not explained by the effects that were added."""

TAKEN = 0.3
"""Share of the residual that effects may leave, however much that is over the floor, and still be named."""

PLACES, PLACED = ("position", "time", "rotation_angle"), 0.3
"""Signals that no force makes, and the share of a residual's variance from which it is theirs."""

RUNAWAY = 5.0
"""Times the declared value, or a part of it, beyond which no fit of a balance is a place to begin a simulation."""


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """All that a diagnosis finds; `report` is the content of report.json.

    `baseline` and `corrected` are the parameters, without and with effects, that fit the balances; those that fit the
    simulated plant are in `simulated`, if the records can be simulated.
    """

    experiment: Experiment
    held_out: Sequence[Motion]
    results: Sequence[BalanceResult]
    simulated: Simulated | None
    found: Sequence[Found]
    unexplained: Dependence | None
    declared: Values
    baseline: Values
    corrected: Values
    report: dict[str, Any]

    @property
    def rounds(self) -> list[BalanceResult]:
        """Where effects competed: the balances, and the simulated plant."""
        return [*self.results, *([self.simulated.result] if self.simulated is not None else [])]

    @property
    def fits(self) -> list[BalanceResult]:
        """What the parameters come from: the balances, and after them the simulated plant where it is trusted."""
        return self.rounds if self.simulated is not None and self.simulated.is_trusted else list(self.results)


def diagnose(path: Path, tell: Tell = lambda said, done: None) -> Diagnosis:
    """Diagnose an experiment file; `tell` is told what is being done, and how far it is.

    Raises:
        UserError: the file or a record cannot be used, or its channels allow no balance.
    """
    experiment = read_experiment(path)
    tell("reading records", 0.0)
    check_experiment(experiment)
    fitted = read_records(experiment, "fit")
    both = motions_of(experiment, [*fitted, *read_records(experiment, "held_out")])
    motions, held_out = both[: len(fitted)], both[len(fitted) :]
    declared = declared_values(experiment)
    offset = sensor_offset(motions, declared)
    results, baseline, corrected = _first_look(experiment, motions, declared, offset, tell)
    found = [offset] if offset is not None else []
    found += [one for result in results for one in found_on(result.balance, result.after, result.steps)]
    first = FirstLook(
        [name for result in results for name in result.balance.free],
        declared,
        _starts(declared, baseline, [(result.balance, result.before) for result in results]),
        _starts(declared, corrected, [(result.balance, result.after) for result in results]),
        {one.name: tuple(one.numbers) for one in found},
    )
    simulated = second_look(experiment, motions, first, tell)
    if simulated is not None:
        again, values = _with_effects(experiment, results, declared, corrected, found, simulated)
        if simulated.is_in_doubt and any(_depends(result.after) for result in again):
            simulated = simulated.without_additions()
            again, values = _with_effects(experiment, results, declared, corrected, found, simulated)
        found, results, corrected = found_by_both(found, simulated), again, values
    unexplained = strongest([_depends(result.after) for result in results])
    tell("held-out records", 0.9)
    errors = errors_of(experiment, results, simulated, baseline, corrected, held_out)
    report = {
        "title": experiment.title,
        "verdict": _verdict(found, unexplained, errors),
        "effects": [one.data for one in found],
        "unexplained": None if unexplained is None else _unexplained_data(unexplained, results, held_out),
        "error": errors,
        "floor": {
            result.balance.name: {
                "value": result.balance.floor,
                "unit": result.balance.unit,
                "before": result.before.rms,
                "after": result.after.rms,
            }
            for result in results
        },
        "simulation": None if simulated is None else simulated.data,
    }
    whole = Diagnosis(
        experiment, held_out, results, simulated, found, unexplained, declared, baseline, corrected, report
    )
    report["baseline"] = fitted_data([one.before for one in whole.fits])
    report["fitted"] = fitted_data([one.after for one in whole.fits])
    return whole


def _unexplained_data(
    unexplained: Dependence, results: Sequence[BalanceResult], held_out: Sequence[Motion]
) -> dict[str, Any]:
    """What is not explained, as report.json holds it, with the data-driven term that is offered for it."""
    after = next(result.after for result in results if result.balance.name == unexplained.balance)
    term = data_driven_term(after.balance, after.values, unexplained.signals[0])
    offered: dict[str, Any] = {
        "signal": term.signal,
        "nodes": term.nodes.tolist(),
        "values": term.values.tolist(),
        "unit": after.balance.unit,
    }
    for use, motions in (("fit", after.balance.motions), ("held_out", held_out)):
        if term.is_tested_by(motions):
            offered[use] = dict(zip(("before", "after"), term.left(motions, after.values), strict=True))
    return {
        "balance": unexplained.balance,
        "depends_on": unexplained.signals,
        "shares": dict(unexplained.shares),
        "data_driven_term": offered,
    }


def _starts(declared: Values, values: Values, fits: Sequence[tuple[Balance, Fit]]) -> dict[str, float]:
    """Where a simulation begins: `values`, but the plant's own parameters as declared where a balance says little of
    them, or lets one run away.
    """
    out = dict(values)
    for balance, found in fits:
        for name in balance.free:
            value, start = found.values[name], declared[name]
            if name in SIGNED or start <= 0.0:
                continue
            known = name not in found.bounded and found.deviations[name] < IDENTIFIED * value
            out[name] = value if known and 1.0 / RUNAWAY < value / start < RUNAWAY else start
    return out


def _first_look(
    experiment: Experiment,
    motions: Sequence[Motion],
    declared: Values,
    offset: Found | None,
    tell: Tell,
) -> tuple[list[BalanceResult], dict[str, float], dict[str, float]]:
    """Flow, then force: each balance with the effects that it supports, baseline values and values with effects."""
    baseline, values = dict(declared), dict(declared)
    if offset is not None:
        values |= {name: number for name, (number, _) in offset.numbers.items()}
    balances = balances_of(motions, values, experiment.free)
    tell("noise floors", 0.02)
    first = dict(values)
    for balance in balances:
        first |= fit(balance, first, balance.free, experiment.bounds).values
    results = list[BalanceResult]()
    for balance in floored(balances, first, experiment.flow):
        tell(f"effects on the {balance.name} balance", 0.1 + 0.1 * len(results))
        after, steps = select(balance, values, experiment.bounds)
        if _leaves_too_much(steps[0].before, after, steps):
            after, steps = steps[0].before, [replace(steps[0], added=None, alternatives=[])]
        results.append(BalanceResult(balance, steps[0].before, after, steps))
        baseline |= {name: steps[0].before.values[name] for name in balance.free}
        values |= {name: after.values[name] for name in after.names}
    return results, baseline, values


def _with_effects(
    experiment: Experiment,
    results: Sequence[BalanceResult],
    declared: Values,
    corrected: Values,
    found: Sequence[Found],
    simulated: Simulated,
) -> tuple[list[BalanceResult], dict[str, float]]:
    """The balances with the effects that the simulated plant has, and the values that fit them.

    As they are where these are the same effects; else their own parameters are fitted anew around the effects' numbers.
    """
    if {one.name for one in found} == set(simulated.effects):
        return list(results), dict(corrected)
    names = [name for own in simulated.effects.values() for name in own]
    values = {**declared, **{name: simulated.after.values[name] for name in names}}
    again = []
    for result in results:
        balance = replace(
            result.balance, motions=behind_backlash(simulated.how, result.balance.motions, simulated.after.values)
        )
        after = fit(balance, values, balance.free, experiment.bounds)
        values |= {name: after.values[name] for name in after.names}
        again.append(replace(result, after=after))
    return again, values


def _depends(after: Fit) -> Dependence | None:
    return dependence(after.balance, after.values)


def _leaves_too_much(before: Fit, after: Fit, steps: Sequence[Step]) -> bool:
    """Whether effects take a part of a residual that goes on to depend on a signal: then they stand in for another.

    A circular one takes its part of any residual: it is not believed where the residual depends on place or time.
    """
    if after is before or not after.balance.simulated:  # without such a floor nobody knows what is too much
        return False
    if any(step.added is not None and is_circular(step.added.effect, after.balance) for step in steps):
        first = _depends(before)
        if first is not None and any(first.shares.get(name, 0.0) > PLACED for name in PLACES):
            return True
    if after.rms < LEFT_OVER or after.rms < TAKEN * before.rms:
        return False
    return _depends(after) is not None


def _verdict(found: Sequence[Found], unexplained: Dependence | None, errors: Mapping[str, Any]) -> str:
    before, after = errors["held_out"]["before"], errors["held_out"]["after"]
    if found and any(after[key] > WORSE * before[key] for key in KEYS.values() if key in before):
        return "rejected_on_held_out"
    if any(one.alternatives for one in found):
        return "ambiguous"
    if found:
        return "effect_found"
    return "unexplained" if unexplained is not None else "none_missing"
