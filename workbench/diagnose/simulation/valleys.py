"""A fit of a simulated plant that ended in a hollow, taken further down its valley.

A contact that sticks breaks away at another time with every parameter, and what a long run is off by jumps: its squares
have hollows along a narrow valley, since few directions of the parameters change them little. From where a fit ended
the plant is simulated at places along each of its principal directions, as far away as its deviations, and many of
them; from the best of them it goes on in wide difference quotients, which hollows do not turn, and then in narrow ones.
"""

import numpy as np

from workbench.diagnose.residuals.fit import AS_IT_IS, Fit, fit, weighed_by, weighing_at
from workbench.diagnose.residuals.weighing import by_scatter
from workbench.diagnose.simulation.fits import AT_NOISE, BETTER, Fitting, Simulated
from workbench.fitting.least_squares import Search
from workbench.fitting.threads import side_by_side

AWAY = tuple(side * away for away in (1.0, 3.0, 10.0, 30.0) for side in (1.0, -1.0))
"""Deviations of a fit along each of its principal directions, at which others begin."""

WIDE, NARROW = Search(flat=1e-3, most_steps=15, step=1e-2), Search(flat=1e-3, most_steps=15)
"""Searches over hollows, and to the end of one."""

ROUNDS = 8
"""At most; each goes on from the best of the one before."""


def along_valley(fitting: Fitting, first: Simulated) -> Simulated:
    """A fit from end to end that is as near to noise as it gets from `first` on: itself, where it is at noise."""
    best = first
    for _ in range(ROUNDS):
        if not best.is_near or best.fit.excess < AT_NOISE:
            break
        further = _further(fitting, best)
        if further.fit.rms > BETTER * best.fit.rms:
            break
        best = further
    return first if best is first else min(first, fitting.final(best), key=lambda one: one.fit.rms)


def _further(fitting: Fitting, best: Simulated) -> Simulated:
    """The best of what a round finds, from the starts that suit it."""
    start = _least_along(best.fit)
    fits = [start]
    for weighing in (weighed_by(by_scatter, best.fit), weighing_at(best.fit)):  # nobody knows yet what is noise
        wide = fit(best.fit.balance, start.values, fitting.names, fitting.bounds, WIDE, weighing)
        fits += [wide, fit(wide.balance, wide.values, fitting.names, fitting.bounds, NARROW, weighing)]
    nearest = min(fits, key=lambda one: one.rms)
    begun = fitting.begun(best.how, nearest.values)
    how = begun.how if begun.fit.rms < nearest.rms else best.how
    balance = how.balance(fitting.motions, fitting.names)
    return Simulated(how, fit(balance, nearest.values, fitting.names, fitting.bounds, AS_IT_IS, weighing_at(begun.fit)))


def _least_along(of: Fit) -> Fit:
    """Of places along the principal directions of a fit, within bounds, that which leaves least."""
    sizes, directions = np.linalg.eigh(of.curvature)
    ways = (directions / np.sqrt(np.maximum(sizes, np.finfo(float).tiny))).T
    low, high = np.array([u.low for u in of.unknowns]), np.array([u.high for u in of.unknowns])
    places = [np.clip(of.places + away * way, low, high) for way in ways for away in AWAY]
    return min(side_by_side(lambda place: fit(of.balance, of.at(place), ()), places), key=lambda one: one.rms)
