"""Descent in a rugged sum of squares: Gauss-Newton steps along slopes that are seen over wide differences.

Where a contact breaks away now and then, a long simulation's error is full of hollows, each as steep as the landscape
is as a whole, and a search that follows slopes ends in the next one. A central difference over a wide step does not see
what is narrower (steps of implicit filtering: Kelley 2011, here with a Gauss-Newton model); of many lengths of a step
the best is taken, wherever that leads.
"""

import numpy as np

from workbench.fitting.least_squares import Residuals

WIDTHS = (0.3, 0.1, 0.03, 0.01)
"""Steps of a difference quotient, of an unknown or of 1, whichever is larger: from the widest."""

DAMPINGS, LENGTHS = (1e-4, 1e-2, 0.1, 1.0, 10.0), (1.0, 0.4)
"""In units of each unknown's own curvature; shares of each step that are tried."""

FARTHEST = 2.0
"""By which an unknown moves in a step, or times its size, at most."""

FELL, ROUNDS = 0.99, 20
"""Share of the sum of squares that a step leaves at most, if another is made with such quotients; and their number."""


def descend(residuals: Residuals, start: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Unknowns between `low` and `high` with a lower sum of squares of a residual than at `start`, shape (unknowns,).

    Every point that is looked at may be the next, those of the quotients, too.
    """
    x = np.clip(np.asarray(start, dtype=float), low, high)
    (base,) = residuals([x])
    for width in WIDTHS if x.size else ():
        for _ in range(ROUNDS):
            sides = _sides(x, width, low, high)
            seen = list(residuals(sides))
            jacobian = np.column_stack(
                [
                    (after - before) / max(float(np.max(np.abs(up - down))), np.finfo(float).tiny)
                    for down, up, before, after in zip(sides[::2], sides[1::2], seen[::2], seen[1::2], strict=True)
                ]
            )
            steps = _steps(x, base, jacobian, low, high)
            seen += residuals(steps)
            squares = [float(one @ one) for one in seen]
            best = int(np.argmin(squares))
            if not squares[best] < FELL * float(base @ base):
                break
            x, base = [*sides, *steps][best], seen[best]
    return x


def _sides(x: np.ndarray, width: float, low: np.ndarray, high: np.ndarray) -> list[np.ndarray]:
    """Points on both sides of each unknown, as far as its bounds go."""
    sides = list[np.ndarray]()
    for place, size in enumerate(width * np.maximum(np.abs(x), 1.0)):
        for way in (-size, size):
            sides.append(x.copy())
            sides[-1][place] = np.clip(x[place] + way, low[place], high[place])
    return sides


def _steps(
    x: np.ndarray, base: np.ndarray, jacobian: np.ndarray, low: np.ndarray, high: np.ndarray
) -> list[np.ndarray]:
    """Points to which steps of all dampings and lengths lead."""
    curvature, slope = jacobian.T @ jacobian, jacobian.T @ base
    scale = np.sqrt(np.maximum(np.diag(curvature), np.finfo(float).tiny))
    curvature, slope = curvature / np.outer(scale, scale), slope / scale
    points, limit = list[np.ndarray](), FARTHEST * np.maximum(np.abs(x), 1.0)
    for damping in DAMPINGS:
        step = -np.linalg.solve(curvature + damping * np.eye(x.size), slope) / scale
        points += [np.clip(x + np.clip(share * step, -limit, limit), low, high) for share in LENGTHS]
    return points
