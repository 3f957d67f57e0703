"""The balances that a record's channels allow, each with its floor and with what may be fitted on it."""

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import numpy as np
from plants.effect_list import EFFECTS

from plants.equation import NEGATIVE, fields
from workbench.diagnose.residuals import flow, force
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.motion import Motion
from workbench.parameters.sets import EITHER_SIGN

FRICTION = ("coulomb", "stribeck", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping")
FLOW = ("valve_flow_gain", "bulk_modulus")
PUMP = ("pump_displacement",)
"""What the baseline may move on each balance where an experiment does not say."""

PUMP_EFFECTS = ("unequal_areas", "internal_leakage")
"""What a pump without a valve may have that shows while its speed is steady."""

FORCE = {item.name for item in fields(force.ForceParameters)} - {"stroke"} | {"force_gain", "piston_area_1"}
"""What it may move on the force balance where an experiment does."""


def allowed(channels: Collection[str], values: Mapping[str, float]) -> dict[str, tuple[str, ...]]:
    """The balances that these channels allow, with what the baseline may move on each where nothing is said.

    Flow before force: what is wrong with the flow disturbs the motion, not the other way round.
    """

    def has(*names: str) -> bool:
        return all(name in channels for name in names)

    found: dict[str, tuple[str, ...]] = {}
    if has("valve_voltage", "position", "pressure_1", "pressure_2") and "valve_flow_gain" in values:
        found["flow"] = FLOW
    elif has("pump_speed", "position") and "pump_displacement" in values:
        found["flow"] = PUMP
    pressures = has("pressure_1", "pressure_2") and "piston_area_1" in values
    if has("position") and (has("force") or pressures or has("command")):
        found["force"] = FRICTION
    return found


def balances_of(motions: Sequence[Motion], values: Mapping[str, float], free: Sequence[str] | None) -> list[Balance]:
    """The balances that the channels of the records allow."""
    found = []
    for name, own in allowed(motions[0].channels, values).items():
        if own is FLOW:
            found.append(
                _balance(name, motions, flow.flow_residuals, flow.flow_noise, values, own, free, "m^3/s", parts=2)
            )
        elif own is PUMP:
            found.append(_balance(name, motions, _pump, _pump_noise, values, own, free, "m^3/s", only=PUMP_EFFECTS))
        else:
            found.append(_balance(name, motions, _force, force.force_noise, values, own, free, "N", sharp=True))
    return found


def _force(motion: Motion, values: Mapping[str, float]) -> tuple[np.ndarray]:
    return (force.force_residual(motion, values),)


def _pump(motion: Motion, values: Mapping[str, float]) -> tuple[np.ndarray]:
    return (flow.pump_residual(motion, values),)


def _pump_noise(motion: Motion, values: Mapping[str, float]) -> float:
    flat, slope, _ = motion.smooth
    parts = [values["piston_area_1"] * slope * motion.noise["position"]]
    parts.append(values["pump_displacement"] * flat * motion.noise["pump_speed"])
    return float(np.linalg.norm(parts))


def _balance(
    name: str,
    motions: Sequence[Motion],
    residual: Callable[..., Any],
    noise: Callable[..., float],
    values: Mapping[str, float],
    own: Sequence[str],
    free: Sequence[str] | None,
    unit: str,
    *,
    parts: int = 1,
    sharp: bool = False,
    only: Sequence[str] = tuple(EFFECTS),
) -> Balance:
    floor = float(np.sqrt(np.mean([noise(motion, values) ** 2 for motion in motions])))
    known = own_parameters(name, own, free, values)
    kinds = ("force",) if name == "force" else ("flow", "valve")
    effects = tuple(
        effect.name
        for effect in EFFECTS.values()
        if (effect.balance in kinds or (name == "flow" and effect.name == "backlash"))
        and effect.name in only
        and motions[0].has(*effect.needs)
        and _possible(effect.numbers, values, known)
    )
    return Balance(name, motions, residual, max(floor, 1e-30), unit, tuple(known), effects, parts, sharp)


def own_parameters(
    name: str, own: Collection[str], free: Sequence[str] | None, values: Mapping[str, float]
) -> list[str]:
    """The plant's parameters that a fit of a balance may move: its `own` unless an experiment says which are `free`."""
    admitted = FORCE if name == "force" else own
    chosen = [one for one in (own if free is None else free) if one.removesuffix(f"_{NEGATIVE}") in admitted]
    return [one for one in chosen if values.get(one, 0.0) > 0.0 or one in EITHER_SIGN]


def _possible(numbers: Mapping[str, Any], values: Mapping[str, float], free: Sequence[str]) -> bool:
    """Whether the plant is declared without the effect, with what it would change, and the baseline has it not."""
    return (
        not any(name in free for name in numbers)
        and all(
            values.get(name, 0.0) in (0.0, 1.0) or name.endswith(NEGATIVE) or name == "load_force" for name in numbers
        )
        and not any(name.endswith(NEGATIVE) and name in values for name in numbers)
    )
