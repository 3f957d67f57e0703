"""Balances that no plant has: residuals that are known functions of parameters, along a motion that is made."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from plants.effects.interface import Scales
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.motion import Motion, motion_of
from workbench.records.reading import Record

SCALES = Scales(
    **{"force": 400.0, "drive": 2000.0, "travel": 0.04, "turn": np.inf, "speed": 0.06, "pressure": 3e6, "flow": 1e-4},
    **{"spool": 6e-4, "voltage": 10.0, "conductance": 1e-10, "duration": 20.0, "sample_time": 1e-3},
)

FORCE = 1.0
"""N. Standard deviation of the noise of a made balance."""

Explained = Callable[[Motion, Mapping[str, float]], np.ndarray]
"""What parameters make of a force (N) at the instants of a motion."""


def made_motion(duration: float = 20.0, travel: float = 0.04) -> Motion:
    """To and fro at 0.31 Hz over a `travel` (m), with 0.1 um of noise, at 1 kHz."""
    time = 1e-3 * np.arange(round(1e3 * duration))
    noise = 1e-7 * np.random.default_rng(1).standard_normal(time.size)
    channels = {"position": 0.5 * travel * np.sin(2.0 * np.pi * 0.31 * time) + noise}
    return motion_of(Record("made", Path("made"), "fit", 0.0, time, channels, np.ones(time.size, dtype=bool)))


def made_balance(
    motions: Sequence[Motion],
    explained: Explained,
    truth: Mapping[str, float],
    free: tuple[str, ...] = (),
    effects: tuple[str, ...] = (),
) -> Balance:
    """A force of which `explained` is linear in everything, with true parameters and white noise."""
    noise = {
        id(motion): FORCE * np.random.default_rng(place).standard_normal(motion.thinned.time.size)
        for place, motion in enumerate(motions)
    }

    def residual(motion: Motion, values: Mapping[str, float]) -> list[np.ndarray]:
        thin = motion.thinned
        return [explained(thin, truth) + noise[id(motion)] - explained(thin, values)]

    return Balance("force", motions, residual, FORCE, "N", free, SCALES, effects)


def ripple(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """A force that repeats along the way, and a load."""
    angle = 2.0 * np.pi * motion.position / values.get("cogging_pitch", 0.01)
    waves = values.get("cogging_cosine", 0.0) * np.cos(angle) + values.get("cogging_sine", 0.0) * np.sin(angle)
    return np.asarray(waves + values.get("load_force", 0.0))
