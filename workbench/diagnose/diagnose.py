"""The whole diagnosis of an experiment: honest baseline, flow before force, selection, held-out records, verdict."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plants.effects import EFFECTS
from workbench.diagnose.balances import balances_of
from workbench.diagnose.fitting import Balance, Fit, Values, fit
from workbench.diagnose.flow import pressure_sum
from workbench.diagnose.free_run import free_run
from workbench.diagnose.motion import Motion, load_pressure, motion_of
from workbench.diagnose.null import floored
from workbench.diagnose.selection import Step, gain, is_circular, select
from workbench.diagnose.unexplained import Dependence, dependence, strongest
from workbench.errors import UserError
from workbench.identify.experiment import Experiment, read_experiment
from workbench.identify.friction_records import parameter_values
from workbench.identify.records import read_records
from workbench.parameters import known_units

WORSE = 1.02
"""Held-out error, after over before, beyond which what was found is rejected."""

LEFT_OVER = 1.5
"""Floors above which a residual is not explained by the effects that were added."""

TAKEN = 0.3
"""Share of the residual that effects may leave, however much that is over the floor, and still be named."""

PLACES, PLACED = ("position", "time", "rotation_angle"), 0.3
"""Signals that no force makes, and the share of a residual's variance from which it is theirs."""

OFFSET_SHARE = 0.5
"""Share of the rms of the pressures' sum that one constant has to take away to be a sensor's offset."""

CONFOUNDED = 0.2
"""Correlation between speed and pressure from which friction's dependence on them is said to be confounded."""

OFFSET_SURE = 4.0
"""Noise deviations (smoothed) that it has to exceed."""


@dataclass(frozen=True, eq=False)
class Found:
    """An effect that was found: on which balance, its numbers with standard deviations, what it may be instead."""

    name: str
    balance: str
    numbers: Mapping[str, tuple[float, float]]
    alternatives: Sequence[str]
    evidence: Mapping[str, float]
    remarks: Sequence[str] = ()


@dataclass(frozen=True, eq=False)
class BalanceResult:
    """A balance before and after selection, with every round of it."""

    balance: Balance
    before: Fit
    after: Fit
    steps: Sequence[Step]


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """All that a diagnosis finds; `report` is the content of report.json."""

    experiment: Experiment
    held_out: Sequence[Motion]
    results: Sequence[BalanceResult]
    found: Sequence[Found]
    unexplained: Dependence | None
    declared: Values
    baseline: Values
    corrected: Values
    report: dict[str, Any]


def diagnose(path: Path) -> Diagnosis:
    """Diagnose an experiment file.

    Raises:
        UserError: the file or a record cannot be used, or its channels allow no balance.
    """
    experiment = read_experiment(path)
    fit_motions = [motion_of(record) for record in read_records(experiment, "fit")]
    held_out = [motion_of(record) for record in read_records(experiment, "held_out")]
    if not fit_motions:
        raise UserError(f'{path}: no record is for the fit; give one use = "fit"')
    declared: dict[str, float] = {**parameter_values(experiment), **experiment.values}
    for name in [one for one in declared if one.endswith("_negative") and one not in experiment.values]:
        del declared[name]
    offset = _offset(fit_motions, declared)
    values: dict[str, float] = dict(declared)
    if offset is not None:
        values |= {name: number for name, (number, _) in offset.numbers.items()}
    balances = balances_of(fit_motions, values, experiment.free)
    if not balances:
        raise UserError(
            f"{path}: its channels allow no balance: a flow needs position, both pressures and the valve's "
            "voltage, a force needs position and pressures, a force or a command"
        )
    results, found = [], [offset] if offset is not None else []
    baseline = dict(declared)
    first = dict(values)
    for balance in balances:
        first |= fit(balance, first, balance.free, experiment.bounds).values
    balances = floored(balances, first, experiment.flow)
    for balance in balances:
        after, steps = select(balance, values, experiment.bounds)
        if _leaves_too_much(steps[0].before, after, steps):
            after, steps = steps[0].before, [replace(steps[0], added=None, alternatives=[])]
        results.append(BalanceResult(balance, steps[0].before, after, steps))
        found += _found_on(balance, after, steps)
        baseline |= {name: steps[0].before.values[name] for name in balance.free}
        values |= {name: after.values[name] for name in after.names}
    dependences = [dependence(result.balance, result.after.values) for result in results]
    unexplained = strongest(dependences)
    errors = _errors(experiment, results, baseline, values, held_out)
    verdict = _verdict(found, unexplained, errors)
    report = {
        "title": experiment.title,
        "verdict": verdict,
        "effects": [_effect_data(one) for one in found],
        "unexplained": None
        if unexplained is None
        else {"balance": unexplained.balance, "depends_on": unexplained.signals, "shares": dict(unexplained.shares)},
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
        "baseline": _baseline_data(results),
    }
    return Diagnosis(experiment, held_out, results, found, unexplained, declared, baseline, values, report)


def _leaves_too_much(before: Fit, after: Fit, steps: Sequence[Step]) -> bool:
    """Whether effects take a part of a residual that goes on to depend on a signal: then they stand in for another.

    A circular one takes its part of any residual: it is not believed where the residual depends on place or time.
    """
    if after is before or not after.balance.simulated:  # without such a floor nobody knows what is too much
        return False
    if any(step.added is not None and is_circular(step.added.effect, after.balance) for step in steps):
        first = dependence(before.balance, before.values)
        if first is not None and any(first.shares.get(name, 0.0) > PLACED for name in PLACES):
            return True
    if after.rms < LEFT_OVER or after.rms < TAKEN * before.rms:
        return False
    return dependence(after.balance, after.values) is not None


def _offset(motions: Sequence[Motion], values: Values) -> Found | None:
    """An offset of pressure 1: the sum of both pressures is off by a constant, and by little else."""
    if not motions[0].has("pressure_1", "pressure_2") or "supply_pressure" not in values:
        return None
    sums = np.concatenate([pressure_sum(motion, values)[motion.valid] for motion in motions])
    mean, rms = float(np.mean(sums)), float(np.sqrt(np.mean(sums**2)))
    blocks = np.array([np.mean(part) for part in np.array_split(sums, 10)])
    std = float(np.std(blocks, ddof=1) / np.sqrt(blocks.size))
    noise = motions[0].smooth[0] * float(np.hypot(motions[0].noise["pressure_1"], motions[0].noise["pressure_2"]))
    left = float(np.std(sums))
    if left > (1.0 - OFFSET_SHARE) * rms or abs(mean) < OFFSET_SURE * max(noise, std):
        return None
    return Found(
        "pressure_sensor_offset",
        "sensor",
        {"pressure_1_offset": (mean, max(std, noise / 10.0))},
        [],
        {"sum_rms_Pa": rms, "left_rms_Pa": left},
    )


def _found_on(balance: Balance, after: Fit, steps: Sequence[Step]) -> list[Found]:
    """The effects of a balance in the order in which they were added, their numbers from the last fit.

    An effect that gained a parameter in a later round is one effect, with the evidence of its first.
    """
    found: dict[str, Found] = {}
    for step in steps:
        added = step.added
        if added is None:
            continue
        first = found.get(added.effect)
        names = dict.fromkeys([*(first.numbers if first else ()), *added.variant])
        numbers = {name: (after.values[name], after.deviations[name]) for name in names}
        share, sure = gain(step.before, added.fit)
        evidence: dict[str, float] = (
            dict(first.evidence) if first else {"left_out_gain": share, "standard_errors": sure}
        )
        alternatives = first.alternatives if first else step.alternatives
        remarks = first.remarks if first else _remarks(balance, added.effect, evidence)
        found[added.effect] = Found(
            added.effect, EFFECTS[added.effect].balance, numbers, alternatives, evidence, remarks
        )
    return list(found.values())


def _remarks(balance: Balance, effect: str, evidence: dict[str, float]) -> list[str]:
    """What a reader has to know of an effect that goes together with something else in these records."""
    if effect != "pressure_dependent_friction":
        return []
    evidence["correlation_with_speed"] = together = _speed_and_pressure(balance.motions)
    if abs(together) <= CONFOUNDED:
        return []
    word = "falls" if together < 0.0 else "rises"
    return [
        f"where the machine moves its speed {word} with the pressure (correlation {together:.2f}): what is said to "
        "depend on pressure may in part depend on speed; records at one pressure and several speeds would tell"
    ]


def _speed_and_pressure(motions: Sequence[Motion]) -> float:
    """Correlation between |v| and |P_L| where something moves."""
    moving = [motion.valid & ~motion.resting for motion in motions]
    speed = np.concatenate([np.abs(motion.velocity)[at] for motion, at in zip(motions, moving, strict=True)])
    pressure = np.concatenate([np.abs(load_pressure(motion))[at] for motion, at in zip(motions, moving, strict=True)])
    return float(np.corrcoef(speed, pressure)[0, 1])


def _effect_data(one: Found) -> dict[str, Any]:
    units = known_units()
    return {
        "name": one.name,
        "balance": one.balance,
        "parameters": {
            name: {"value": value, "unit": units.get(name, "1"), "std": std}
            for name, (value, std) in one.numbers.items()
        },
        "alternatives": list(one.alternatives),
        "evidence": {**dict(one.evidence), **({"remarks": list(one.remarks)} if one.remarks else {})},
    }


def _baseline_data(results: Sequence[BalanceResult]) -> dict[str, Any]:
    units = known_units()
    data = {}
    for result in results:
        fit = result.before
        for name in fit.names:
            value, std = fit.values[name], fit.deviations[name]
            data[name] = {
                "value": value,
                "unit": units.get(name, "1"),
                "std": std,
                "identified": bool(std < 0.5 * abs(value)),
            }
    return data


KEYS = {"force": "force_rms_N", "flow": "flow_rms_m3_per_s"}


def _errors(
    experiment: Experiment,
    results: Sequence[BalanceResult],
    baseline: Values,
    after: Values,
    held_out: Sequence[Motion],
) -> dict[str, Any]:
    """Rms of each balance's residual and of free-run simulation, with the baseline and with what was found."""
    errors: dict[str, Any] = {}
    for use, motions in (("fit", results[0].balance.motions), ("held_out", held_out)):
        sides: dict[str, dict[str, float]] = {"before": {}, "after": {}}
        for side, values in (("before", baseline), ("after", after)) if motions else ():
            for result in results:
                over = replace(result.balance, motions=motions)
                rms = float(np.sqrt(np.mean(over.stacked(values) ** 2))) * over.floor
                sides[side][KEYS[over.name]] = rms
            sides[side] |= free_run(experiment, [motion.record for motion in motions], values)
        errors[use] = sides
    return errors


def _verdict(found: Sequence[Found], unexplained: Dependence | None, errors: Mapping[str, Any]) -> str:
    before, after = errors["held_out"]["before"], errors["held_out"]["after"]
    if found and any(after[key] > WORSE * before[key] for key in KEYS.values() if key in before):
        return "rejected_on_held_out"
    if any(one.alternatives for one in found):
        return "ambiguous"
    if found:
        return "effect_found"
    return "unexplained" if unexplained is not None else "none_missing"
