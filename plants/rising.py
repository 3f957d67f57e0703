"""Where a function of one number that never falls is 0: for what a machine or a controller is once designed with."""

from collections.abc import Callable
from math import isnan, nan

HALVINGS = 60
"""Of an interval: to the last bit of a double, whatever its size."""

NEAR = 1e-9
"""Share of an interval beside a zero at which another one tells that there is a whole stretch of them."""


def zeros(function: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """From where to where it is 0; twice the nearer end where it does not come there."""
    if function(low) > 0.0:
        return low, low
    if function(high) < 0.0:
        return high, high
    root, near = rising(function, low, high), NEAR * (high - low)
    first = last = root
    if root > low and function(max(root - near, low)) == 0.0:
        first = _halved(lambda x: function(x) < 0.0, low, root)
    if root < high and function(min(root + near, high)) == 0.0:
        last = _halved(lambda x: function(x) <= 0.0, root, high)
    return first, last


def rising(function: Callable[[float], float], low: float, high: float) -> float:
    """Where it crosses 0; the nearer end where it does not; NaN of a function that is no number at an end."""
    from scipy.optimize import brentq  # no command waits for it that asks of no machine

    first, last = function(low), function(high)
    if isnan(first) or isnan(last):
        return nan
    if first >= 0.0:
        return low
    if last <= 0.0:
        return high
    return float(brentq(function, low, high, xtol=1e-15 * (high - low), rtol=1e-15, maxiter=10 * HALVINGS))


def _halved(is_below: Callable[[float], bool], low: float, high: float) -> float:
    """Where what holds at `low` and not at `high` ends."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_below(middle) else (low, middle)
    return 0.5 * (low + high)
