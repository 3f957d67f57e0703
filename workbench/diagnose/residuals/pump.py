"""The flow of a pump without a valve: known while its speed is steady."""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from workbench.diagnose.residuals.motion import Motion

SPEED = "pump_speed"
"""The channel, and the input, of the pump's speed."""

PLATEAU = 0.3
"""s over which a pump's speed has to be steady."""

LEAST = 3
"""Samples of that time at least."""

STEADY = 0.08
"""Share of its largest speed by which it may vary over that time."""


def on_plateau(motion: Motion) -> np.ndarray:
    """Where the pump's speed is steady. While it runs up, what fills lines and turns valves is no flow of the balance:
    fitted with that, the displacement of a measured pump comes out 9 % too small.
    """
    speed, points = motion.channels[SPEED], max(round(PLATEAU / motion.sample_time), LEAST)
    span = maximum_filter1d(speed, points) - minimum_filter1d(speed, points)
    return np.asarray(span < STEADY * np.max(np.abs(speed)))


def plateau_means(motion: Motion, flow_residual: np.ndarray, displacement: float) -> np.ndarray:
    """Error of the pump's speed (rad/s) on plateaus while it turns, the mean of each piece of `PLATEAU`: what its flow
    balance (m^3/s) leaves over its displacement (m^3/rad), without the pump's ripple.
    """
    speed = np.abs(motion.channels[SPEED])
    counts = motion.valid & on_plateau(motion) & (speed > STEADY * np.max(speed))
    error = flow_residual / displacement
    points = max(round(PLATEAU / motion.sample_time), LEAST)
    pieces = [slice(start, start + points) for start in range(0, speed.size - points + 1, points)]
    return np.array([np.mean(error[piece]) for piece in pieces if np.all(counts[piece])])


def rms_of(errors: Sequence[np.ndarray]) -> float | None:
    """Rms of all pieces; None where no plateau is long enough for one."""
    together = np.concatenate(errors)
    return float(np.sqrt(np.mean(together**2))) if together.size else None
