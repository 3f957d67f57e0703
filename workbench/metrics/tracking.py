"""How well the position follows: phase lag and gain, errors, settling."""

import functools
import math
from collections.abc import Sequence

import numpy as np

from workbench.metrics.window import first_sample
from workbench.simulation.run import HARDLY_MOVES

LAST_PART = 0.20
"""Share of a dwell, at its end, over which the steady-state errors are taken."""

SETTLED = 0.02
"""Share of the jump within which the error must stay."""

HARMONICS = 7
LEAST_PERIODS = 1.99
"""Periods from which a drift is told from harmonics; the samples may lack a little of the second."""

MOST_KNOWN = 20_000
"""Samples up to which the weights of a fit are kept for the next case: 0.3 MB."""

LEAST_AMPLITUDE = 1e-9
"""m. A fundamental, or a jump, smaller than this is none."""


def fundamentals(time: np.ndarray, signals: Sequence[np.ndarray], frequency: float) -> list[complex] | None:
    """A exp(i phi) of the fundamental A sin(w t + phi) of each signal, by least squares; w = 2 pi `frequency` (Hz).
    None where the samples do not show it: they are too few, or two of them or fewer make a period.

        sum over k = 1..K of a_k sin(k w t) + b_k cos(k w t), + c + d t

    The drift d is fitted where there are two periods to tell it from a harmonic, and the harmonics up to K =
    `HARMONICS` with it, since a sine that is left out tilts the line. One period has K = 1 and d = 0.
    """
    weights = _known_weights(time.tobytes(), frequency) if time.size <= MOST_KNOWN else _weights(time, frequency)
    if weights is None:
        return None
    return [complex(*(weights @ signal)) for signal in signals]


@functools.lru_cache(4)
def _known_weights(time: bytes, frequency: float) -> np.ndarray | None:
    """`_weights`, of which the cases of a study need the same again and again."""
    return _weights(np.frombuffer(time), frequency)


def _weights(time: np.ndarray, frequency: float) -> np.ndarray | None:
    """What samples are to be multiplied with to give a_1, and b_1, of the sum that `fundamentals` fits, a row each.
    None where the samples do not tell its terms apart.
    """
    angle = 2.0 * np.pi * frequency * time
    step = angle[1] - angle[0]
    drifts = (angle[-1] - angle[0] + step) / (2.0 * np.pi) > LEAST_PERIODS
    most = int(np.pi / step) - 1  # fewer than half the samples of a period
    harmonics = max(1, min(HARMONICS, most)) if drifts else 1
    basis = np.ones((2 * harmonics + 1 + drifts, angle.size))
    first = np.exp(1j * angle)
    wave = np.ones_like(first)
    for k in range(harmonics):
        wave = wave * first  # exp(i k w t)
        basis[2 * k], basis[2 * k + 1] = wave.imag, wave.real
    if drifts:
        basis[-1] = np.linspace(-1.0, 1.0, angle.size)
    products = basis @ basis.T
    if np.linalg.matrix_rank(products) < products.shape[0]:
        return None
    return np.ascontiguousarray(np.linalg.solve(products, basis)[:2])


def phase_lag_and_gain(
    time: np.ndarray, reference: np.ndarray, position: np.ndarray, frequency: float
) -> tuple[float | None, float | None]:
    """Phase lag (deg) of position behind reference (both m) at `frequency` (Hz), and the ratio of their amplitudes.

    phi(reference) - phi(position) in (-180, 180], positive where the position is late; over whole periods. Both are
    None where the samples show no such fundamental of the reference, the lag also where the position hardly moves: a
    ratio below HARDLY_MOVES.
    """
    found = fundamentals(time, (reference, position), frequency)
    if found is None:
        return None, None
    asked, got = found
    if abs(asked) < LEAST_AMPLITUDE:
        return None, None
    lead = math.degrees(math.atan2(got.imag, got.real) - math.atan2(asked.imag, asked.real))
    lag = 180.0 - (180.0 + lead) % 360.0
    gain = abs(got) / abs(asked)
    return lag if abs(got) >= LEAST_AMPLITUDE and gain >= HARDLY_MOVES else None, gain


def root_mean_square(signal: np.ndarray) -> float:
    """Root of the mean square, in the unit of `signal`; of numbers too, whose squares none can hold."""
    with np.errstate(over="ignore"):
        total = float(np.square(signal).sum())
    if math.isinf(total) and math.isfinite(largest := float(np.max(np.abs(signal)))):
        return largest * root_mean_square(signal / largest)
    return math.sqrt(total / signal.size)


def steady_state_errors(
    time: np.ndarray, error: np.ndarray, dwell: slice, transient: float
) -> tuple[float | None, float | None]:
    """|mean error| and largest |error| over the last 20 % of a dwell (m); None where it lies before `transient` (s)."""
    count = max(1, round(LAST_PART * (dwell.stop - dwell.start)))
    start = max(dwell.stop - count, first_sample(time, transient))
    if start >= dwell.stop:
        return None, None
    last = error[start : dwell.stop]
    return abs(float(np.mean(last))), float(np.max(np.abs(last)))


def settling_time(time: np.ndarray, reference: np.ndarray, error: np.ndarray, dwells: list[slice]) -> float | None:
    """Largest, over the dwells that begin with a jump, time (s) from the jump until |error| stays within 2 % of it.

    From there it stays until the dwell ends. None where no dwell begins with a jump, or where any does not settle. A
    jump is a change from one sample to the next of more than twice what the reference's speed until then accounts
    for; at the start of a run it is the error there. `reference` and `error` in m.
    """
    times = []
    for dwell in dwells:
        jump = abs(_jump(reference, error, dwell.start))
        if jump <= LEAST_AMPLITUDE:
            continue
        outside = np.flatnonzero(np.abs(error[dwell]) > SETTLED * jump)
        settled = dwell.start + (int(outside[-1]) + 1 if outside.size else 0)
        if settled == dwell.stop:
            return None
        times.append(float(time[settled] - time[dwell.start]))
    return max(times, default=None)


def _jump(reference: np.ndarray, error: np.ndarray, start: int) -> float:
    """Height (m) by which the reference jumps at sample `start`, 0 where it only turns."""
    if start == 0:
        return float(error[0])
    step = reference[start] - reference[start - 1]
    before = reference[start - 1] - reference[start - 2] if start > 1 else 0.0
    return float(step) if abs(step) > 2.0 * abs(before) else 0.0
