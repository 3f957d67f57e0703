"""The effects of a diagnosis with their numbers: of a sensor, of the balances, of the simulated plant."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from plants.effects.registry import effects as registered
from workbench.diagnose.residuals.fit import Fit
from workbench.diagnose.residuals.motion import Motion, load_pressure
from workbench.diagnose.result import FAR, MISLED, Estimate, Evidence, FittedParameter, FoundEffect
from workbench.diagnose.selection.selection import BalanceResult, stands_out
from workbench.diagnose.simulation.stage import SimulationStage

OFFSET_SHARE = 0.5
"""Share of the rms of the pressures' sum that one constant has to take away to be a sensor's offset."""

OFFSET_SURE = 4.0
"""Noise deviations (smoothed) that it has to exceed."""

CONFOUNDED = 0.2
"""Correlation between speed and pressure from which friction's dependence on them is said to be confounded."""

CONTRADICTS = 3.0
"""Standard deviations by which two fits of a parameter contradict each other."""


def sensor_offset(motions: Sequence[Motion], values: Mapping[str, float]) -> FoundEffect | None:
    """An offset of pressure 1: the sum of both pressures is off by a constant, and by little else."""
    matched = "tank_pressure" in values and values.get("piston_area_1") == values.get("piston_area_2")
    if not (motions[0].has("pressure_1", "pressure_2") and "supply_pressure" in values and matched):
        return None
    sums = np.concatenate([_pressure_sum(motion, values)[motion.valid] for motion in motions])
    mean, rms = float(np.mean(sums)), float(np.sqrt(np.mean(sums**2)))
    blocks = np.array([np.mean(part) for part in np.array_split(sums, 10)])
    std = float(np.std(blocks, ddof=1) / np.sqrt(blocks.size))
    noise = motions[0].smooth[0] * float(np.hypot(motions[0].noise["pressure_1"], motions[0].noise["pressure_2"]))
    left = float(np.std(sums))
    if left > (1.0 - OFFSET_SHARE) * rms or abs(mean) < OFFSET_SURE * max(noise, std):
        return None
    return FoundEffect(
        "pressure_sensor_offset",
        "sensor",
        {"pressure_1_offset": Estimate(mean, max(std, noise / 10.0))},
        [],
        Evidence(sum_rms=rms, left_rms=left),
    )


def _pressure_sum(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """P_1 + P_2 - P_s - P_T (Pa): 0 for a valve of matched edges and equal areas."""
    total = motion.channels["pressure_1"] + motion.channels["pressure_2"]
    return np.asarray(total - values["supply_pressure"] - values["tank_pressure"])


def effects_of_result(result: BalanceResult) -> list[FoundEffect]:
    """The effects of a balance in the order in which they were added, with their numbers."""
    before, after, balance = result.before, result.after, result.balance
    share = 1.0 - after.rms / before.rms
    found = []
    for effect, names in result.effects.items():
        together = _speed_and_pressure(balance.motions) if effect == "pressure_dependent_friction" else None
        found.append(
            FoundEffect(
                effect,
                registered()[effect].balance,
                _estimates(after, names),
                list(result.alternatives.get(effect, [])),
                Evidence(share, stands_out(result.gains.get(effect, 0.0)), together),
                [*_confounded(together), *_either(names, result.otherwise.get(effect, []))],
            )
        )
    return found


def effects_of_both(effects: Sequence[FoundEffect], simulation: SimulationStage) -> list[FoundEffect]:
    """What the balances found and the simulated plant keeps, then what it adds; where it is trusted numbers and
    alternatives are its own, and it is what tells effects apart.
    """
    known = {effect.name: effect for effect in effects if effect.name not in simulation.dropped}
    own = {effect.name: effect for effect in effects_of_result(simulation.result)}
    merged = []
    for effect in {**known, **own}:
        first, second = known.get(effect), own.get(effect)
        if first is not None and simulation.curved is not None and effect in simulation.curved.effects:
            own_fit = simulation.curved.own
            merged.append(replace(first, parameters=_estimates(own_fit, simulation.curved.effects[effect])))
        elif second is None or (first is not None and not simulation.is_trusted):
            assert first is not None  # one of both has it
            merged.append(first)
        elif first is None:
            merged.append(second)
        else:
            merged.append(replace(second, evidence=first.evidence))
    return merged


def fitted_parameters(fits: Sequence[Fit], *, lacks: bool = False) -> dict[str, FittedParameter]:
    """Every fitted parameter by name; of several fits the last counts. Where something is missing (`lacks`) that
    nobody knows, what is far above its floor makes up for it.
    """
    return {
        name: FittedParameter.of(number, ended=name in fitted.bounded, far=lacks and fitted.rms > FAR)
        for fitted in fits
        for name, number in _estimates(fitted, fitted.names).items()
    }


def misled(baseline: Mapping[str, FittedParameter], final: Mapping[str, FittedParameter]) -> dict[str, FittedParameter]:
    """The baseline's parameters, doubted where the fit with effects contradicts them: they stood in for what lacked."""
    return {
        name: replace(before, doubt=MISLED)
        if before.identified and name in final and _contradict(before, final[name])
        else before
        for name, before in baseline.items()
    }


def _contradict(one: FittedParameter, other: FittedParameter) -> bool:
    return other.identified and abs(one.value - other.value) > CONTRADICTS * math.hypot(one.std, other.std)


def _estimates(fitted: Fit, names: Sequence[str]) -> dict[str, Estimate]:
    return {name: Estimate(fitted.values[name], fitted.deviations[name]) for name in names}


def _confounded(together: float | None) -> list[str]:
    """What a reader has to know of an effect of the pressure, whose correlation with the speed is `together`."""
    if together is None or abs(together) <= CONFOUNDED:
        return []
    word = "falls" if together < 0.0 else "rises"
    return [
        f"where the machine moves its speed {word} with the pressure (correlation {together:.2f}): what is said to "
        "depend on pressure may in part depend on speed; records at one pressure and several speeds would tell"
    ]


def _either(names: Sequence[str], otherwise: Sequence[Sequence[str]]) -> list[str]:
    """What a reader has to know of an effect whose `names` are free where others of its numbers do as well."""
    if not otherwise:
        return []
    others = " or ".join(" with ".join(one) for one in otherwise)
    return [f"{others} in the place of {' with '.join(names)} would leave as little: the records do not tell which"]


def _speed_and_pressure(motions: Sequence[Motion]) -> float:
    """Correlation between |v| and |P_L| where something moves."""
    moving = [motion.valid & ~motion.resting for motion in motions]
    speed = np.concatenate([np.abs(motion.velocity)[at] for motion, at in zip(motions, moving, strict=True)])
    pressure = np.concatenate([np.abs(load_pressure(motion))[at] for motion, at in zip(motions, moving, strict=True)])
    return float(np.corrcoef(speed, pressure)[0, 1])
