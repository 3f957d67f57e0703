"""What lies between the plant and its controller: filter, delay, systematic error, noise, quantisation."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plants.interface import Measurement

HARMONICS = 4
"""Waves of a calibration curve, from one to this many periods over its travel: an error that varies slowly."""

PEAK_POINTS = 4001
"""Points over the travel at which a calibration curve's peak is sought; the peak is right to 1e-5 of itself."""

CALIBRATION_STREAM = 1
"""Apart from the noise's stream, so that a calibration curve changes no noise."""

ERROR_NUMBERS = 2 + 3 * HARMONICS
"""Numbers that describe a channel's systematic error, in the order of `systematic_error`."""


def systematic_error(value: Any, numbers: Any) -> Any:
    """Error that a sensor adds to the true `value`, in the channel's unit; it repeats whenever the value does.

        e = offset + gain_error y + sum_i a_i sin(k_i y + phase_i)

    `numbers` holds offset, gain error (1), then of each wave amplitude, wavenumber (rad over the unit) and phase (rad).
    """
    error = numbers[0] + numbers[1] * value
    if numbers[2] != 0.0:
        for i in range(HARMONICS):
            error += numbers[2 + 3 * i] * np.sin(numbers[3 + 3 * i] * value + numbers[4 + 3 * i])
    return error


@dataclass(frozen=True)
class Channel:
    """One sensor, in the unit of what it measures; all of it 0: ideal."""

    noise: float = 0.0
    """Standard deviation of white noise a sample."""
    resolution: float = 0.0
    """Step of the converter."""
    anti_alias: float = 0.0
    """Cutoff (Hz) of a first-order low-pass before the converter, integrated with the plant."""
    offset: float = 0.0
    gain_error: float = 0.0
    """Relative: a reading of (1 + gain_error) y."""
    calibration_error: float = 0.0
    """Peak of a smooth error over the measured value itself: what a calibration leaves."""
    calibration_travel: float = 0.0
    """Range of the value, centred at 0, over which the curve is made and has its peak; it repeats beyond."""
    calibration_seed: int = 1
    """Which curve: apart from the run's seed, since repeats on one rig have one sensor."""

    def error_numbers(self, place: int) -> np.ndarray:
        """Numbers for `systematic_error`, shape (ERROR_NUMBERS,).

        The calibration curve is a sum of waves with 1 to `HARMONICS` periods over the travel, amplitudes falling as
        1 / period count, random phases, scaled to the peak. A sensor's residual after calibration is known by its peak
        and as slowly varying, no more: the form is this program's. `place` is the channel's among those of the rig.
        """
        numbers = np.zeros(ERROR_NUMBERS)
        numbers[:2] = self.offset, self.gain_error
        if self.calibration_error > 0.0:
            periods = np.arange(1, HARMONICS + 1)
            numbers[2::3] = 1.0 / periods
            numbers[3::3] = 2.0 * np.pi * periods / self.calibration_travel
            numbers[4::3] = np.random.default_rng((self.calibration_seed, place, CALIBRATION_STREAM)).uniform(
                0.0, 2.0 * np.pi, HARMONICS
            )
            travel = np.linspace(-0.5, 0.5, PEAK_POINTS) * self.calibration_travel
            waves = systematic_error(travel, np.concatenate([[0.0, 0.0], numbers[2:]]))
            numbers[2::3] *= self.calibration_error / np.max(np.abs(waves))
        return numbers


@dataclass(frozen=True)
class Sensors:
    """The sensors of a rig, by the name of what they measure; one that is not named is ideal."""

    channels: dict[str, Channel] = field(default_factory=dict)
    delay: float = 0.0
    """Age (s) of what the controller sees: any value, not only whole samples."""

    def noise(self, samples: int, seed: int) -> np.ndarray:
        """Noise to add, shape (samples, channels), no rows without any; each channel draws from a stream of its own."""
        noisy = any(channel.noise > 0.0 for channel in self.channels.values())
        noise = np.zeros((samples if noisy else 0, len(Measurement._fields)))
        for name, channel in self.channels.items():
            if channel.noise > 0.0:
                i = Measurement._fields.index(name)
                noise[:, i] = channel.noise * np.random.default_rng([seed, i]).standard_normal(samples)
        return noise

    def errors(self) -> np.ndarray:
        """Numbers for `systematic_error` of each channel, shape (channels, ERROR_NUMBERS)."""
        errors = np.zeros((len(Measurement._fields), ERROR_NUMBERS))
        for name, channel in self.channels.items():
            i = Measurement._fields.index(name)
            errors[i] = channel.error_numbers(i)
        return errors

    def resolution(self) -> np.ndarray:
        """Converter step of each channel, 0 for none."""
        return self._of_channels({name: channel.resolution for name, channel in self.channels.items()})

    def cutoffs(self) -> np.ndarray:
        """Cutoff of each channel's anti-alias filter in rad/s, 0 for none."""
        return 2.0 * np.pi * self._of_channels({name: channel.anti_alias for name, channel in self.channels.items()})

    @staticmethod
    def _of_channels(values: dict[str, float]) -> np.ndarray:
        """A number of each channel, 0 where none is said, shape (channels,)."""
        return np.array([values.get(name, 0.0) for name in Measurement._fields])
