"""A fit of a simulated plant that ended in a hollow, taken further down its valley.

A contact that sticks breaks away at another time with every parameter, and what a long run is off by jumps: its squares
have hollows along a narrow valley, since few directions of the parameters change them little. A fit is in one where a
place is likelier than where it ended, along any of its principal directions. From there an evolution strategy searches
that adapts its covariance (CMA-ES, Hansen and Ostermeier 2001): it asks only which of some places leave less, so that
hollows do not stop it. Its steps begin as multiples of the deviations that difference quotients over hollows give, by
which a valley is a round basin.
"""

import numpy as np
from cmaes import CMA

from workbench.diagnose.residuals.fit import Fit, fit, stacks
from workbench.diagnose.residuals.unknowns import Bounds
from workbench.diagnose.simulation.fits import AT_NOISE, BETTER, SETTLES, Fitting, Simulated
from workbench.fitting.least_squares import Search

AWAY = tuple(side * away for away in (1.0, 3.0, 10.0, 30.0) for side in (1.0, -1.0))
"""Deviations of a fit along each of its principal directions, at which another place may be likelier."""

WIDE = Search(most_steps=1, step=1e-2)
"""No search, but what parameters change over hollows."""

FIRST, PLACES, GENERATIONS = 20.0, 16, 40
"""Deviations by which the strategy's first places lie away from the fit, places of a generation, and generations: a fit
in difference quotients goes on from the best place.
"""

ROUNDS = 3
"""At most; each goes on from where the one before ended."""

SEED = 0
"""Of the strategy's places: the same records give the same fit."""


def along_valley(fitting: Fitting, first: Simulated) -> Simulated:
    """A fit from end to end that is as near to noise as it gets from `first` on: itself, where it is at noise, or in no
    hollow.
    """
    best = first
    for _ in range(ROUNDS):
        if not best.is_near or best.fit.excess < AT_NOISE or not _is_in_hollow(best.fit):
            break
        further = fitting.final(fitting.bettered(fitting.begun(best.how, _evolved(best.fit, fitting.bounds))))
        if further.fit.rms > BETTER * best.fit.rms:
            break
        best = further
    return best


def _is_in_hollow(of: Fit) -> bool:
    """Whether a place along a principal direction is likelier than where a fit ended, by the noise that it leaves."""
    ways = _ways(of).T
    squares = of.seen_at_each([_at(of, away * way) for way in ways for away in AWAY])
    return bool(min(squares) < of.squares - SETTLES)


def _evolved(of: Fit, bounds: Bounds) -> dict[str, float]:
    """The values that leave least of those that the strategy tries."""
    wide = fit(of.balance, of.values, of.names, bounds, WIDE, of.weighing)
    ways = _ways(wide)
    strategy = CMA(mean=np.zeros(len(of.names)), sigma=FIRST, population_size=PLACES, seed=SEED)
    least, best = of.rms, of.values
    for _ in range(GENERATIONS):
        asked = [strategy.ask() for _ in range(PLACES)]
        places = [_at(wide, ways @ away) for away in asked]
        left = [float(np.sqrt(np.mean(one**2))) for one in stacks(of.balance, places)]
        if min(left) < least:
            least, best = min(left), places[int(np.argmin(left))]
        strategy.tell(list(zip(asked, left, strict=True)))
        if strategy.should_stop():
            break
    return best


def _ways(of: Fit) -> np.ndarray:
    """The principal directions of a fit, as columns of a deviation's length."""
    sizes, directions = np.linalg.eigh(of.curvature)
    return np.asarray(directions / np.sqrt(np.maximum(sizes, np.finfo(float).tiny)))


def _at(of: Fit, away: np.ndarray) -> dict[str, float]:
    """The values so far away from those of a fit, within bounds."""
    low, high = np.array([u.low for u in of.unknowns]), np.array([u.high for u in of.unknowns])
    return of.at(np.clip(of.places + away, low, high))
