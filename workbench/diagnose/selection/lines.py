"""Where over a signal an effect may repeat or swing: lines and bands that stand out of a residual.

What repeats along a way is a line of a periodogram over it only where the residual shows the effect itself. A force
that the plant passes on late, a valve that turns its sign, or noise that is not white, turn what each instant shows,
and over a motion the line cancels. So it is sought as the plant shows it: of some waves over the signal is found what
becomes of them at every instant, and a filter that is matched to that (Turin 1960) tells what of the residual is in
phase with a wave between them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from scipy.signal import zoom_fft

from plants.effects.interface import Number
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.fit import Fit
from workbench.diagnose.residuals.motion import signals_of
from workbench.diagnose.residuals.weighing import basis_of

OVERSAMPLED = 4.0
"""Frequencies of a periodogram in the width of a line."""

MOST_FREQUENCIES = 100_000
"""Of a periodogram."""

PEAKS = 3
"""Frequencies that are tried, of those that stand out most."""

REFERENCES = 24
"""Waves by which is seen how a plant shows what repeats along a signal: between two that are far apart the phase in
which it passes a force on is no straight line, and a line cancels.
"""

HIDDEN = 1e-3
"""Of the largest sum of squares that a wave makes, what is too little to be divided by; and of what parameters change
along one direction, what is too little to be one."""


@dataclass(frozen=True)
class Band:
    """Between which frequencies over a signal records could show one, and the signal's longest reach."""

    low: float
    high: float
    reach: float

    @property
    def lines(self) -> float:
        """How many frequencies records of this length tell apart."""
        return self.reach * (self.high - self.low)

    @property
    def frequencies(self) -> np.ndarray:
        """Those of a periodogram."""
        return np.linspace(self.low, self.high, int(np.clip(OVERSAMPLED * self.lines, 8, MOST_FREQUENCIES)))


_bands: WeakKeyDictionary[Balance, dict[Number, Band]] = WeakKeyDictionary()


def band_of(balance: Balance, number: Number) -> Band:
    """The band of a period or a frequency that shapes an effect: remembered as long as the balance is there."""
    known = _bands.setdefault(balance, {})
    if number not in known:
        known[number] = _band(balance, number)
    return known[number]


def _band(balance: Balance, number: Number) -> Band:
    scale = number.scale(balance.scales)
    low, high = number.low * scale, number.high * scale
    if number.period_of:
        low, high = 1.0 / high, 1.0 / low
    along = _along(balance, number.period_of or number.frequency_of)
    reach = max(float(np.ptp(values)) for values in along)
    fastest = max(float(np.percentile(np.abs(np.diff(values)), 50)) for values in along)
    return Band(max(low, 0.5 / reach), min(high, 0.25 / fastest if fastest > 0.0 else high), reach)


def swinging(fitted: Fit, signal: str, band: Band, damping: float) -> list[float]:
    """The frequencies over a signal about which a band stands out of a residual most, as wide as what swings there with
    a damping ratio shows.
    """
    frequencies = band.frequencies
    power = np.zeros(frequencies.size)
    for values, slices in zip(_along(fitted.balance, signal), fitted.balance.series, strict=True):
        for place in slices:
            residual = fitted.weighed[place]  # a band stands out of white noise alone
            scatter = float(np.mean(residual**2))
            if scatter > 0.0:
                power += np.abs(_spectra(values, residual[None, :], frequencies)[0]) ** 2 / (scatter * residual.size)
    return _peaks(frequencies, _of_bands(frequencies, power, damping), band, damping)


def references(band: Band) -> list[float]:
    """The frequencies of the waves of which is to be seen how a plant shows them."""
    return np.geomspace(band.low, band.high, REFERENCES).tolist()


def matched(fitted: Fit, signal: str, band: Band, made: Sequence[np.ndarray]) -> list[float]:
    """The frequencies f at which a cos(2 pi f s) + b sin(2 pi f s) of a signal s takes most of a residual as the plant
    shows it, beside the parameters of the fit; `made` is what it makes of the weighed residual of exp(2 pi i f s) at
    each of the `references`.

    At an instant that is A(f) exp(2 pi i f s), and A a straight line from reference to reference.
    """
    frequencies, along, places = band.frequencies, _along(fitted.balance, signal), references(band)
    shares = np.array([np.interp(frequencies, places, own) for own in np.eye(len(places))])
    looked = np.column_stack([fitted.weighed, basis_of(fitted.jacobian * fitted.free, share=HIDDEN)])
    products = np.zeros((looked.shape[1], frequencies.size), dtype=complex)
    squares = np.zeros((len(places), len(places)))
    for values, slices in zip(along, fitted.balance.series, strict=True):
        for place in slices:
            turned = [wave[place] * np.exp(-2j * np.pi * one * values) for one, wave in zip(places, made, strict=True)]
            squares += np.real(np.conj(turned) @ np.transpose(turned))
            for share, near, own in zip(shares, map(_around, shares), turned, strict=True):
                products[:, near] += share[near] * _spectra(values, np.conj(own) * looked[place].T, frequencies[near])
    slope, taken = np.abs(products[0]) ** 2, np.sum(np.abs(products[1:]) ** 2, axis=0)
    size = np.einsum("kf,kl,lf->f", shares, squares, shares)
    return _peaks(frequencies, slope / np.maximum(size - taken, HIDDEN * float(np.max(size)) + 1e-300), band)


def _around(share: np.ndarray) -> slice:
    """Where a share is not 0, and a place more to either side."""
    seen = np.flatnonzero(share)
    return slice(max(int(seen[0]) - 1, 0), int(seen[-1]) + 2) if seen.size else slice(0, 2)


def _along(balance: Balance, signal: str) -> list[np.ndarray]:
    return [signals_of(motion.thinned)[signal] for motion in balance.motions]


def _spectra(signal: np.ndarray, residuals: np.ndarray, frequencies: np.ndarray) -> np.ndarray:
    """sum r exp(-2 pi i f s) of each residual r (a row) over a signal s, for each frequency f, shape (residuals,
    frequencies): sums over bins of the signal that are an eighth of the shortest period.
    """
    low, high = float(np.min(signal)), float(np.max(signal))
    edges = np.linspace(low, high, int(8.0 * float(frequencies[-1]) * (high - low)) + 2)
    places, count = np.clip(np.digitize(signal, edges) - 1, 0, edges.size - 2), edges.size - 1
    sums = [np.bincount(places, row.real, count) + 1j * np.bincount(places, row.imag, count) for row in residuals]
    ends, bins = (float(frequencies[0]), float(frequencies[-1])), 1.0 / float(edges[1] - edges[0])
    turned = np.exp(-2j * np.pi * frequencies * 0.5 * (edges[0] + edges[1]))
    return np.asarray(turned * zoom_fft(np.array(sums), ends, frequencies.size, fs=bins, endpoint=True))


def _peaks(frequencies: np.ndarray, power: np.ndarray, band: Band, damping: float = 0.0) -> list[float]:
    """Where a power is largest, at as many places as are tried that records tell apart."""
    chosen, left = list[float](), frequencies[np.argsort(-power)]
    while left.size and len(chosen) < PEAKS:
        chosen.append(float(left[0]))
        left = left[np.abs(left - chosen[-1]) > max(1.0 / band.reach, 2.0 * damping * chosen[-1])]
    return chosen


def _of_bands(frequencies: np.ndarray, power: np.ndarray, damping: float) -> np.ndarray:
    """By how much the power of a band about each frequency is above the mean, over its scatter: of the band between the
    half powers of what swings there, (1 - D) f to (1 + D) f.
    """
    above = np.concatenate([[0.0], np.cumsum(power - np.mean(power))])
    last = frequencies.size - 1
    step = (frequencies[-1] - frequencies[0]) / last
    first = np.clip(np.rint(((1.0 - damping) * frequencies - frequencies[0]) / step), 0, last).astype(int)
    end = np.clip(np.rint(((1.0 + damping) * frequencies - frequencies[0]) / step), 0, last).astype(int) + 1
    return np.asarray((above[end] - above[first]) / np.sqrt(end - first))
