"""The operating point of a loop: the rod sliding at a constant speed, as the loop itself moves it.

At rest LuGre's bristles are a spring and a closed spool is a kink, so that a loop linearised there says nothing about
motion. Sliding, friction has its slope over speed, and the valve the gain that the load pressure leaves it.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plants.equation import fields, from_array, to_array
from workbench.errors import UserError
from workbench.simulation.references import Ramp
from workbench.simulation.run import Run
from workbench.simulation.sensors import Sensors
from workbench.simulation.setup import Setup
from workbench.simulation.simulate import simulate

DURATIONS = (1.0, 4.0, 16.0)
"""s. How long the rod slides: the next where it is not yet steady."""

TOLERANCE = 0.02
"""Share of the speed by which the velocity of a steady slide may swing, and be off, over the last quarter."""

SUSTAINED = 0.9
"""A swing that from the third quarter to the last does not shrink below this share of itself goes on."""

USED_TRAVEL = 0.9
"""Share of the travel that a slide may take, where a plant keeps its end stops."""

CROSSINGS = 8
"""Of its mean by the velocity in a quarter: with fewer, what looks like an oscillation may be the start."""

OSCILLATES = "the velocity keeps oscillating"
END_STOP = "end_stop_stiffness"
"""The parameter by which the plants have end stops; one that has others keeps them, and its slide keeps clear."""

FORCED_PERIODS = 10
"""Periods of a controller's own shaking over which the operating point is averaged."""


@dataclass(frozen=True)
class OperatingPoint:
    """Where a loop is linearised: numbers of one sample, SI.

    `memory` is the controller's state before its step, `reference` and `measurement` what the step then sees. `reach`
    holds the largest magnitude of each of memory and measurement on the way: its scale. `trouble` says in words why
    the loop is not steady, "" where it is.
    """

    state: Any
    inputs: Any
    memory: np.ndarray
    reference: np.ndarray
    measurement: np.ndarray
    reach: tuple[np.ndarray, np.ndarray]
    trouble: str


def slide(setup: Setup, speed: float) -> OperatingPoint:
    """Simulate the loop of `setup` along a ramp until the rod slides steadily, and take the last sample.

    The ramp ends where `setup` starts, so its start is retracted by its length. Sensors are ideal, nothing is fed to
    inputs, end stops do not act. A rotating plant keeps what turns it.

    A controller that shakes the plant on purpose (`forcing`) is judged by, and linearised at, the mean over ten periods
    of its shaking: of plant and controller alike, so that both belong to one motion. What shaking does to friction (it
    smooths the curve) is not in such a linearisation beyond the shift of that mean.

    Args:
        speed: of the reference (m/s), either direction, not 0.

    Raises:
        UserError: a speed of 0.
    """
    if not np.isfinite(speed) or speed == 0.0:
        raise UserError(
            f"speed is {speed:g} {setup.plant.axis}/s, expected one that slides: at rest a loop with friction has no "
            "margins"
        )
    setup, window = without_end_stops(replace(setup, feeds=(), sensors=Sensors())), _window(setup)
    longest = USED_TRAVEL * float(setup.plant.travel(setup.parameters)) / abs(speed)
    for duration in DURATIONS:
        run = simulate(along_ramp(setup, speed, min(duration, longest)))
        trouble = _trouble(run, speed, window)
        if not trouble or trouble == OSCILLATES or run.diverged or duration >= longest:
            break
    return _taken(run, window, trouble)


def without_end_stops(setup: Setup) -> Setup:
    """The setup of a plant whose end stops do not act, so that a slide may be as long as it takes."""
    names = [item.name for item in fields(setup.plant.Parameters)]
    numbers = to_array(setup.parameters)
    if END_STOP in names:
        numbers[names.index(END_STOP)] = 0.0
    parameters = from_array(setup.plant.Parameters, numbers.tolist())
    return replace(setup, parameters=parameters)


def along_ramp(setup: Setup, speed: float, duration: float) -> Setup:
    """The setup with a ramp of that speed (m/s) and duration (s) that ends where `setup` starts."""
    start = setup.state.position - speed * duration
    state = setup.state._replace(position=start)
    return replace(setup, state=state, duration=duration, reference=Ramp(speed, offset=start))


def _window(setup: Setup) -> int:
    """Samples to average over: one, or whole periods of the controller's own shaking."""
    controller, gains = setup.loop.controller, setup.loop.gains
    frequency = controller.forcing(gains) if controller.forcing is not None else 0.0
    return max(1, round(FORCED_PERIODS / (frequency * setup.sample_time))) if frequency > 0.0 else 1


def _trouble(run: Run, speed: float, window: int) -> str:
    """Why the run is not steady over its last quarter; "" where it is."""
    if run.diverged:
        return f"the loop diverges ({run.outcome})"
    velocity, command = _mean_over(run.state("velocity"), window), _mean_over(run.command, window)
    quarter = velocity.size // 4
    before, last = velocity[-2 * quarter : -quarter], velocity[-quarter:]
    if np.all(np.abs(command[-quarter:]) >= run.plant.command_limit(run.parameters)):
        return "the command is at the amplifier's limit"
    if np.ptp(last) > TOLERANCE * abs(speed):
        crossings = np.sum(np.diff(np.sign(last - np.mean(last))) != 0.0)
        lasting = crossings >= CROSSINGS and np.ptp(last) > SUSTAINED * np.ptp(before)
        return OSCILLATES if lasting else f"the rod does not slide steadily within {run.time[-1]:.3g} s"
    if np.max(np.abs(last - speed)) > TOLERANCE * abs(speed):
        unit = f"{run.plant.axis}/s"
        return f"the rod moves at {np.mean(last):.3g} {unit} in place of {speed:.3g} {unit}"
    return ""


def _mean_over(values: np.ndarray, window: int) -> np.ndarray:
    """Running mean over `window` samples (fewer where there are fewer)."""
    window = min(window, values.size)
    total = np.concatenate([[0.0], np.cumsum(values)])
    return (total[window:] - total[:-window]) / window


def _taken(run: Run, window: int, trouble: str) -> OperatingPoint:
    """The last sample, or the mean over the last `window`."""
    assert run.reference is not None  # every slide has one
    chosen = slice(max(run.time.size - window, 1), None)
    before = slice(chosen.start - 1, -1)
    reference = np.array([np.mean(item[chosen]) for item in run.reference])
    state, inputs, measurement = (
        np.mean(table[chosen], axis=0) for table in (run.states, run.inputs, run.measurements)
    )
    return OperatingPoint(
        from_array(run.plant.State, state.tolist()),
        from_array(run.plant.Inputs, inputs.tolist()),
        np.mean(run.memory[before], axis=0),
        reference,
        measurement,
        (np.max(np.abs(run.memory), axis=0), np.max(np.abs(run.measurements), axis=0)),
        trouble,
    )
