"""What hum of a sensor may be: a line over time at a multiple of the mains' frequency, in each channel for itself.

A supply that ripples shows with every opening of the valve, a sensor that hums shows always. Of what repeats with the
mains that counts alone which no hum of the same frequency takes. A ripple of another frequency has lines beside its
own, since the valve's opening swings: as far from it as the motion is quick. Where one of them is at the mains, a hum
is taken for it. A record shows what is faster than half its sampling folded back.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from plants.effects.registry import effects
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.residuals.weighing import without

MAINS, WANDERS, MULTIPLES = (50.0, 60.0), 2e-3, 10
"""Hz; share by which a grid's frequency is off at most in an ordinary year (EN 50160 allows 1 %); and how often it is
contained in what hums, at most.
"""

QUICK, FINE = 0.99, 4.0
"""Share of the power of a motion's velocity that is as far as it is quick; and frequencies that are tried for each that
a record tells apart.
"""


def humming_at(balance: Balance, effect: str, values: Values) -> float | None:
    """Hz at which an effect repeats over time, by its numbers among `values`; None where that is not the mains."""
    frequency = _repeats_at(balance, effect, values)
    return frequency if frequency is not None and _may_be_mains(balance, frequency) else None


def hums_for(balance: Balance, effect: str, values: Values, residual: np.ndarray) -> list[float]:
    """Hz of hums in the place of which an effect may stand that repeats over time: at its own frequency, if that may be
    the mains, else the strongest lines of a residual (rows) at the mains, as far from it as the motion is quick.
    """
    frequency = _repeats_at(balance, effect, values)
    if frequency is None:
        return []
    if _may_be_mains(balance, frequency):
        return [frequency]
    reach, lines = _quickness(balance), dict(_lines_of_mains(balance))  # records of one sampling show the same
    near = {line: width for line, width in lines.items() if abs(line - frequency) < reach + width}
    return [_strongest(balance, residual, line, width) for line, width in near.items()]


def _repeats_at(balance: Balance, effect: str, values: Values) -> float | None:
    """Hz at which an effect repeats over time, whatever that is."""
    for name, number in effects(balance.axis)[effect].numbers.items():
        if number.frequency_of == "time" and not number.damped_by and name in values:
            return values[name]
    return None


def _lines_of_mains(balance: Balance) -> Iterator[tuple[float, float]]:
    """Hz at which records of a balance show multiples of the mains' frequency, and by how much these may be off."""
    for record in (motion.record for motion in balance.motions):
        h, longest = record.sample_time, record.time.size * record.sample_time
        for multiple in (k * mains for mains in MAINS for k in range(1, MULTIPLES + 1)):
            yield abs(multiple - round(multiple * h) / h), WANDERS * multiple + 1.0 / longest


def _quickness(balance: Balance) -> float:
    """Hz below which nearly all power of the motions' velocities is."""
    quickest = 0.0
    for motion in balance.motions:
        power = np.cumsum(np.abs(np.fft.rfft(motion.velocity - np.mean(motion.velocity))) ** 2)
        place = int(np.searchsorted(power, QUICK * power[-1]))
        quickest = max(quickest, place / (motion.time.size * motion.sample_time))
    return quickest


def _strongest(balance: Balance, residual: np.ndarray, line: float, width: float) -> float:
    """Hz, within a width of a line, at which waves take most of a residual."""
    longest = max(float(np.ptp(motion.thinned.time)) for motion in balance.motions)
    tried = line + np.arange(-np.ceil(width * longest * FINE), np.ceil(width * longest * FINE) + 1.0) / (longest * FINE)
    left = [float(np.sum(without_hum(balance, residual, [one]) ** 2)) for one in tried]
    return float(tried[int(np.argmin(left))])


def _may_be_mains(balance: Balance, frequency: float) -> bool:
    """Whether a record of the balance would show a multiple of the mains' frequency as this one (Hz)."""
    return any(abs(frequency - line) < width for line, width in _lines_of_mains(balance))


def without_hum(balance: Balance, stack: np.ndarray, frequencies: Sequence[float]) -> np.ndarray:
    """A residual (rows,), or columns of one (rows, columns), less what hums of these frequencies (Hz) take."""
    times = np.concatenate([np.tile(motion.thinned.time, balance.parts) for motion in balance.motions])
    angles = 2.0 * np.pi * np.outer(times, frequencies)
    waves = np.column_stack([np.cos(angles), np.sin(angles)])
    channels = [np.arange(place.start, place.stop) for slices in balance.series for place in slices]
    columns = stack.reshape(stack.shape[0], -1)
    return np.column_stack([without(column, waves, channels) for column in columns.T]).reshape(stack.shape)
