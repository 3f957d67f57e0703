"""Does an oscillation die? The trend of its strength, the root mean square of each cycle.

Peaks would not do: two tones whose frequencies are nearly as whole numbers change their peaks and nothing else. It dies
where the logarithm of the strength falls

- at nearly every cycle: whatever it rises again on the way is less than a fifth of what it falls, and it is not on its
  way to a lasting cycle: the last third of the record falls by less than 5 %, from the first to the second third it
  falls more than twice as far as from there to the third, and that ends (Aitken's extrapolation) not far below; or
- along a line that chance explains in fewer than 1 of 1000 cases, where what is left about the line counts for as many
  independent cycles as its correlation leaves: an envelope that beats is a slow wave, not a fall;

and in either case by more than 2 % in all. A slow fall is looked for because friction of Coulomb's kind alone converges
so slowly that neighbours agree within some percent, and it is no limit cycle (Ruderman 2020).
"""

import numpy as np

FALL, CHANCE = 0.02, 1e-3
"""Relative fall of the amplitude over the record that counts, and the probability that it is chance."""

RISE = 0.2
"""Share of the fall up to which an amplitude may rise in between."""

FLAT, FLATTENS, LASTING = 0.05, 0.5, 0.8
"""A fall ends in a lasting cycle: relative fall of the last third, the second fall over the first, and what remains in
the end as a share of the last third.
"""

CORRELATED = 0.95
"""Correlation of neighbours is counted up to here: the estimate of more is not to be had from some tens of cycles."""


def dies(strengths: np.ndarray) -> bool:
    """Whether the strengths (m) of cycles, half a cycle apart, fall."""
    logs = np.log(strengths)
    return _falls_steadily(logs) or _falls_along_a_line(logs[::2])  # neighbours share a half wave


def _falls_steadily(logs: np.ndarray) -> bool:
    fall = float(np.max(np.maximum.accumulate(logs) - logs))
    rise = float(np.max(logs - np.minimum.accumulate(logs)))
    if fall < -np.log1p(-FALL) or rise > RISE * fall:
        return False
    parts = np.array_split(np.exp(logs), 3)
    first, second, third = (float(np.mean(part)) for part in parts)
    if parts[2][-1] < (1.0 - FLAT) * parts[2][0] or second - third >= FLATTENS * (first - second):
        return True
    return (first * third - second**2) / (first + third - 2.0 * second) < LASTING * third


def _falls_along_a_line(logs: np.ndarray) -> bool:
    count = np.arange(logs.size)
    (variance, shared), (_, spread) = np.cov(count, logs, bias=True)
    slope = shared / variance
    if 1.0 - np.exp(slope * (logs.size - 1)) <= FALL:
        return False
    left = logs - np.mean(logs) - slope * (count - np.mean(count))
    power = float(left @ left)
    if power <= 1e-20:
        return True
    alike = float(np.clip((left[1:] @ left[:-1]) / power, 0.0, CORRELATED))
    freedom = logs.size * (1.0 - alike) / (1.0 + alike) - 2.0
    if freedom < 1.0:
        return False
    from scipy.special import stdtr  # Student's distribution; a run that keeps no beat does not wait for it

    explained = shared**2 / (variance * spread)
    size = np.sqrt(explained * freedom / max(1.0 - explained, 1e-20))
    return bool(2.0 * stdtr(freedom, -size) < CHANCE)
