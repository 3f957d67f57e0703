"""Where a function of one number crosses 0, by halving: for what a machine or a controller is once designed with."""

from collections.abc import Callable

HALVINGS = 60
"""Of an interval: to the last bit of a double, whatever its size."""


def rising(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function that rises crosses 0; the nearer end where it does not."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if function(middle) > 0.0 else (middle, high)
    return 0.5 * (low + high)
