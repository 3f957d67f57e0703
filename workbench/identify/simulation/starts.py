"""Where a search of a fit by simulation starts, and where it starts anew if it has ended far from the noise."""

import numpy as np
from scipy.stats import qmc

from workbench.identify.simulation.problem import Problem, projected

LOGARITHMIC_SCAN, LINEAR_SCAN, FARTHEST, MOST_SCANS = (-1.2, -0.4, 0.4, 1.2), (-2.0, -0.5, 0.5, 2.0), 2.4, 6
"""Steps of the unknowns in a coarse scan, how far it goes (11 times as much), and how often through all of them."""

TRIED, STARTED, SEED = 32, 3, 1
"""Other starts that are looked at, and the best of them from which a search goes on."""

WITHIN = 1.5
"""How far from the declared values they lie in every unknown: 4.5 times as much or as little."""


def scanned(problem: Problem) -> np.ndarray:
    """The unknowns from which a search starts of which the valleys are narrow: of delays and dead bands.

    Each unknown in turn takes the best of some values far around its own, until none gets better.
    """
    theta = np.zeros(len(problem.free))
    low, high = (np.clip(ends, -FARTHEST, FARTHEST) for ends in problem.limits())
    q = problem.projector()
    best = _left(problem, theta, q)
    for _ in range(MOST_SCANS):
        before = best
        for i, name in enumerate(problem.free):
            steps = LOGARITHMIC_SCAN if problem.logarithmic(name) else LINEAR_SCAN
            for value in {float(np.clip(theta[i] + step, low[i], high[i])) for step in steps} - {float(theta[i])}:
                trial = theta.copy()
                trial[i] = value
                if (found := _left(problem, trial, q)) < best:
                    theta, best = trial, found
        if best == before:
            break
    return theta


def others(problem: Problem) -> list[np.ndarray]:
    """Other starts, spread evenly about the declared values (Sobol 1967), the best first."""
    if not problem.free:
        return []
    low, high = (np.clip(ends, -WITHIN, WITHIN) for ends in problem.limits())
    points = qmc.Sobol(len(problem.free), seed=SEED).random(TRIED)
    trials = [low + (high - low) * point for point in points]
    problem.forget()
    q = problem.projector()
    return sorted(trials, key=lambda trial: _left(problem, trial, q))[:STARTED]


def left(problem: Problem, theta: np.ndarray) -> float:
    """The sum of squares that is to be least."""
    return _left(problem, theta, problem.projector())


def _left(problem: Problem, theta: np.ndarray, q: np.ndarray) -> float:
    return float(np.sum(projected(q, problem.errors(theta)) ** 2))
