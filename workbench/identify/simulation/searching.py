"""The search of a fit: least squares within bounds, by a trust region."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares

from workbench.identify.simulation.problem import Problem, projected

FLAT, NEAR, MOST_STEPS = 1e-8, 1e-5, 60
"""A search ends when a step gains less of the sum of squares, or moves the unknowns less, than this, or after so many.
"""

SETTLED, ROUNDS = 2, 10
"""How it says that a step gained too little; and times that one which ended otherwise goes on from there, at most. In a
narrow valley steps get short long before its end.
"""

CLIMBS = 0.999
"""Share of the sum of squares that a round has to leave at most for another."""

INSIDE = 1e-9
"""A search starts this far inside its bounds."""


def least(
    residual: Callable[[np.ndarray], np.ndarray],
    jacobian: Callable[[np.ndarray], np.ndarray],
    start: np.ndarray,
    limits: tuple[np.ndarray, np.ndarray],
    rounds: int = ROUNDS,
) -> np.ndarray:
    """The unknowns of the least squares of a residual, by so many `rounds` at most."""
    low, high = limits
    x, left = np.asarray(start), np.inf
    for _ in range(rounds):
        solution = least_squares(
            residual,
            np.clip(x, low + INSIDE, high - INSIDE),
            jac=jacobian,
            bounds=limits,
            ftol=FLAT,
            xtol=NEAR,
            gtol=None,
            max_nfev=MOST_STEPS,
        )
        if solution.cost < left:
            x = np.asarray(solution.x)
        if solution.status == SETTLED or not solution.cost < CLIMBS * left:
            break
        left = solution.cost
    return x


def solve(problem: Problem, theta: np.ndarray, *, rough: bool = False) -> np.ndarray:
    """The best unknowns of a problem; `rough`, and by one round, on the first way there."""
    if not problem.free:
        return theta
    q = problem.projector()
    return least(
        lambda x: projected(q, problem.errors(x)),
        lambda x: projected(q, problem.jacobian(x, rough=rough)),
        theta,
        problem.limits(),
        rounds=1 if rough else ROUNDS,
    )
