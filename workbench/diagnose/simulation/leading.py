"""Loops that lead a plant along its record: what it is off by adds up, and a loop takes most of that away.

A force on the mass makes the simulated position follow the measured one, by

    F = m w^2 (x - x_s) + 2 m w (v - v_s)

with a crossover w and both velocities by the same filtered difference. How quick a loop may be is asked of the noise
of the position, of which it makes a force.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from controllers import pid
from controllers.pid import PID
from plants.axis import name_along
from workbench.diagnose.residuals.along import Along
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.null import QUICKEST, accelerated
from workbench.diagnose.residuals.unknowns import Values
from workbench.simulation.references import Moving, Signal
from workbench.simulation.setup import Loop, Setup

FILTERED, SHORTEST = 0.3, 0.05
"""Time constant of a loop's differentiator, over one over the crossover, and over the sample time at least."""

SHAKES = 0.05
"""Share of the contact's friction that a loop that leads a plant may make of the position's noise."""


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
