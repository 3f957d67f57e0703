"""What a converter that counts in coarse steps leaves of a position that rests.

The mean of what it gives for a value x and noise with the standard deviation s is off by (Widrow, Kollar 2008,
section 4.5; q is its step)

    q / pi sum_k (-1)^k / k exp(-2 (pi k s / q)^2) sin(2 pi k x / q).

What moves over many steps averages that out. Where something rests it stays, however many samples there are: it is no
noise whose colour could be known, and an error that repeats along the way would be found in it. How large it is the
noise decides, and where it is 0 the converter: cosines and sines of each k say nothing of the plant.
"""

import numpy as np

from workbench.diagnose.residuals.motion import UNIFORM, Motion, converter_step

HARMONICS = 3
"""Of the error over a step: what is left of the others is little, but for noise that is hardly there."""

FINE = 0.5
"""Standard deviations of noise in a converter's step from which on noise makes a straight line of the steps: what they
are off by is then at most exp(-2 (pi / 2)^2) / pi = 0.2 % of one."""


def is_coarse(motion: Motion, channel: str) -> bool:
    """Whether a channel's converter counts in steps that its noise does not make a straight line of."""
    step = converter_step(motion.record.channels[channel])
    return motion.sensed[channel] < step * float(np.hypot(FINE, UNIFORM))


def over_steps(motion: Motion, channel: str, values: np.ndarray) -> np.ndarray:
    """Cosines and sines of what was simulated in place of a channel, at every sample, over its converter's step:
    shape (samples, 2 `HARMONICS`).
    """
    angle = 2.0 * np.pi * values / converter_step(motion.record.channels[channel])
    return np.column_stack([wave(k * angle) for k in range(1, HARMONICS + 1) for wave in (np.cos, np.sin)])
