"""The plant as it is declared, fitted to a balance with its own parameters, however far these are off."""

import numpy as np

from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.fit import Fit, fit, weighed_fit
from workbench.diagnose.residuals.unknowns import Bounds, Values
from workbench.fitting.least_squares import Search
from workbench.fitting.threads import side_by_side
from workbench.parameters.sets import EITHER_SIGN

FACTORS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
"""Of a declared positive parameter, at which a fit that went astray begins anew."""

SWEEPS = 2
"""Times that each parameter in turn is put where it leaves least."""

WIDENED = 3
"""Times that a fit goes on from the end of a range."""

BETTER = 0.98
"""Rms over that of another fit from which it is better."""

AT_FLOOR = 1.3
"""Floors up to which no other start has to be tried."""

QUICK = Search(flat=1e-5, most_steps=30)
"""When a fit ends from another start."""


def baseline(balance: Balance, values: Values, bounds: Bounds) -> Fit:
    """The best fit of a balance's own parameters, from where they are declared and from where they leave least of those
    that may be a hundred times off; one that ends at the end of its range goes on from there.
    """
    best = _widened(fit(balance, values, balance.free, bounds, QUICK), bounds)
    if best.rms > AT_FLOOR and balance.free:
        other = _widened(fit(balance, _scanned(balance, values), balance.free, bounds, QUICK), bounds)
        best = other if other.rms < BETTER * best.rms else best
    return weighed_fit(balance, best.values, balance.free, bounds, first=best)


def _widened(fitted: Fit, bounds: Bounds) -> Fit:
    for _ in range(WIDENED):
        if not fitted.bounded - set(bounds):
            break
        again = fit(fitted.balance, fitted.values, fitted.names, bounds, QUICK)
        if again.rms > BETTER * fitted.rms:
            break
        fitted = again
    return fitted


def _scanned(balance: Balance, values: Values) -> dict[str, float]:
    """Values of the positive parameters that leave least, each in turn by the factors."""
    found = dict(values)

    def left(changed: Values) -> float:
        return float(np.nan_to_num(np.mean(balance.stacked(changed) ** 2), nan=np.inf))

    for _ in range(SWEEPS):
        before = found
        for name in balance.free:
            if name in (*EITHER_SIGN, *balance.priors) or values[name] <= 0.0:
                continue
            tried = [{**found, name: factor * values[name]} for factor in FACTORS]
            found = tried[int(np.argmin(side_by_side(left, tried)))]
        if found == before:
            break
    return found
