"""What is large on a machine, by what is declared of it and by how it moves."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from plants.axis import ROTARY as TURNING
from plants.axis import name_along
from plants.effects.scales import Scales
from plants.equation import NEGATIVE
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values

AREA, FORCE = "piston_area_1", "force"
PRESSURES = ("pressure_1", "pressure_2")
LEVELS = (("coulomb", "stribeck"), (f"coulomb_{NEGATIVE}", f"stribeck_{NEGATIVE}"))

LOAD_FRICTIONS = 10.0
"""Frictions that a machine is taken to move of which nothing tells what drives it [assumed]."""


class Moved(NamedTuple):
    """How a machine moves (SI): largest speed, way that it covers, what its acceleration varies by, how long, sampled
    how often; the largest pressure, force and command that are seen, 0 where none is.
    """

    speed: float
    way: float
    acceleration: float
    duration: float
    sample_time: float
    pressure: float = 0.0
    force: float = 0.0
    command: float = 0.0


def scales_of(motions: Sequence[Motion], values: Values) -> Scales:
    """What is large on the machine of these records."""
    return scales_from(
        Moved(
            speed=max(motion.top_speed for motion in motions),
            way=max(float(np.ptp(motion.position[motion.valid])) for motion in motions),
            acceleration=max(float(np.std(motion.acceleration)) for motion in motions),
            duration=max(float(motion.time[-1]) for motion in motions),
            sample_time=motions[0].sample_time,
            pressure=_largest(motions, PRESSURES),
            force=_largest(motions, (FORCE,)),
            command=_largest(motions, ("valve_voltage", "command")),
        ),
        values,
    )


def scales_from(moved: Moved, values: Values) -> Scales:
    """What is large on a machine that moves like this."""
    stroke = values.get("stroke", np.inf)
    static = [values.get(name, 0.0) + values.get(other, 0.0) for name, other in LEVELS]
    turning = name_along("mass", TURNING) in values
    mass = values.get("mass", values.get(name_along("mass", TURNING), 1.0))
    force = max(*static, mass * moved.acceleration)
    pressure, flow = values.get("supply_pressure", moved.pressure or 1.0), values.get(AREA, 1.0) * moved.speed
    return Scales(
        force=force,
        drive=_driving(moved, values, pressure, force),
        travel=stroke if np.isfinite(stroke) else moved.way,
        turn=2.0 * np.pi if turning else np.inf,
        speed=moved.speed,
        pressure=pressure,
        flow=flow,
        spool=values.get("spool_limit", 1.0),
        voltage=_limited(values.get("voltage_limit", np.inf), moved.command, 1.0),
        conductance=_conductance(values, flow / pressure),
        duration=moved.duration,
        sample_time=moved.sample_time,
    )


def _driving(moved: Moved, values: Values, pressure: float, force: float) -> float:
    """The largest force (N) that drives: of the pressure on a piston, of a drive's limit, of what a record shows."""
    if AREA in values:
        return pressure * max(values[AREA], values.get("piston_area_2", 0.0))
    limit = values.get("force_limit", values.get("torque_limit", np.inf))
    return max(_limited(limit, moved.force, LOAD_FRICTIONS * force), force)


def _conductance(values: Values, otherwise: float) -> float:
    """What a valve lets through at full travel over the supply's pressure (m^3/(s Pa)), or what moves the machine."""
    oil = ("valve_flow_gain", "spool_limit", "supply_pressure")
    if all(name in values for name in oil):
        gain, way, supply = (values[name] for name in oil)
        return gain * way * float(np.sqrt(0.5 * supply)) / supply
    return values.get("sonic_conductance", otherwise)


def _limited(limit: float, seen: float, otherwise: float) -> float:
    """A limit where it is known, else the largest value that is seen."""
    return limit if np.isfinite(limit) else seen or otherwise


def _largest(motions: Sequence[Motion], names: Sequence[str]) -> float:
    """The largest value of those of these channels that records have, 0 without any."""
    shown_here = [float(np.max(np.abs(each.channels[name]))) for each in motions for name in names if each.has(name)]
    return max(shown_here, default=0.0)
