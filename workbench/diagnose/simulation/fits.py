"""Fits of a plant to simulation error: piece by piece, then from end to end, with deviations that can be believed."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from workbench.diagnose.residuals.fit import Fit, Search, fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.simulation.promising import QUICK
from workbench.diagnose.simulation.setup import SEGMENT
from workbench.diagnose.simulation.shooting import Shooting

SEARCH = Search(flat=1e-4, near=1e-5, most_steps=30)
"""When the fit ends whose parameters count: later than `QUICK`, by which effects are ranked."""

NOISE = 1.5
"""Standard deviations of noise up to which nothing has to be explained further."""

TRUSTED = 3.0
"""Standard deviations of noise up to which the parameters of a simulated plant are believed before those that the
balances give: beyond it what the model lacks decides them, and what adds up over time most of all."""


def mean_square(how: Shooting, fitted: Fit) -> float:
    """Mean square of the simulation error with the values of a fit."""
    balance = how.balance(fitted.balance.motions, fitted.names)
    return float(np.nan_to_num(np.mean(balance.stacked(fitted.values) ** 2), nan=np.inf))


def fit_simulation(
    how: Shooting,
    motions: Sequence[Motion],
    start: Values,
    names: Sequence[str],
    bounds: Mapping[str, tuple[float, float]],
) -> Fit:
    """The plant fitted piece by piece, and from there as far as it follows: a contact that breaks away at another time
    puts hollows into the error of a long run.
    """
    near = fit(replace(how, length=SEGMENT).balance(motions, names), start, names, bounds, QUICK)
    if not np.isinf(how.length):
        return near
    return fit(how.balance(motions, names), near.values, names, bounds, SEARCH)


def polished(near: Fit, own: Values, bounds: Mapping[str, tuple[float, float]]) -> Fit:
    """A fit at its best; where more than noise is left, also from the plant's `own` parameters as declared."""
    best = fit(near.balance, near.values, near.names, bounds, SEARCH)
    if best.rms < NOISE:
        return best
    again = fit(near.balance, {**near.values, **own}, near.names, bounds, SEARCH)
    return min(best, again, key=lambda fitted: fitted.rms)


def with_honest_deviations(how: Shooting, fitted: Fit) -> Fit:
    """A fit from end to end with the larger of its standard deviations and those of the same plant in pieces.

    The error of a long run has hollows: a contact that breaks away a little later shifts all that follows. A search
    stops in one of them, and its curvature is that of the hollow: a Coulomb friction came out 6 N off with a standard
    deviation of 0.02 N. Pieces are too short for it, and say 7 N. A fit that is far from noise stays as it is: what the
    plant lacks makes more of its pieces' errors than any parameter.
    """
    if not np.isinf(how.length) or fitted.rms > TRUSTED:
        return fitted
    pieces = replace(how, length=SEGMENT).balance(fitted.balance.motions, fitted.names)
    wide = fit(pieces, fitted.values, fitted.names, search=Search(most_steps=1)).deviations
    return replace(fitted, deviations={name: max(std, wide[name]) for name, std in fitted.deviations.items()})
