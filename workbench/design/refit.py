"""The refit of a hypothesis to a record that another plant has made: its unknowns, and where it starts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plants.equation import NEGATIVE
from workbench.design.contrast import replays
from workbench.design.hypotheses import Hypothesis
from workbench.design.pieces import Condition
from workbench.design.rig import Replay, Rig
from workbench.fitting.covariance import inverse
from workbench.fitting.least_squares import Residuals, Search, least_squares
from workbench.parameters.sets import NEUTRAL
from workbench.simulation.run import Run

STEPS = (1.0, 1.0, 0.3, 1.0, 1.0, 0.3, 1.0, 0.1)
"""Shares of Gauss and Newton's steps, which a refit tries one after the other."""

SETTLED = 0.1
"""By which a step has to lower the squares for another."""

FOUND = 1.0
"""Squares below which a refit need not be bettered."""

MOST_STEPS = 40_000
"""Of the solver, for a motion, up to which a refit is searched for: some seconds for a few hundred simulations."""

GROWING = (0.05, 0.15, 0.4, 1.0)
"""Shares of each leg to which a refit is made, one from where the other has led: errors of a plant that nothing leads
add up, and the end of a run that went astray shows nothing."""

REFIT = Search(flat=1e-5, most_steps=60, learns=True, step=1e-5)
"""When the search of one ends."""

LOST = 1e3
"""Standard deviations in the place of what a diverging plant leaves."""


@dataclass(frozen=True, eq=False)
class Leg:
    """A part of a motion that is run in one go: its reference (samples,), under which condition."""

    reference: np.ndarray
    condition: Condition


@dataclass(frozen=True, eq=False)
class Shown:
    """A hypothesis under the commands of another one: what it shows (rows,), its own columns, those of its starts."""

    seen: np.ndarray
    columns: np.ndarray
    starts: np.ndarray


@dataclass(frozen=True, eq=False)
class Refit:
    """What a hypothesis's refit leaves of a record, squared with what is known of its unknowns; how far these have
    moved, what is left (rows,), and the steps that the solver took.
    """

    squares: float
    moved: np.ndarray
    left: np.ndarray
    steps: int


def started(of: Hypothesis, true: Hypothesis, away: Mapping[str, float]) -> np.ndarray:
    """Where the refit of a hypothesis begins (unknowns,) on a machine that is so far `away` from the true one, by name:
    there, in each direction; of a hypothesis that can do all that the true one does without its effect.
    """
    own, shift = set(of.own.tolist()), np.zeros(len(of.unknowns))
    for k, unknown in enumerate(of.unknowns):
        plain = unknown.name.removesuffix(f"_{NEGATIVE}")
        if k not in own and true.is_part_of(of) and not unknown.logarithmic:
            shift[k] = unknown.place(NEUTRAL.get(unknown.name, 0.0)) - of.places[k]
        else:
            shift[k] = away.get(unknown.name, away.get(plain, 0.0))
    return np.clip(shift, *of.room)


def shown_along(rig: Rig, of: Hypothesis, legs: Sequence[Leg], runs: Sequence[Run]) -> Shown | None:
    """A hypothesis along the commands of some runs; None where it diverges."""
    seen, columns, starts = list[np.ndarray](), list[np.ndarray](), list[np.ndarray]()
    count = len(of.unknowns)
    for leg, run in zip(legs, runs, strict=True):
        base, changes, _ = replays(rig, of, run, leg.condition, starts=True)
        if base is None:
            return None
        seen.append(base)
        columns.append(changes[:, :count])
        starts.append(changes[:, count:])
    rows = np.cumsum([0, *(part.shape[0] for part in starts)])
    apart = np.zeros((rows[-1], sum(part.shape[1] for part in starts)))
    at = 0
    for first, part in zip(rows[:-1].tolist(), starts, strict=True):
        apart[first : first + part.shape[0], at : at + part.shape[1]] = part
        at += part.shape[1]
    return Shown(np.concatenate(seen), np.concatenate(columns), apart)


def refitted(
    rig: Rig,
    of: Hypothesis,
    record: np.ndarray,
    shown: Shown,
    legs: Sequence[Leg],
    runs: Sequence[Run],
    start: np.ndarray,
    found: float = FOUND,
) -> Refit:
    """The refit of a hypothesis to a record.

    Gauss and Newton's steps from a `start` with the columns of the hypothesis, as long as they lower the squares; where
    they leave so much that it would be told, a search with columns of its own: far from where they were taken columns
    lead nowhere, and what is not found there passes for a difference. Squares below `found` need not be bettered.
    """
    columns = np.column_stack([shown.columns, shown.starts])
    precision = of.precision_with(shown.starts.shape[1])
    whole, count = inverse(columns.T @ columns + precision), len(of.unknowns)
    begins = np.linalg.qr(shown.starts)[0]
    steps = list[int]()

    def worth(moved: np.ndarray, left: np.ndarray) -> tuple[float, np.ndarray]:
        slope = columns.T @ left - precision[:, :count] @ moved
        freed = left - begins @ (begins.T @ left)
        return float(freed @ freed + moved @ of.precision @ moved), whole @ slope

    def lefts_at(places: Sequence[np.ndarray]) -> list[np.ndarray | None]:
        ways = [(run, leg.condition) for leg, run in zip(legs, runs, strict=True)]
        played = rig.replayed([Replay(of.moved(moved), *way) for moved in places for way in ways])
        steps.extend(each.steps for each in played)
        seen, lefts = [rig.seen(each) for each in played], list[np.ndarray | None]()
        for at in range(0, len(seen), len(ways)):
            whole = [each for each in seen[at : at + len(ways)] if each is not None]
            lefts.append(record - np.concatenate(whole) if len(whole) == len(ways) else None)
        return lefts

    moved = np.clip(start, *of.room)
    (begun,) = lefts_at([moved])
    left = record - shown.seen if begun is None else begun
    least, step = worth(moved, left)
    for share in STEPS:
        reached = np.clip(moved + share * step[:count], *of.room)
        (other,) = lefts_at([reached])
        if other is None:
            continue
        squares, further = worth(reached, other)
        if squares < least:
            flat = squares > least - SETTLED
            moved, left, least, step = reached, other, squares, further
            if flat:
                break
    if least < found or not can_search(runs):
        return Refit(least, moved, left, sum(steps))
    sizes, ways = np.linalg.eigh(of.precision)
    known = (ways * np.sqrt(np.maximum(sizes, 0.0))).T

    def residuals(rows: np.ndarray) -> Residuals:
        """Of the unknowns: what is left in some rows that no start makes up for, and what moving the unknowns costs."""
        begins = np.linalg.qr(shown.starts[rows])[0]

        def left_in(at: np.ndarray, left: np.ndarray | None) -> np.ndarray:
            part = np.full(int(np.sum(rows)), LOST) if left is None else left[rows]
            return np.concatenate([part - begins @ (begins.T @ part), known @ at])

        return lambda places: list(map(left_in, places, lefts_at(places)))

    at = np.clip(start, *of.room)
    for share in GROWING:
        solution = least_squares(residuals(_early(rig, legs, share)), at, *of.room, REFIT)
        at = solution.x
    squares, (there,) = float(solution.residual @ solution.residual), lefts_at([at])
    if there is not None and squares < least:
        return Refit(squares, at, there, sum(steps))
    return Refit(least, moved, left, sum(steps))


def can_search(runs: Sequence[Run]) -> bool:
    """Whether a motion that takes the solver as long as these runs is simulated soon enough to be searched for a refit,
    and for the columns of where that ends.
    """
    return sum(run.steps for run in runs) <= MOST_STEPS


def _early(rig: Rig, legs: Sequence[Leg], share: float) -> np.ndarray:
    """Which rows of a record are in the first share of each leg."""
    counts = [-(-leg.reference.size // rig.grain) for leg in legs]
    return np.concatenate([np.tile(np.arange(count) < share * count, len(rig.channels)) for count in counts])
