"""The states at which simulations start: found beside the parameters of a plant, of each start for itself."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.diagnose.residuals.fit import NEAR_NOISE, Fit, stacked
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.residuals.weighing import Changes, weighing_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.fitting.threads import side_by_side

FIRST, LEAST, EASIER, HARDER, TRIES = 1e-3, 1e-9, 0.1, 10.0, 4
"""Damping, in units of each state's own curvature, of the first step of a start, and the least; its factors after one
that leaves less, and after one that does not; and how many are tried."""


def restarted(how: Shooting, fitted: Fit, starting: Changes, damping: np.ndarray) -> tuple[Shooting, np.ndarray]:
    """The same with the states at each start where they leave less of its piece, by what a change of them does
    (`Shooting.starting`): by a damped Gauss-Newton step, of those that a command sets only if that is better; and the
    damping of each start from which to go on.
    """
    motions, values, (columns, groups) = fitted.balance.motions, fitted.values, starting
    weigh = weighing_of(fitted.balance.series, fitted.residual) if fitted.excess < NEAR_NOISE else None
    block, left = (columns, fitted.residual) if weigh is None else (weigh(columns), weigh(fitted.residual))
    moving = [~how.follows, *([np.ones_like(how.follows)] if np.any(how.follows) else [])]
    first = squares_of(left, groups)
    least, chosen = first, np.zeros((len(groups), columns.shape[1]))
    damping = np.broadcast_to(damping, least.shape)

    def stepped(moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        each = zip(groups, damping, strict=True)
        steps = np.array([_step(moved * block[rows], left[rows], one) for rows, one in each])
        other = stacked(_begun(how, motions, values, steps).balance(motions, ()), values)
        return steps, squares_of(other if weigh is None else weigh(other), groups)

    for _ in range(TRIES):
        for steps, squares in side_by_side(stepped, moving):
            chosen = np.where((squares < least)[:, None], steps, chosen)
            least = np.minimum(least, squares)
        lower = least < first
        damping = np.where(lower, np.maximum(damping * EASIER, LEAST), damping * HARDER)
        if np.all(lower):
            break
    return _begun(how, motions, values, chosen), damping


def squares_of(residual: np.ndarray, groups: Sequence[np.ndarray]) -> np.ndarray:
    """The sum of squares of each group of rows."""
    return np.array([float(residual[rows] @ residual[rows]) for rows in groups])


def _step(block: np.ndarray, left: np.ndarray, damping: float) -> np.ndarray:
    """By how many of their moves states go where they leave least."""
    norms = np.linalg.norm(block, axis=0)
    scale = np.where(norms > 0.0, norms, 1.0)
    unit = block / scale
    return np.asarray(-np.linalg.solve(unit.T @ unit + damping * np.eye(scale.size), unit.T @ left) / scale)


def _begun(how: Shooting, motions: Sequence[Motion], values: Values, steps: np.ndarray) -> Shooting:
    """The same with its starts moved by so many moves of each state, shape (starts of all records, moves)."""
    begins, at = dict(how.begins), 0
    for motion in motions:
        moves, count = np.array(how.moves(motion, values)), len(how.starts(motion))
        reach, begin = how.reach(motion, values), begins.get(motion.record, 0.0) + steps[at : at + count] @ moves
        begins[motion.record] = np.clip(begin, -reach, reach)
        at += count
    return replace(how, begins=begins)
