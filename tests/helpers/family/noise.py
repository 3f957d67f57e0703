"""Noise of sensors: white, coloured, humming, quantised; and what a filter that knows it makes of a difference."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

WHITE, COLOURED, HUMMING, QUANTISED = KINDS = ("white", "coloured", "humming", "quantised")

MAINS = (50.0, 60.0)
"""Hz."""


@dataclass(frozen=True)
class Noise:
    """Noise of one channel (its unit): `white` and `coloured` standard deviations, amplitudes of a hum and of its third
    harmonic, the converter's step; `cutoff` (Hz) of the coloured part, and the mains' frequency (Hz).
    """

    white: float
    coloured: float = 0.0
    cutoff: float = 1.0
    hum: float = 0.0
    harmonic: float = 0.0
    mains: float = 50.0
    quantum: float = 0.0

    @property
    def std(self) -> float:
        """Standard deviation of all of it."""
        return float(np.hypot(self.random, np.hypot(self.hum, self.harmonic) / np.sqrt(2.0)))

    @property
    def flat(self) -> float:
        """Standard deviation of what has no memory."""
        return float(np.hypot(self.white, self.quantum / np.sqrt(12.0)))

    @property
    def random(self) -> float:
        """Standard deviation of what cannot be predicted for ever."""
        return float(np.hypot(self.flat, self.coloured))

    def drawn(self, samples: int, sample_time: float, draw: np.random.Generator) -> np.ndarray:
        """The noise before the converter, shape (samples,)."""
        values = self.white * draw.standard_normal(samples)
        if self.coloured:
            phi = self.kept(sample_time)
            made = draw.standard_normal(samples) * np.sqrt(1.0 - phi**2)
            made[0] /= np.sqrt(1.0 - phi**2)
            values += self.coloured * lfilter([1.0], [1.0, -phi], made)
        if self.hum:
            angle = 2.0 * np.pi * self.mains * np.arange(samples) * sample_time
            first, third = draw.uniform(0.0, 2.0 * np.pi, 2)
            values += self.hum * np.sin(angle + first) + self.harmonic * np.sin(3.0 * angle + third)
        return values

    def measured(self, clean: np.ndarray, noise: np.ndarray) -> np.ndarray:
        """What the converter gives."""
        values = clean + noise
        return self.quantum * np.rint(values / self.quantum) if self.quantum else values

    def whitened(self, difference: np.ndarray, sample_time: float) -> np.ndarray:
        """A difference of two records in independent standard deviations of the noise.

        White noise with the quantisation's step^2/12, after the lines of the mains are taken out. Coloured noise is
        ARMA(1, 1), sigma_e (1 - theta z^-1) / (1 - phi z^-1), which is inverted; its first samples count a little less
        than they could.
        """
        if self.coloured:
            phi = self.kept(sample_time)
            flat = self.white**2 + self.quantum**2 / 12.0
            whole = (self.coloured**2 * (1.0 - phi**2) + flat * (1.0 + phi**2)) / (flat * phi)
            theta = 0.5 * (whole - np.sqrt(whole**2 - 4.0))
            scale = np.sqrt(flat * phi / theta)
            return np.asarray(lfilter([1.0, -phi], [1.0, -theta], difference) / scale)
        if self.hum:
            angle = 2.0 * np.pi * self.mains * np.arange(difference.size) * sample_time
            lines = np.column_stack([f(n * angle) for n in (1.0, 3.0) for f in (np.cos, np.sin)])
            weights, *_ = np.linalg.lstsq(lines, difference, rcond=1e-6)
            difference = difference - lines @ weights
        return np.asarray(difference / self.random)

    def kept(self, sample_time: float) -> float:
        """What a sample leaves of the coloured part."""
        return float(np.exp(-2.0 * np.pi * self.cutoff * sample_time))


def draw_noise(kind: str, std: float, draw: np.random.Generator) -> Noise:
    """A channel's noise of that kind, with about that standard deviation."""
    if kind == COLOURED:
        cutoff = float(np.exp(draw.uniform(0.0, np.log(30.0))))
        return Noise(white=0.4 * std, coloured=0.9 * std, cutoff=cutoff)
    if kind == HUMMING:
        hum = std * draw.uniform(0.5, 2.0)
        return Noise(white=std, hum=hum, harmonic=hum * draw.uniform(0.1, 0.4), mains=float(draw.choice(MAINS)))
    if kind == QUANTISED:
        return Noise(white=0.5 * std, quantum=0.5 * std * draw.uniform(3.0, 6.0))
    return Noise(white=std)
