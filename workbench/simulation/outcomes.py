"""What happened in a run, in words: the first that applies of what keeps its numbers from meaning what they seem to."""

import numpy as np

from plants.equation import fields
from plants.hydraulics import Hydraulic
from plants.motor import Motor
from workbench.simulation.motor_limits import at_a_limit
from workbench.simulation.run import COMPLETED, HARDLY_MOVES, STUCK_SPEED, TORQUE_LIMITED, Run

LIMITED_SHARE = 0.05
"""Of the run. A rod that comes to speed from standstill takes some tens of milliseconds at the limit, and so does a
step's reversal; beyond a twentieth of the run it is the motor that says how the rod turns, not the command."""

VACUUM = -101325.0
"""Pa over the ambient pressure, of which pressures of oil are counted."""


def outcome_of(run: Run, limit: float) -> str:
    """What happened in a run to its end, in words; the first that applies."""
    position = run.state("position")
    if max(-position.min(), position.max()) > 0.5 * run.plant.travel(run.parameters):
        return "end stop"
    if abs(run.command[0]) >= limit and np.all(np.abs(run.command) >= limit):
        return "saturated throughout"
    if run.reference is not None:
        asked, velocity = run.reference[0], run.state("velocity")
        if max(-velocity.min(), velocity.max()) < STUCK_SPEED and _range(asked) > 0.0:
            return "stuck"
        if _hardly_moves(asked, position):
            return "hardly moves"
    if _cavitates(run):
        return "cavitates"
    return TORQUE_LIMITED if _torque_limited(run) else COMPLETED


def _cavitates(run: Run) -> bool:
    """Whether the oil of a chamber is pulled below vacuum: no oil is, and no plant here knows of its vapour."""
    states = {item.name for item in fields(run.plant.State)}
    if "pressure_1" not in states and not run.plant.effects:
        return False  # both are between tank and supply by its equations
    if not isinstance(run.parameters, Hydraulic):
        return False
    pressures = [run.state(name) if name in states else run.signals[name] for name in ("pressure_1", "pressure_2")]
    return any(np.min(pressure) < VACUUM for pressure in pressures)


def _torque_limited(run: Run) -> bool:
    """Whether a motor turns the rod and is at its limit in more than `LIMITED_SHARE` of the run."""
    motor, command = getattr(run.parameters, "motor", None), run.plant.rotary_command
    driven = "motor_current" in [item.name for item in fields(run.plant.State)]
    if command is None or not driven or not isinstance(motor, Motor):
        return False
    voltage = run.inputs[:, run.plant.input_index(command)]
    return bool(np.mean(at_a_limit(run.state("motor_current"), voltage, motor)) > LIMITED_SHARE)


def _hardly_moves(asked: np.ndarray, position: np.ndarray) -> bool:
    """Whether the position covers less than `HARDLY_MOVES` of what it is asked for (m), from its start or lately.

    The second half of the run tells of a rod that goes to where a sine begins and does not follow it.
    """
    late = asked.size // 2
    low, high, start = asked.min(), asked.max(), position[0]
    wanted = max(high - low, high - start, start - low)
    return bool(
        _range(position) < HARDLY_MOVES * wanted or _range(position[late:]) < HARDLY_MOVES * _range(asked[late:])
    )


def _range(values: np.ndarray) -> float:
    return float(values.max() - values.min())
