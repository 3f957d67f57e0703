"""The force balance: what drives the mass less what moves it, with the bristle simulated along the measured motion."""

from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np

from plants import effects as fx
from plants.compiled import njit
from plants.effects import FrictionEffects
from plants.friction import Friction
from plants.hydraulics import Mass
from plants.two_chamber import friction_rates
from workbench.diagnose.residuals.motion import Motion, load_pressure, with_backlash
from workbench.parameters.sets import build

UNBOUNDED_STROKE = 1e3
"""m. In the place of a stroke that is not known: no friction depends on the position then."""


class ForceParameters(NamedTuple):
    """All that the force balance depends on beside what drives the mass."""

    body: Mass
    friction: Friction
    friction_effects: FrictionEffects
    stroke: Annotated[float, "m"] = UNBOUNDED_STROKE


@njit(cache=True)
def friction_along(
    time: Any,
    position: Any,
    velocity: Any,
    creep: float,
    resting: Any,
    held: Any,
    load_pressure: Any,
    friction: Any,
    effects: Any,
    stroke: float,
    sample_time: float,
) -> Any:
    """Friction (N) along a motion; bristle, memory and rest advance by the exact solution for a velocity that is held.

    Below `creep` (m/s) a velocity is noise, and the bristle slips only at its full deflection. While the contact is
    `resting` friction is what holds it: `held` (N). The bristle is bent by that, and starts from there: simulated
    from a velocity that is noise it would relax as if it crept.
    """
    out = np.empty(time.size)
    bristle, lagged, rested = 0.0, velocity[0], 1.0 if abs(velocity[0]) <= creep else 0.0
    stiffness = friction.positive.bristle_stiffness
    for k in range(time.size):
        v = velocity[k]
        force, relaxation, rate, most = friction_rates(
            position[k],
            v,
            abs(v) if abs(v) > creep else 0.0,
            load_pressure[k],
            time[k],
            bristle,
            lagged,
            rested,
            stroke,
            friction,
            effects,
        )
        if resting[k]:
            out[k] = held[k]
            bristle = min(max(held[k] / stiffness, -most), most)
        else:
            out[k] = force
            decay = relaxation * sample_time
            bristle += rate * (sample_time if decay < 1e-9 else -np.expm1(-decay) / relaxation)
            if abs(v) <= creep:
                bristle = min(max(bristle, -most), most)
        if effects.memory_time > 0.0:
            lagged += (v - lagged) * -np.expm1(-sample_time / effects.memory_time)
        aging = 1.0 / effects.static_rise_time + abs(relaxation * bristle) / effects.static_rise_distance
        rested += (1.0 / (effects.static_rise_time * aging) - rested) * -np.expm1(-aging * sample_time)
    return out


def force_residual(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """Driving force less M a, friction and what else opposes the motion (N); 0 where the contact rests.

    Raises:
        ValueError: the record holds no driving force.
    """
    motion = with_backlash(motion, values.get("backlash_width", 0.0))
    driving = driving_force(motion, values)
    if driving is None:
        raise ValueError("a record without a driving force has no force balance")
    p = build(ForceParameters, values)
    angle = motion.channels.get("rotation_angle", np.zeros(motion.time.size))
    added = fx.added_force(motion.position, motion.velocity, angle, p.friction_effects)
    held = driving - p.body.mass * motion.acceleration - added - p.body.load_force
    friction = friction_along(
        motion.time,
        motion.position,
        motion.velocity,
        motion.creep,
        motion.resting,
        held,
        load_pressure(motion),
        p.friction,
        p.friction_effects,
        p.stroke if np.isfinite(p.stroke) else UNBOUNDED_STROKE,
        motion.sample_time,
    )
    return np.asarray(held - friction)


def driving_force(motion: Motion, values: Mapping[str, float]) -> np.ndarray | None:
    """What drives the mass (N): a measured force, the pressures on their areas, or a drive's command; None
    without any.

    Beside a force one pressure alone drives too, on `piston_area_1` if that is declared: the force is the rod's then.
    """
    channels = motion.channels
    if "force" in channels:
        if motion.has("pressure_1") and not motion.has("pressure_2") and "piston_area_1" in values:
            return np.asarray(channels["force"] + channels["pressure_1"] * values["piston_area_1"])
        return channels["force"]
    if motion.has("pressure_1", "pressure_2") and "piston_area_1" in values:
        area_2 = values["piston_area_2"] * values.get("area_ratio", 1.0)
        pressure_1 = channels["pressure_1"] - values.get("pressure_1_offset", 0.0)
        return np.asarray(pressure_1 * values["piston_area_1"] - channels["pressure_2"] * area_2)
    if "command" in channels:
        return np.asarray(values.get("force_gain", 1.0) * channels["command"])
    return None


def force_noise(motion: Motion, values: Mapping[str, float]) -> float:
    """Standard deviation (N) that the sensors' noise alone leaves in the residual, to first order in it."""
    flat, slope, bend = motion.smooth
    parts = [values.get("mass", 0.0) * bend * motion.noise.get("position", 0.0)]
    parts.append(values.get("viscous", 0.0) * slope * motion.noise.get("position", 0.0))
    if "force" in motion.channels:
        parts.append(flat * motion.noise["force"])
        if "pressure_1" in motion.channels:
            parts.append(flat * values.get("piston_area_1", 0.0) * motion.noise["pressure_1"])
    elif motion.has("pressure_1", "pressure_2"):
        parts += [flat * values[f"piston_area_{i}"] * motion.noise[f"pressure_{i}"] for i in (1, 2)]
    elif "command" in motion.channels:
        parts.append(flat * values.get("force_gain", 1.0) * motion.noise["command"])
    return float(np.linalg.norm(parts))
