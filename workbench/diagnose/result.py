"""What a diagnosis finds, in SI: effects with their numbers, and the content of report.json."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plants.effects import EFFECTS
from workbench.diagnose.residuals.fitting import Balance, Fit
from workbench.diagnose.residuals.flow import pressure_sum
from workbench.diagnose.residuals.motion import Motion, load_pressure
from workbench.diagnose.selection.selection import Step, gain
from workbench.diagnose.simulation.simulated import Simulated, explained
from workbench.parameters.sets import known_units

OFFSET_SHARE = 0.5
"""Share of the rms of the pressures' sum that one constant has to take away to be a sensor's offset."""

OFFSET_SURE = 4.0
"""Noise deviations (smoothed) that it has to exceed."""

CONFOUNDED = 0.2
"""Correlation between speed and pressure from which friction's dependence on them is said to be confounded."""

IDENTIFIED = 0.5
"""Standard deviation over value below which a parameter is identified."""


@dataclass(frozen=True, eq=False)
class Found:
    """An effect that was found: on which balance, its numbers with standard deviations, what it may be instead."""

    name: str
    balance: str
    numbers: Mapping[str, tuple[float, float]]
    alternatives: Sequence[str]
    evidence: Mapping[str, float]
    remarks: Sequence[str] = ()

    @property
    def data(self) -> dict[str, Any]:
        """As report.json holds it."""
        units = known_units()
        return {
            "name": self.name,
            "balance": self.balance,
            "parameters": {
                name: {"value": value, "unit": units.get(name, "1"), "std": std}
                for name, (value, std) in self.numbers.items()
            },
            "alternatives": list(self.alternatives),
            "evidence": {**dict(self.evidence), **({"remarks": list(self.remarks)} if self.remarks else {})},
        }


def sensor_offset(motions: Sequence[Motion], values: Mapping[str, float]) -> Found | None:
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


def found_on(balance: Balance, after: Fit, steps: Sequence[Step]) -> list[Found]:
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


def found_by_both(found: Sequence[Found], simulated: Simulated) -> list[Found]:
    """What the balances found and the simulated plant keeps, then what it adds; numbers are its own where it is
    trusted.
    """
    after = simulated.after
    kept = [one for one in found if one.name not in simulated.dropped]
    known = {one.name for one in kept}
    stayed = [step for step in simulated.steps if step.added is not None and step.added.effect in simulated.effects]
    kept += [one for one in found_on(after.balance, after, stayed) if one.name not in known]
    out = []
    for one in kept:
        names = simulated.effects.get(one.name, tuple(one.numbers))
        numbers = dict(one.numbers)
        if (simulated.is_trusted or one.name not in known) and set(names) <= set(after.names):
            numbers = {name: (after.values[name], after.deviations[name]) for name in names}
        evidence = dict(one.evidence)
        if one.name not in known:
            evidence["explained"] = explained(simulated.named, after)
        out.append(Found(one.name, one.balance, numbers, one.alternatives, evidence, one.remarks))
    return out


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


def fitted_data(fits: Sequence[Fit]) -> dict[str, Any]:
    """Every fitted parameter as report.json holds it; of several fits the last counts."""
    units = known_units()
    data = {}
    for fit in fits:
        for name in fit.names:
            value, std = fit.values[name], fit.deviations[name]
            data[name] = {
                "value": value,
                "unit": units.get(name, "1"),
                "std": std,
                "identified": bool(name not in fit.bounded and std < IDENTIFIED * abs(value)),
            }
    return data
