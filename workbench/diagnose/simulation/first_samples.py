"""Where a record begins, by its first samples: smoothing has nothing before them, and bends what begins quickly.

    v_0 = 1.5 s_1 - 0.5 s_2,   s_1 = (x_n - x_0) / (n h),   s_2 = (x_2n - x_n) / (n h)

is exact for a constant acceleration. Noise of x makes of it sqrt(6.5) s_x / (n h); that acceleration which changes
makes, is taken to be what the slopes differ by. The number of samples n is that for which both together are least.
"""

import numpy as np

from workbench.diagnose.residuals.motion import Motion, window_points


def sensed_at_first(motion: Motion) -> tuple[float, float]:
    """Position (m) and velocity (m/s) at a record's first sample."""
    position, step, noise = motion.measured["position"], motion.sample_time, motion.sensed["position"]
    most = min(window_points(step), position.size // 2 - 1)
    points = np.arange(1, most + 1)
    first, second = position[points] - position[0], position[2 * points] - position[points]
    off = np.sqrt(6.5) * noise + np.abs(second - first)
    best = int(np.argmin(off / points))
    return float(position[0]), float((1.5 * first[best] - 0.5 * second[best]) / (points[best] * step))
