"""Fits of a plant to simulation error: piece by piece, then from end to end."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from workbench.diagnose.residuals.fit import Fit, fit, weighed_fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.simulation.setup import SEGMENT
from workbench.diagnose.simulation.shooting import Shooting
from workbench.fitting.least_squares import Search

QUICK = Search(flat=1e-4, near=1e-4, most_steps=12)
"""When a fit ends from which another goes on."""

SEARCH = Search(flat=1e-6, near=1e-6, most_steps=30)
"""When the fit ends whose parameters count."""

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
        return weighed_fit(near.balance, near.values, names, bounds, QUICK, first=near)
    whole = fit(how.balance(motions, names), near.values, names, bounds, SEARCH)
    return weighed_fit(whole.balance, whole.values, names, bounds, SEARCH, first=whole)
