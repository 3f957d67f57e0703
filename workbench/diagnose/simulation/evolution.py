"""The values that leave least of a rugged balance about a fit, by an evolution strategy.

CMA-ES (Hansen and Ostermeier 2001) adapts its covariance, and asks only which of some places leave less, so that
hollows do not stop it. Its steps begin as multiples of the fit's deviations along its principal directions, by which a
valley is a round basin.
"""

import numpy as np
from cmaes import CMA

from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.fit import Fit, stacks

PLACES = 16
"""Of a generation."""

FALLS = 1.05
"""Factor by which a generation lowers what is left where the strategy gets on well [1.03 to 1.06 of a light drive]."""

SEED = 0
"""Of the strategy's places: the same records give the same fit."""


def evolved(
    balance: Balance, about: Fit, first: float, generations: int, enough: float | None = None
) -> dict[str, float]:
    """The values, from those of a fit on, that leave least of a balance of those that are tried: the first ones so many
    deviations beside the fit, in so many generations at most; or until what is left has an rms that is `enough`, or
    would not have in as many generations as there may be.
    """
    ways, best = principal(about), about.values
    least = left_at(balance, [best])[0]
    strategy = CMA(mean=np.zeros(len(about.names)), sigma=first, population_size=PLACES, seed=SEED)
    for further in reversed(range(generations)):
        asked = [strategy.ask() for _ in range(PLACES)]
        places = [beside(about, ways @ away) for away in asked]
        left = left_at(balance, places)
        if min(left) < least:
            least, best = min(left), places[int(np.argmin(left))]
        strategy.tell(list(zip(asked, left, strict=True)))
        if strategy.should_stop():
            break
        if enough is not None and not enough < least < enough * FALLS**further:
            break
    return dict(best)


def left_at(balance: Balance, places: list[dict[str, float]]) -> list[float]:
    """Rms of what is left with each of these values."""
    return [float(np.sqrt(np.mean(one**2))) for one in stacks(balance, places)]


def principal(of: Fit) -> np.ndarray:
    """The principal directions of a fit, as columns of a deviation's length."""
    sizes, directions = np.linalg.eigh(of.curvature)
    return np.asarray(directions / np.sqrt(np.maximum(sizes, np.finfo(float).tiny)))


def beside(of: Fit, away: np.ndarray) -> dict[str, float]:
    """The values so far away from those of a fit, within bounds."""
    low, high = np.array([u.low for u in of.unknowns]), np.array([u.high for u in of.unknowns])
    return of.at(np.clip(of.places + away, low, high))
