"""Friction against velocity: the straight line through it, and the energy in its departure from a single curve."""

import numpy as np

from workbench.simulation.simulate import STUCK_SPEED

BINS = 60
"""Number of bins between the largest speeds in both directions; even, so that none holds both signs of velocity."""

LEAST_SAMPLES = 2
"""Samples that a bin must hold of each branch, accelerating and decelerating."""


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
    any smooth F(v), also one that jumps at v = 0. A bin without both branches adds nothing. None where nothing
    moves faster than `STUCK_SPEED`.
    """
    top = float(np.max(np.abs(velocity)))
    if top < STUCK_SPEED:
        return None
    branch = np.where(np.gradient(velocity, time) > 0.0, 1.0, -1.0)
    width = 2.0 * top / BINS
    bins = np.minimum(np.floor((velocity + top) / width).astype(int), BINS - 1)
    energy = 0.0
    for i in np.unique(bins):
        inside = (bins == i) & (velocity != 0.0)
        sign, speed = branch[inside], np.abs(velocity[inside])
        if min(np.sum(sign > 0.0), np.sum(sign < 0.0)) < LEAST_SAMPLES:
            continue
        basis = np.column_stack([sign, np.ones_like(sign), (speed - np.mean(speed)) / width])
        difference = np.linalg.lstsq(basis, friction[inside], rcond=None)[0][0]
        energy += abs(float(difference)) * float(np.sum(speed))
    return energy * float(time[1] - time[0])
