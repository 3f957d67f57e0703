"""Nonlinear least squares within bounds, through the normal equations: a tall Jacobian is multiplied once a step.

Levenberg and Marquardt's damping, in units of each unknown's own curvature, so that no unit decides; an unknown at a
bound that the gradient pushes outward is held there (Kanzow, Yamashita and Fukushima 2004). A step along a valley that
curves is bent as the valley is (Transtrum and Sethna 2012). A Jacobian that a step foresaw well is corrected by what it
showed (Broyden 1965) before differences are taken again.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.fitting.threads import side_by_side

EASIER, HARDER = 0.2, 4.0
"""Factors of the damping after a step that gained what was expected, and after one that did not."""

FIRST, LEAST, MOST = 1e-4, 1e-12, 1e8
"""Damping at first, and between which values."""

ACTIVE = 4
"""Times the number of unknowns that one is held at a bound, or let go, at most."""

ROUNDING = 1e-12
"""Of an unknown's own curvature: keeps two that records cannot tell apart from running away together."""

POOR, GOOD = 0.1, 0.7
"""Shares of the expected gain below which the damping rises, and from which it falls."""

MOVED, SHORTEST = 10.0, 1e-8
"""Standard deviations of a residual's entry by which difference quotients move it in all; share of the longest step
that the shortest has."""

OFF, TRIED = 10.0, 2
"""Times the step that would be felt, or a part of it, from which a first quotient is taken once more, and how often:
far beyond it a residual shows its jumps, far below it a solver's error."""

FORESEEN = 0.4
"""Share of the expected gain from which a Jacobian is learnt."""

BENDS = 3
"""Times that a step near noise is bent, at most, which does not gain what was expected."""

SETTLED, NEAR = 0.1, 3.0
"""Gain of a step below which a search ends at the latest, of one whose residual has an rms of at most so many standard
deviations of noise: twice the logarithm of a likelihood, which a third of an unknown's deviation changes by so much."""


@dataclass(frozen=True)
class Search:
    """When a search ends: a step gains less of the sum of squares (near noise than is worth it, if that is less), or
    there were many; and the largest `step` of a difference quotient, of an unknown or of 1, whichever is larger.

    Where difference quotients are dear a search `learns`: a step whose gain was foreseen corrects the Jacobian, which
    is then no exact one, at the end either. A residual that is `rugged` is never near noise, whatever it weighs.
    """

    flat: float = 1e-7
    most_steps: int = 100
    learns: bool = False
    step: float = 1e-4
    rugged: bool = False

    def is_near(self, cost: float, rows: int) -> bool:
        """Whether a sum of squares over so many rows is near to that of noise: farther off residuals are rugged, and
        long steps lead into hollows.
        """
        return not self.rugged and cost < NEAR**2 * rows

    def least(self, cost: float, rows: int) -> float:
        """Gain of a step below which a search ends at a sum of squares `cost`."""
        return min(self.flat * cost, SETTLED if self.is_near(cost, rows) else np.inf)


@dataclass(frozen=True, eq=False)
class Solution:
    """The unknowns `x` at the least sum of squares, the residual there, its Jacobian, and which unknowns are free: 0 of
    a row where one is held at a bound.
    """

    x: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray
    free: np.ndarray


Residual = Callable[[np.ndarray], np.ndarray]

Residuals = Callable[[Sequence[np.ndarray]], Sequence[np.ndarray]]
"""A residual at several places at once."""


def one_by_one(residual: Residual) -> Residuals:
    """A residual at several places, each for itself, in threads."""
    return lambda places: side_by_side(residual, places)


def jacobian_of(
    residuals: Residuals, x: np.ndarray, base: np.ndarray, steps: np.ndarray, which: Sequence[int] | None = None
) -> np.ndarray:
    """Forward differences of a residual (rows) over `steps` of each unknown, or of those `which`, shape (rows,
    unknowns).
    """
    asked = range(x.size) if which is None else which
    if not len(asked):
        return np.zeros((base.size, 0))
    return _quotients(base, residuals(_moved(x, steps, asked)), steps[asked])


def _moved(x: np.ndarray, steps: np.ndarray, which: Sequence[int]) -> list[np.ndarray]:
    """The places at which each of these unknowns is moved by its step."""
    places = [x.copy() for _ in which]
    for place, i in zip(places, which, strict=True):
        place[i] += steps[i]
    return places


def _quotients(base: np.ndarray, moved: Sequence[np.ndarray], steps: np.ndarray) -> np.ndarray:
    """Difference quotients of residuals at places that are moved by steps."""
    return np.column_stack([(new - base) / step for new, step in zip(moved, steps, strict=True)])


def least_squares(
    residuals: Residuals,
    start: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    search: Search,
    longest: np.ndarray | float = 0.0,
) -> Solution:
    """The unknowns between `low` and `high` at which the sum of squares of a residual is least.

    Args:
        residuals: of the unknowns at several places, each of shape (rows,), in standard deviations of noise; finite.
        start: shape (unknowns,), within the bounds.
        low, high: shape (unknowns,), infinite where there is none.
        search: when it ends.
        longest: steps up to which difference quotients may go where the search's own are too short to be felt.
    """
    x = np.asarray(start, dtype=float)
    if not x.size:
        (base,) = residuals([x])
        return Solution(x, base, np.zeros((base.size, 0)), np.ones(0, dtype=bool))
    base, jacobian = _first_jacobian(residuals, x, high, search.step, longest)
    damping, cost = FIRST, float(base @ base)

    def steps_of(x: np.ndarray, jacobian: np.ndarray, cost: float) -> np.ndarray:
        return differences(x, high, search.step, jacobian, cost, longest)

    evaluations, fresh = 1, True
    while evaluations < search.most_steps:
        way = _Way(residuals, x, base, jacobian, damping, low, high)
        trial, new, bends = way.bent(BENDS if search.is_near(cost, base.size) else 0)
        evaluations += 1
        gained, expected, least = cost - float(new @ new), way.expected, search.least(cost, base.size)
        if gained > 0.0:
            flat = gained < least
            shown, step = new - base, trial - x
            x, base, cost = trial, new, cost - gained
            ends = flat and fresh
            learnt = search.learns and not bends and gained > FORESEEN * expected
            fresh = not learnt or (flat and not ends)
            if fresh:
                jacobian = jacobian_of(residuals, x, base, steps_of(x, jacobian, cost))
            else:
                jacobian = jacobian + np.outer(shown - jacobian @ step, step / (step @ step))
            if ends:
                break
        elif not fresh:
            fresh, jacobian = True, jacobian_of(residuals, x, base, steps_of(x, jacobian, cost))
        elif expected < least or damping >= MOST:
            break
        share = gained / expected if expected > 0.0 else 0.0
        if share < POOR:
            damping = min(damping * HARDER, MOST)
        elif share > GOOD:
            damping = max(damping * EASIER, LEAST)
    pushed = -(jacobian.T @ base)
    held = ((x <= low) & (pushed < 0.0)) | ((x >= high) & (pushed > 0.0))
    return Solution(x, base, jacobian, ~held)


def _first_jacobian(
    residuals: Residuals, x: np.ndarray, high: np.ndarray, step: float, longest: np.ndarray | float
) -> tuple[np.ndarray, np.ndarray]:
    """The residual, and its Jacobian, of steps of which nothing is known yet, and of those that turn out to be far off
    of better ones.
    """
    steps = _within(x, high, step * np.maximum(1.0, np.abs(x)))
    base, *moved = residuals([x, *_moved(x, steps, range(x.size))])
    jacobian, cost = _quotients(base, moved, steps), float(base @ base)
    for _ in range(TRIED):
        felt = differences(x, high, step, jacobian, cost, longest)
        share = np.abs(felt / steps)
        again = np.flatnonzero((share > OFF) | (share < 1.0 / OFF)).tolist()
        if not again:
            break
        steps[again] = felt[again]
        jacobian[:, again] = jacobian_of(residuals, x, base, steps, again)
    return base, jacobian


def differences(
    x: np.ndarray,
    high: np.ndarray,
    step: float,
    jacobian: np.ndarray,
    cost: float,
    longest: np.ndarray | float = 0.0,
) -> np.ndarray:
    """Steps of difference quotients that move the residual by a few of its standard deviations, and are `step` at most,
    or `longest` where that is more: an unknown that is known to a millionth is not to be moved by a thousandth.
    """
    with np.errstate(over="ignore"):  # what moves nothing goes as far as it may
        felt = MOVED * np.sqrt(cost / jacobian.shape[0]) / np.maximum(np.linalg.norm(jacobian, axis=0), 1e-300)
    most = np.maximum(step * np.maximum(1.0, np.abs(x)), longest)
    return _within(x, high, np.clip(felt, SHORTEST * most, most))


def _within(x: np.ndarray, high: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Steps that are taken backward where there is no room forward."""
    return np.where(x + steps < high, steps, -steps)


@dataclass(frozen=True, eq=False)
class _Way:
    """From `x`, whose residual is `base`, the damped Gauss-Newton step within bounds, and where it leads."""

    residuals: Residuals
    x: np.ndarray
    base: np.ndarray
    jacobian: np.ndarray
    damping: float
    low: np.ndarray
    high: np.ndarray

    @cached_property
    def gradient(self) -> np.ndarray:
        """Half that of the sum of squares."""
        return np.asarray(self.jacobian.T @ self.base)

    @cached_property
    def damped(self) -> np.ndarray:
        """Curvature with damping."""
        curvature = self.jacobian.T @ self.jacobian
        own = np.diag(curvature)
        return np.asarray(curvature + self.damping * np.diag(np.where(own > 0.0, own, 1.0)))

    @cached_property
    def step(self) -> np.ndarray:
        """The step."""
        return bounded_minimum(self.damped, self.gradient, self.low - self.x, self.high - self.x)

    @property
    def expected(self) -> float:
        """By how much the step should lower the sum of squares."""
        return float(-2.0 * self.gradient @ self.step - self.step @ (self.damped @ self.step))

    def bent(self, most: int) -> tuple[np.ndarray, np.ndarray, int]:
        """Where the step leads, the residual there, and how often it was bent, at `most`: by the Gauss-Newton step that
        takes away what curvature adds to the residual, as long as that leaves less and the step gains less than was
        expected.
        """
        cost, bends = float(self.base @ self.base), 0
        place, found = self._at(self.step)
        while bends < most and cost - found @ found < GOOD * self.expected:
            off = found - self.base - self.jacobian @ (place - self.x)
            bend = bounded_minimum(self.damped, self.jacobian.T @ off, self.low - place, self.high - place)
            if self._length(bend) > self._length(self.step):
                break
            other, left = self._at(place + bend - self.x)
            if not left @ left < found @ found:
                break
            place, found, bends = other, left, bends + 1
        return place, found, bends

    def _length(self, step: np.ndarray) -> float:
        """Of a step squared, each unknown by its own curvature."""
        return float(step @ (np.diag(self.damped) * step))

    def _at(self, step: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        place = np.clip(self.x + step, self.low, self.high)
        return place, self.residuals([place])[0]


def bounded_minimum(curvature: np.ndarray, slope: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """x between `low` and `high`, which have 0 between them, where slope' x + x' curvature x / 2 is least: what would
    go farthest beyond its bound is held there, and let go where that was too early.
    """
    scale = np.sqrt(np.maximum(np.diag(curvature), 0.0))
    scale[scale == 0.0] = 1.0
    h, g = curvature / np.outer(scale, scale) + ROUNDING * np.eye(slope.size), slope / scale
    least, most = low * scale, high * scale
    free, x = np.ones(slope.size, dtype=bool), np.zeros(slope.size)
    for _ in range(ACTIVE * slope.size):
        x[free] = np.linalg.solve(h[np.ix_(free, free)], -(g[free] + h[np.ix_(free, ~free)] @ x[~free]))
        beyond = np.where(free, np.maximum(least - x, x - most), -np.inf)
        worst = int(np.argmax(beyond))
        if beyond[worst] > 0.0:
            x[worst] = np.clip(x[worst], least[worst], most[worst])
            free[worst] = False
            continue
        rising = g + h @ x  # inward at a bound: it was held too early
        inward = np.where(free, -np.inf, np.where(x <= least, -rising, rising))
        let_go = int(np.argmax(inward))
        if inward[let_go] <= ROUNDING * float(np.max(np.abs(g), initial=0.0)):
            break
        free[let_go] = True
    return np.asarray(np.clip(x, least, most) / scale)
