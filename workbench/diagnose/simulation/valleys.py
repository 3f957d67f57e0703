"""A fit of a simulated plant that ended in a hollow, taken further down its valley.

A contact that sticks breaks away at another time with every parameter, and what a long run is off by jumps: its squares
have hollows along a narrow valley, since few directions of the parameters change them little. A fit is in one where a
place is likelier than where it ended, along any of its principal directions. From there an evolution strategy searches,
whose steps begin as multiples of the deviations that difference quotients over hollows give.
"""

from workbench.diagnose.residuals.fit import Fit, fit
from workbench.diagnose.simulation.evolution import beside, evolved, principal
from workbench.diagnose.simulation.fits import AT_NOISE, BETTER, SETTLES, Fitting, Simulated
from workbench.fitting.least_squares import Search

AWAY = tuple(side * away for away in (1.0, 3.0, 10.0, 30.0) for side in (1.0, -1.0))
"""Deviations of a fit along each of its principal directions, at which another place may be likelier."""

WIDE = Search(most_steps=1, step=1e-2)
"""No search, but what parameters change over hollows."""

FIRST, GENERATIONS = 20.0, 40
"""Deviations by which the strategy's first places lie away from the fit, and its generations: a fit in difference
quotients goes on from the best place.
"""

ROUNDS = 3
"""At most; each goes on from where the one before ended."""


def along_valley(fitting: Fitting, first: Simulated) -> Simulated:
    """A fit from end to end that is as near to noise as it gets from `first` on: itself, where it is at noise, or in no
    hollow.
    """
    best = first
    for _ in range(ROUNDS):
        if not best.is_near or best.fit.excess < AT_NOISE or not _is_in_hollow(best.fit):
            break
        of = best.fit
        wide = fit(of.balance, of.values, of.names, fitting.bounds, WIDE, of.weighing)
        lower = evolved(of.balance, wide, FIRST, GENERATIONS)
        further = fitting.final(fitting.bettered(fitting.begun(best.how, lower)))
        if further.fit.rms > BETTER * best.fit.rms:
            break
        best = further
    return best


def _is_in_hollow(of: Fit) -> bool:
    """Whether a place along a principal direction is likelier than where a fit ended, by the noise that it leaves."""
    ways = principal(of).T
    squares = of.seen_at_each([beside(of, away * way) for way in ways for away in AWAY])
    return bool(min(squares) < of.squares - SETTLES)
