"""Downhill along the bounds of constraints: COBYQA, which takes no derivatives.

Its authors' own package: SciPy's copy lets only one thread in at a time, and searches run side by side.

T. M. Ragonneau, Model-based derivative-free optimization methods and software, thesis, Hong Kong Polytechnic
University, 2022: quadratic models of objective and constraints in a trust region. Where an optimum lies on the bound of
a constraint, as that of most gains does on the phase margin's, its steps follow the bound.
"""

import math
from collections.abc import Callable, Mapping

import numpy as np
from cobyqa import minimize
from scipy.optimize import NonlinearConstraint

SMOOTH = ("gain margin", "phase margin", "saturation")
"""Constraints that change gradually with the gains, and of which there can be a model; others are a wall."""

LAST_RADIUS = 1e-3
"""Of the trust region, in shares of the ranges."""

WITHIN = 1e-3
"""Shares of a constraint by which its bound is kept clear of, so that where the descent ends it is kept."""

WALL = 0.1
"""By which the logarithm of the objective behind a wall is above the largest that was met."""

LEAST = 1e-12
"""Objective below which all are alike."""

Tried = Callable[[np.ndarray], tuple[float, Mapping[str, float]]]
"""The objective at a point of the unit cube, and by constraint how far beyond it the point is."""


def descend(tried: Tried, start: np.ndarray, radius: float, count: int) -> None:
    """Try at most `count` points from `start` (in the unit cube) downhill, the first at `radius` from it.

    The logarithm of the objective is what is made small: ratios count. Where a run fails, or the loop hunts, there is
    nothing to make a model of; the objective is then a little above all that were met.
    """
    seen: dict[bytes, tuple[float, np.ndarray]] = {}
    highest = -math.inf

    def at(shares: np.ndarray) -> tuple[float, np.ndarray]:
        nonlocal highest
        shares = np.clip(shares, 0.0, 1.0)
        key = shares.tobytes()
        if key not in seen:
            value, violations = tried(shares)
            walled = any(beyond > 0.0 for name, beyond in violations.items() if name not in SMOOTH)
            beyond = np.array([violations[name] for name in SMOOTH]) + WITHIN
            if math.isfinite(value):
                highest = max(highest, math.log(max(value, LEAST)))
            if walled or not math.isfinite(value):
                value = math.exp(highest + WALL) if math.isfinite(highest) else 1.0
            seen[key] = math.log(max(value, LEAST)), beyond
        return seen[key]

    minimize(
        lambda shares: at(shares)[0],
        start,
        bounds=[(0.0, 1.0)] * start.size,
        constraints=[NonlinearConstraint(lambda shares: at(shares)[1], -np.inf, 0.0)],
        options={"radius_init": radius, "radius_final": LAST_RADIUS, "maxfev": count},
    )
