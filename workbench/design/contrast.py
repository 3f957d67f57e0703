"""How far hypotheses are apart in a record: what is left of their difference once the rival has been fitted to it.

Of a plant i whose record shows y_i under a command u, a rival j foresees y_j(u). It may move its unknowns d, which are
known with a precision P; to first order in them it is off by

    T = min over d of |y_i - y_j(u) - J_j d|^2 + d' P d        in standard deviations of the sensors' noise,

twice the expected logarithm of the ratio of both likelihoods (Atkinson and Fedorov 1975: T-optimal designs). Squares
and slopes of pieces of a motion add up, so that those of a sum of pieces need no further simulation.

Behind the unknowns stand the states in which a motion starts, which nobody knows. All pieces have them in common: what
lasts of them, such as the place, is the same in each; what does not last tells little in any.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.design.hypotheses import Hypothesis, truths_of
from workbench.design.pieces import Condition, Piece, sampled
from workbench.design.rig import Replay, Rig
from workbench.fitting.least_squares import bounded_minimum
from workbench.fitting.threads import side_by_side
from workbench.simulation.run import Run

Pair = tuple[int, int]
"""By number: the hypothesis that is true, among `truths_of` all, and its rival."""


@dataclass(frozen=True, eq=False)
class Contrast:
    """Squares |r|^2 of a difference r, slope J' r and curvature J' J over the rival's unknowns and where it starts."""

    squares: float
    slope: np.ndarray
    curvature: np.ndarray

    @classmethod
    def of(cls, difference: np.ndarray, columns: np.ndarray) -> "Contrast":
        """That of a difference (rows,) and of what the rival's unknowns and its starts change (rows, numbers)."""
        return cls(float(difference @ difference), columns.T @ difference, columns.T @ columns)

    def __add__(self, other: "Contrast") -> "Contrast":
        return Contrast(self.squares + other.squares, self.slope + other.slope, self.curvature + other.curvature)

    def refitted(self, rival: Hypothesis) -> tuple[float, np.ndarray]:
        """T, and how far the rival's unknowns and its starts move."""
        starts = self.slope.size - len(rival.unknowns)
        whole = self.curvature + rival.precision_with(starts)
        (low, high), endless = rival.room, np.full(starts, np.inf)
        moved = bounded_minimum(whole, -self.slope, np.append(low, -endless), np.append(high, endless))
        return max(float(self.squares - 2.0 * self.slope @ moved + moved @ whole @ moved), 0.0), moved


@dataclass(frozen=True, eq=False)
class Tried:
    """A piece of a motion: which limit it exceeds under some hypothesis, in words, else its contrasts; the information
    on the unknowns of the first hypothesis and its starts, if that was asked; and the steps that the solver took.
    """

    piece: Piece
    beyond: str
    contrasts: Mapping[Pair, Contrast]
    information: np.ndarray
    steps: int


def pairs_of(hypotheses: Sequence[Hypothesis]) -> list[Pair]:
    """All pairs in which the rival cannot do all that the true one does."""
    return [
        (i, j)
        for i, true in enumerate(truths_of(hypotheses))
        for j, rival in enumerate(hypotheses)
        if true.effects != rival.effects and not true.is_part_of(rival)
    ]


def tried(rig: Rig, hypotheses: Sequence[Hypothesis], piece: Piece, *, informs: bool) -> Tried:
    """A piece under all that may be true, and what every rival makes of it."""
    reference, condition = sampled(piece, rig.reach), piece.condition
    size = len(hypotheses[0].unknowns) + len(rig.moves())
    runs = side_by_side(lambda one: rig.driven(one.values, reference, condition), truths_of(hypotheses))
    steps = sum(run.steps for run in runs)
    nothing = np.zeros((size, size))
    if beyond := next((said for run in runs if (said := rig.beyond(run))), ""):
        return Tried(piece, beyond, {}, nothing, steps)
    contrasts = dict[Pair, Contrast]()
    for i, j in pairs_of(hypotheses):
        shown, columns, more = replays(rig, hypotheses[j], runs[i], condition, starts=True)
        steps += more
        seen = rig.seen(runs[i])
        if seen is None or shown is None:
            return Tried(piece, "a rival's plant runs away", {}, nothing, steps)
        contrasts[i, j] = Contrast.of(seen - shown, columns)
    if not informs:
        return Tried(piece, "", contrasts, nothing, steps)
    _, columns, more = replays(rig, hypotheses[0], runs[0], condition, starts=True)
    return Tried(piece, "", contrasts, columns.T @ columns, steps + more)


def replays(
    rig: Rig, of: Hypothesis, run: Run, condition: Condition, *, starts: bool = False
) -> tuple[np.ndarray | None, np.ndarray, int]:
    """What a hypothesis shows under a run's command, None where it diverges; what its unknowns change of that, a column
    each, 0 where that diverges, and behind them with `starts` what the states do in which it begins; and the steps.
    """
    changes = [of.moved(step * one) for one, step in zip(np.eye(len(of.unknowns)), of.steps, strict=True)]
    asked = [Replay(values, run, condition) for values in (of.values, *changes)]
    sizes = of.steps.tolist()
    if starts:
        moves = rig.moves()
        asked += [Replay(of.values, run, condition, move) for move in (np.zeros_like(moves[0]), *moves)]
        sizes += [1.0] * len(moves)
    replayed = rig.replayed(asked)
    steps = sum(one.steps for one in replayed)
    base, *others = (rig.seen(one) for one in replayed)
    if base is None:
        return None, np.zeros((0, len(sizes))), steps
    bases = [base] * len(of.unknowns)
    if starts:  # of the plant with all its states, whose solver takes other steps
        own = others.pop(len(of.unknowns))
        bases += [base if own is None else own] * len(moves)
    columns = [
        np.zeros_like(base) if other is None else (other - before) / size
        for other, before, size in zip(others, bases, sizes, strict=True)
    ]
    return base, np.column_stack(columns) if columns else np.zeros((base.size, 0)), steps
