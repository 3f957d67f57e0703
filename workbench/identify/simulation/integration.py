"""Whether the simulations of a fit are fine enough: an integrator's own error must not pass for information."""

from dataclasses import replace

import numpy as np

from workbench.fitting.covariance import inverse
from workbench.identify.simulation.problem import STEP, Problem, projected

SHARE = 0.3
"""Of a standard deviation by which half the step may move an estimate, and by which it may change a derivative."""

SEED = 1


def is_fine(problem: Problem, theta: np.ndarray, jacobian: np.ndarray, cov: np.ndarray) -> bool:
    """Whether half the step of integration changes neither the estimates nor what the records say of them.

    With d the difference of the errors r and J their Jacobian: |H^-1 J' d| against the standard deviations, and
    |H^-1 J' dd/ds| against 1, s a step of all unknowns at once, of random signs.
    """
    finer = replace(problem, known={}, idle={})
    finer.refine()
    q, count = problem.projector(), theta.size
    own = projected(q, jacobian[:, :count])
    steps = inverse(own.T @ own) @ own.T
    signs = np.random.default_rng(SEED).choice([-1.0, 1.0], count)

    def difference(x: np.ndarray) -> np.ndarray:
        return projected(q, problem.errors(x) - finer.errors(x))

    lowest, highest = problem.limits()
    ahead, behind = (np.clip(theta + side * STEP * signs, lowest, highest) for side in (1.0, -1.0))
    slope = (difference(ahead) - difference(behind)) / (2.0 * STEP)
    deviations = np.sqrt(np.maximum(np.diag(cov)[:count], 0.0))
    moved = np.abs(steps @ difference(theta))
    return bool(np.all(moved <= SHARE * deviations) and np.all(np.abs(steps @ slope) <= SHARE))
