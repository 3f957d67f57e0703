"""Averages and velocities of a record, as the thesis takes them (chapter 4)."""

import numpy as np

from controllers.velocity import fir_differentiator


def averaged(values: np.ndarray, count: int) -> np.ndarray:
    """Means of `count` samples on end, shape (size // count,); a mean over a gap (NaN) is NaN. The rest is dropped.

    The mean belongs to the middle of its samples: average the time as well.
    """
    whole = values.size // count * count
    return np.asarray(values[:whole].reshape(-1, count).mean(axis=1))


def velocity_of(position: np.ndarray, sample_time: float, order: int = 16) -> np.ndarray:
    """Velocity (m/s) of positions (m) by the thesis's non-causal FIR filter; NaN where its window is not whole."""
    if position.size <= order:
        return np.full(position.size, np.nan)
    velocity = fir_differentiator(position, sample_time, order)
    half = order // 2
    velocity[:half] = velocity[velocity.size - half :] = np.nan
    return velocity
