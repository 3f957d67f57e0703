"""Friction against velocity: the straight line through it, and the energy in its departure from a single curve."""

import numpy as np

from workbench.simulation.run import STUCK_SPEED

BINS = 60
"""Number of bins between the largest speeds in both directions; even, so that none holds both signs of velocity."""

LEAST_SAMPLES = 2
"""Samples that a bin must hold of each branch, accelerating and decelerating."""

ALIKE = 1e-12
"""Relative, squared: numbers that scatter by less are the same number."""


def line(velocity: np.ndarray, friction: np.ndarray) -> tuple[float | None, float | None]:
    """Slope b (N s/m) and R^2 of the straight line F = a + b v fitted by least squares (thesis table 3.1).

    R^2 = 1 - sum (F - a - b v)^2 / sum (F - mean F)^2. None where velocity (m/s) varies by less than `STUCK_SPEED`; R^2
    also where friction (N) is constant.
    """
    if np.ptp(velocity) < STUCK_SPEED:
        return None, None
    v, f = velocity - np.mean(velocity), friction - np.mean(friction)
    slope = float(v @ f) / float(v @ v)
    total = float(f @ f)
    residual = f - slope * v
    return slope, 1.0 - float(residual @ residual) / total if total > 0.0 else None


def hysteresis(time: np.ndarray, velocity: np.ndarray, friction: np.ndarray) -> float | None:
    """Energy (J) in the departure of friction (N) from any single-valued function of velocity (m/s).

    Over bins of equal width between -max |v| and max |v|, with an edge at 0:

        E = sum over samples of |d| |v| h,    F = c + s v + d sgn(dv/dt) in each bin, by least squares

    so that d (N) is half the difference between accelerating and decelerating friction at equal velocity. The
    slope s that both share keeps an uneven spread of the samples within a bin out of d, which is therefore 0 for
    any smooth F(v), also one that jumps at v = 0. A bin without both branches adds nothing, nor does one in which each
    branch has a speed of its own, which s may explain as well. None where nothing moves faster than `STUCK_SPEED`.
    """
    top = float(np.max(np.abs(velocity)))
    if top < STUCK_SPEED:
        return None
    moving = velocity != 0.0
    speed, force = np.abs(velocity[moving]), friction[moving]
    branch = np.where(_changes(velocity)[moving] > 0.0, 1.0, -1.0)
    width = 2.0 * top / BINS
    bins = np.minimum(np.floor((velocity[moving] + top) / width).astype(int), BINS - 1)

    def summed(values: np.ndarray) -> np.ndarray:
        return np.bincount(bins, values, BINS)

    def centred(values: np.ndarray) -> np.ndarray:
        return values - (summed(values) / np.maximum(count, 1))[bins]

    count = np.bincount(bins, minlength=BINS)
    rising = summed(branch > 0.0)
    both = np.minimum(rising, count - rising) >= LEAST_SAMPLES
    d, s, f = centred(branch), centred(speed / width), centred(force)
    dd, ds, ss = summed(d * d), summed(d * s), summed(s * s)
    free = dd * ss - ds**2  # of the normal equations; 0 where the speeds of a bin are alike, or tell its branch
    told = both & (free > ALIKE * dd * ss)
    difference = np.divide(ss * summed(d * f) - ds * summed(s * f), free, out=np.zeros(BINS), where=told)
    alike = both & (ss <= ALIKE * count)
    difference = np.divide(summed(d * f), dd, out=difference, where=alike)
    return float(np.sum(np.abs(difference) * summed(speed))) * float(time[1] - time[0])


def _changes(values: np.ndarray) -> np.ndarray:
    """From the sample before each to the one behind it; at the ends from or to the sample itself."""
    return np.concatenate([values[1:2] - values[:1], values[2:] - values[:-2], values[-1:] - values[-2:-1]])
