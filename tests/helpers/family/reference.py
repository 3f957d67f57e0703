"""What a machine is asked to do: slow and fast sums of sines, holds and small steps, scaled to its travel and speed."""

import numpy as np

PACE = 6.6
"""1/s, largest speed over largest position, at which the times below hold; they go with its inverse."""

FREQUENCIES = (0.1, 1.0)
"""Hz of the slowest and of the fastest sine where they run at their full pace."""

SINES = 7
SLOW = (0.08, 0.5)
"""Pace of the slow passages, every other one."""

PASSAGE, HOLD = (3.0, 6.0), (1.0, 3.0)
"""s."""

SHORTEST_HOLD, LONGEST_HOLD = 0.4, 4.0
"""s, whatever the machine's pace."""


def make_reference(
    samples: int, sample_time: float, travel: float, speed: float, draw: np.random.Generator
) -> np.ndarray:
    """Wanted position at the samples, within about `travel` and no faster than `speed`; it begins at 0.

    In two of three holds a step of 3 to 15 % of the travel comes in their middle and is taken back at their end.
    """
    stretch = PACE * travel / speed
    time = np.arange(samples) * sample_time
    pace, step = np.ones(samples), np.zeros(samples)
    start, slow = 0.0, draw.random() < 0.5
    while start < time[-1]:
        hold = start + draw.uniform(*PASSAGE) * stretch
        end = hold + float(np.clip(draw.uniform(*HOLD) * stretch, SHORTEST_HOLD, LONGEST_HOLD))
        if slow:
            pace[(time >= start) & (time < hold)] = np.exp(draw.uniform(*np.log(SLOW)))
        pace[(time >= hold) & (time < end)] = 0.0
        if draw.random() < 2.0 / 3.0:
            size = travel * draw.uniform(0.03, 0.15) * draw.choice([-1.0, 1.0])
            step[(time >= 0.5 * (hold + end)) & (time < end)] = size
        start, slow = end, not slow
    sines = _sines(pace, sample_time, stretch, travel, speed, draw)
    return np.minimum(time / stretch, 1.0) * sines + step


def _sines(
    pace: np.ndarray, sample_time: float, stretch: float, travel: float, speed: float, draw: np.random.Generator
) -> np.ndarray:
    """A sum of sines at that pace; amplitudes go with frequency as f^-q, q the smallest that keeps the speed."""
    f = np.geomspace(*FREQUENCIES, SINES) * draw.uniform(0.9, 1.1, SINES) / stretch
    phase = draw.uniform(0.0, 2.0 * np.pi, SINES)
    weight = draw.uniform(0.5, 1.5, SINES)
    largest, fastest = travel * draw.uniform(0.85, 1.0), speed * draw.uniform(0.85, 1.0)
    phase_time = np.concatenate([[0.0], np.cumsum(pace)[:-1]]) * sample_time
    angle = 2.0 * np.pi * np.outer(phase_time, f) + phase
    sines, cosines = np.sin(angle), np.cos(angle)
    for q in np.arange(-1.5, 3.0, 0.1):
        amplitude = weight * (f * stretch) ** -q
        position = sines @ amplitude
        scale = largest / np.max(np.abs(position))
        if scale * np.max(np.abs(pace * (cosines @ (2.0 * np.pi * f * amplitude)))) <= fastest:
            break
    return np.asarray(scale * position)
