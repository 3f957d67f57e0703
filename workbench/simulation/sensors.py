"""What lies between the plant and its controller: filter, delay, noise, quantisation."""

from dataclasses import dataclass, field

import numpy as np

from plants.interface import Measurement


@dataclass(frozen=True)
class Channel:
    """One sensor: standard deviation of white noise a sample, and the step of its converter (0: none)."""

    noise: float = 0.0
    resolution: float = 0.0
    anti_alias: float = 0.0
    """Cutoff (Hz) of a first-order low-pass before the converter, integrated with the plant; 0: none."""


@dataclass(frozen=True)
class Sensors:
    """The sensors of a rig, by the name of what they measure; one that is not named is ideal."""

    channels: dict[str, Channel] = field(default_factory=dict)
    delay: float = 0.0
    """Age (s) of what the controller sees: any value, not only whole samples."""

    def noise(self, samples: int, seed: int) -> np.ndarray:
        """Noise to add, shape (samples, channels); each channel draws from a stream of its own."""
        noise = np.zeros((samples, len(Measurement._fields)))
        for name, channel in self.channels.items():
            if channel.noise > 0.0:
                i = Measurement._fields.index(name)
                noise[:, i] = channel.noise * np.random.default_rng([seed, i]).standard_normal(samples)
        return noise

    def resolution(self) -> np.ndarray:
        """Converter step of each channel, 0 for none."""
        return np.array([self.channels.get(name, Channel()).resolution for name in Measurement._fields])

    def cutoffs(self) -> np.ndarray:
        """Cutoff of each channel's anti-alias filter in rad/s, 0 for none."""
        hertz = [self.channels.get(name, Channel()).anti_alias for name in Measurement._fields]
        return 2.0 * np.pi * np.array(hertz)
