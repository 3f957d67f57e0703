"""Lags of first order, those too that are shorter than a solver could follow soon."""

import numpy as np

from plants.equation import Scalar, equation

SHORTEST = 1e-4
"""s. A lag that is shorter is a share of this one: over longer times a signal comes as late."""


@equation
def lagged(signal: Scalar, followed: Scalar, lag: Scalar) -> Scalar:
    """x + min(T/T_0, 1) (x_l - x): a signal x behind a lag T (s), x_l behind that or `SHORTEST` T_0, what is longer."""
    return signal + np.minimum(lag / SHORTEST, 1.0) * (followed - signal)


@equation
def followed_rate(signal: Scalar, followed: Scalar, lag: Scalar) -> Scalar:
    """dx_l/dt = (x - x_l) / max(T, T_0)."""
    return (signal - followed) / np.maximum(lag, SHORTEST)
