"""References that take a piston through all of its friction: slow and fast sines, holds and small steps."""

import numpy as np

FREQUENCIES = (0.1, 1.0)
"""Hz. Slowest and fastest sine where they run at their full pace."""

SINES = 7
FASTEST = (0.1, 0.13)
"""m/s. Range of the largest speed of a reference; the loop lags, and the piston is slower."""

SLOW_PACE = (0.1, 0.5)
"""Range of the pace of the slow passages, every other one: frequencies and speeds are that much lower there."""


def _sines(pace: np.ndarray, sample_time: float, draw: np.random.Generator) -> np.ndarray:
    """A sum of sines (m) at that pace, with a largest value of 15 to 20 mm and a largest speed drawn from `FASTEST`.

    Amplitudes go with frequency as f^-q; q is the smallest (fastest) that keeps the speed.
    """
    f = np.geomspace(*FREQUENCIES, SINES) * draw.uniform(0.9, 1.1, SINES)
    phase = draw.uniform(0.0, 2.0 * np.pi, SINES)
    weight = draw.uniform(0.5, 1.5, SINES)
    largest = draw.uniform(15e-3, 20e-3)
    fastest = draw.uniform(*FASTEST)
    phase_time = np.concatenate([[0.0], np.cumsum(pace)[:-1]]) * sample_time
    angle = 2.0 * np.pi * np.outer(phase_time, f) + phase
    for q in np.arange(-1.5, 3.0, 0.1):
        amplitude = weight * f**-q
        position = np.sin(angle) @ amplitude
        scale = largest / np.max(np.abs(position))
        speed = pace * (np.cos(angle) @ (2.0 * np.pi * f * amplitude))
        if scale * np.max(np.abs(speed)) <= fastest:
            break
    return scale * position


def make_reference(duration: float, sample_time: float, draw: np.random.Generator) -> np.ndarray:
    """Wanted position (m) at the samples: passages of sines of 3 to 6 s, fast and slow in turn, and holds between them.

    A hold lasts 1 to 3 s; in two of three a step of 0.5 to 3 mm comes in its middle and is taken back at its end. The
    first second leads from 0 to the sines.
    """
    time = np.arange(round(duration / sample_time)) * sample_time
    pace = np.ones(time.size)
    step = np.zeros(time.size)
    start, slow = 0.0, draw.random() < 0.5
    while start < duration:
        hold = start + draw.uniform(3.0, 6.0)
        end = hold + draw.uniform(1.0, 3.0)
        if slow:
            pace[(time >= start) & (time < hold)] = np.exp(draw.uniform(*np.log(SLOW_PACE)))
        pace[(time >= hold) & (time < end)] = 0.0
        if draw.random() < 2.0 / 3.0:
            size = draw.uniform(0.5e-3, 3e-3) * (1.0 if draw.random() < 0.5 else -1.0)
            step[(time >= 0.5 * (hold + end)) & (time < end)] = size
        start, slow = end, not slow
    sines = _sines(pace, sample_time, draw)
    return np.minimum(time, 1.0) * sines + step
