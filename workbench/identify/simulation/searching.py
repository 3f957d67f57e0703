"""The search of a fit: least squares within bounds, by a trust region."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares

from workbench.identify.simulation.problem import Problem, projected

FLAT, NEAR, MOST_STEPS = 1e-8, 1e-5, 60
"""A search ends when a step gains less of the sum of squares, or moves the unknowns less, than this."""

INSIDE = 1e-9
"""A search starts this far inside its bounds."""


def least(
    residual: Callable[[np.ndarray], np.ndarray],
    jacobian: Callable[[np.ndarray], np.ndarray],
    start: np.ndarray,
    limits: tuple[np.ndarray, np.ndarray],
) -> np.ndarray:
    """The unknowns of the least squares of a residual."""
    low, high = limits
    solution = least_squares(
        residual,
        np.clip(start, low + INSIDE, high - INSIDE),
        jac=jacobian,
        bounds=limits,
        ftol=FLAT,
        xtol=NEAR,
        gtol=None,
        max_nfev=MOST_STEPS,
    )
    return np.asarray(solution.x)


def solve(problem: Problem, theta: np.ndarray, *, rough: bool = False) -> np.ndarray:
    """The best unknowns of a problem; `rough` on the first way there."""
    if not problem.free:
        return theta
    q = problem.projector()
    return least(
        lambda x: projected(q, problem.errors(x)),
        lambda x: projected(q, problem.jacobian(x, rough=rough)),
        theta,
        problem.limits(),
    )
