"""A plant beside a record of which a sensor shows what drives it.

What a computer commands is known, and the plant is driven by it alone. A force that a sensor shows has noise, which a
mass integrates twice: of such records what tells is by how much the plant fails to foresee the next position, kept
beside those before it (prediction errors: Ljung 1999, sections 3 and 7). The gains are those of a Kalman filter that
knows the noise of both sensors, of a mass alone:

    u = m (w^2 e + sqrt(2) w de/dt),  w^2 = s_F / (m s_x)

Every sample is foreseen (`as_simulated`). The rate is filtered: what a loop makes of noise would shake the contact
loose as a dither does.
How a contact is bent that rests is a matter of noise, which no position before it tells: a rest says nothing.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from controllers import pid
from controllers.pid import PID
from plants.axis import name_along
from workbench.diagnose.residuals.along import Along
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.null import QUICKEST, accelerated, tracking
from workbench.diagnose.residuals.shown import given_by
from workbench.diagnose.residuals.unknowns import Values
from workbench.simulation.references import Moving, Signal
from workbench.simulation.setup import Loop, Setup

FILTERED, SHORTEST = 0.3, 0.05
"""Time constant of a loop's differentiator, over one over the crossover, and over the sample time at least."""

DAMPING = 2.0**-0.5
"""Of a Kalman filter of a mass, whose velocity noise drives."""

SLOWEST = 20.0
"""Least crossover of a loop that keeps a plant beside a record, over one over the record's duration."""

UNDER_WAY = 0.2
"""Share of the velocity's rms below which a rod is not under way."""

SHAKES = 0.05
"""Share of the contact's friction that a loop that leads a plant may make of the position's noise."""

PASSING, FORGOTTEN = 10.0, 6.0
"""Times one over the crossover in which a rod that turns back is under way again, till when noise has not done much;
and after which the loop has forgotten how a rest ended.
"""


@dataclass(frozen=True, eq=False)
class Shown(Moving):
    """A measured position, with its velocity as the loop finds that of the simulated one."""

    times: np.ndarray
    values: np.ndarray
    time_constant: float

    def __call__(self, time: np.ndarray) -> Signal:
        position = np.interp(time, self.times, self.values)
        step = float(time[1] - time[0]) if time.size > 1 else 1.0
        keep = float(np.exp(-step / self.time_constant))
        velocity = lfilter([(1.0 - keep) / step], [1.0, -keep], np.diff(position, prepend=position[:1]))
        return position, velocity, np.zeros(time.size)


@dataclass(frozen=True, eq=False)
class Followed(Shown):
    """The same for a loop of a `crossover` (rad/s) that keeps a plant beside a record."""

    crossover: float

    def since(self, time: float) -> "Followed":
        """The same from a time (s) on."""
        return replace(self, times=self.times - time)


def kept_beside(setup: Setup, along: Along, motion: Motion, values: Values) -> Setup:
    """The setup with a loop by which a plant with `values` foresees each position of the record from those before."""
    state, inputs = along.at_rest(motion, values)
    parameters, step = along.parameters(values), motion.record.sample_time
    unit = tracking(along, parameters, state, inputs, 1.0)  # its gain is the mass, in units of the command
    noise = {name: max(motion.sensed[name], 1e-30) for name in ("force", "position")}
    crossover = float(np.sqrt(noise["force"] / (unit.kp * noise["position"])))
    crossover = float(np.clip(crossover, SLOWEST / float(motion.record.time[-1]), QUICKEST / step))
    lag = max(FILTERED / crossover, SHORTEST * step)
    gains = unit.kp * crossover**2, DAMPING * unit.kd * crossover
    settings = pid.Settings(kp=gains[0], kd=gains[1], velocity_time_constant=lag)
    known = np.isfinite(motion.record.channels["position"])
    reference = Followed(motion.record.time[known], motion.record.channels["position"][known], lag, crossover)
    return replace(setup, loop=Loop(PID, PID.design(settings, parameters, step)), reference=reference)


def quickest(along: Along, motion: Motion, values: Values) -> float:
    """rad/s: the quickest loop that may lead a plant along a record: quicker ones make a force of the position's noise
    that shakes a contact loose, of 2 w^2 m s_x over the share of the differentiator's lag.
    """
    noise = 2.0 * max(motion.sensed["position"], 1e-30) / FILTERED / abs(_accelerated(along, motion, values))
    coulomb = values.get(name_along("coulomb", along.plant.axis), 0.0)
    fastest = QUICKEST / motion.record.sample_time
    return min(fastest, float(np.sqrt(SHAKES * coulomb / noise))) if coulomb > 0.0 else fastest


def led(setup: Setup, along: Along, motion: Motion, values: Values, crossover: float) -> Setup:
    """The setup with a loop (rad/s) that leads a plant with `values` along the record, by a force on its mass."""
    step, push = motion.record.sample_time, _accelerated(along, motion, values)
    lag = max(FILTERED / crossover, SHORTEST * step)
    settings = pid.Settings(kp=crossover**2 / push, kd=2.0 * crossover / push, velocity_time_constant=lag)
    known = np.isfinite(motion.record.channels["position"])
    reference = Shown(motion.record.time[known], motion.record.channels["position"][known], lag)
    loop = Loop(PID, PID.design(settings, along.parameters(values), step), along.plant.disturbance)
    return replace(setup, loop=loop, reference=reference)


def _accelerated(along: Along, motion: Motion, values: Values) -> float:
    """What a unit of the disturbance adds to the acceleration."""
    state, inputs = along.at_rest(motion, values)
    return accelerated(along, along.parameters(values), state, inputs, along.plant.disturbance)


def is_sensed(along: Along, motion: Motion) -> bool:
    """Whether it is a sensor of force alone that shows what drives the plant."""
    channels = motion.record.channels
    return given_by(channels, along.plant.command) == ("force",) and "pressure_1" not in channels


def held(motion: Motion, crossover: float) -> np.ndarray:
    """Where the rod rests or creeps for longer than it takes to turn back, or just did; and where it moves for a moment
    between two rests.
    """
    slow = np.abs(motion.velocity) < UNDER_WAY * float(np.sqrt(np.mean(motion.velocity**2)))
    resting = np.zeros_like(slow)
    passing, forgotten = (int(times / crossover / motion.sample_time) for times in (PASSING, FORGOTTEN))
    for start, end in _stretches(slow):
        if end - start > passing:
            resting[start : end + forgotten] = True
    for start, end in _stretches(~resting):
        if end - start < passing:
            resting[start:end] = True
    return resting


def _stretches(true: np.ndarray) -> list[tuple[int, int]]:
    """Where something is true from one place to before another."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], true, [0]])))
    return [(int(start), int(end)) for start, end in edges.reshape(-1, 2)]
