"""What hum of a sensor may be: a line over time at a multiple of the mains' frequency, in each channel for itself.

A supply that ripples shows with every opening of the valve, a sensor that hums shows always. Of what repeats with the
mains that counts alone which no hum of the same frequency takes. A record shows what is faster than half its sampling
folded back.
"""

import numpy as np

from plants.effects.registry import effects
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.residuals.weighing import without

MAINS, WANDERS, MULTIPLES = (50.0, 60.0), 2e-3, 10
"""Hz; share by which a grid's frequency is off at most in an ordinary year (EN 50160 allows 1 %); and how often it is
contained in what hums, at most.
"""


def humming_at(balance: Balance, effect: str, values: Values) -> float | None:
    """Hz at which an effect repeats over time, by its numbers among `values`; None where that is not the mains."""
    for name, number in effects(balance.axis)[effect].numbers.items():
        if number.frequency_of == "time" and not number.damped_by and name in values:
            return values[name] if _may_be_mains(balance, values[name]) else None
    return None


def _may_be_mains(balance: Balance, frequency: float) -> bool:
    """Whether a record of the balance would show a multiple of the mains' frequency as this one (Hz)."""
    for record in (motion.record for motion in balance.motions):
        h, longest = record.sample_time, record.time.size * record.sample_time
        for multiple in (k * mains for mains in MAINS for k in range(1, MULTIPLES + 1)):
            folded = abs(multiple - round(multiple * h) / h)
            if abs(frequency - folded) < WANDERS * multiple + 1.0 / longest:
                return True
    return False


def without_hum(balance: Balance, stack: np.ndarray, frequency: float) -> np.ndarray:
    """A residual, or columns of one, shape (rows,) or (rows, columns), less what a hum of that frequency (Hz) takes."""
    times = np.concatenate([np.tile(motion.thinned.time, balance.parts) for motion in balance.motions])
    angles = 2.0 * np.pi * frequency * times
    waves = np.column_stack([np.cos(angles), np.sin(angles)])
    channels = [np.arange(place.start, place.stop) for slices in balance.series for place in slices]
    columns = stack.reshape(stack.shape[0], -1)
    return np.column_stack([without(column, waves, channels) for column in columns.T]).reshape(stack.shape)
