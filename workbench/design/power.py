"""How often the record of a whole motion tells a hypothesis from a rival: by simulated repetitions.

Both are fitted to the record of the motion with noise, beside what is known of them already; S is then what one leaves,
and the true one is told from its rival where S_rival - S_true exceeds what odds of 20 to 1 ask for. Where the rival can
do all that the true one does, it must not gain so much. Machines are drawn from what is known of the parameters.

A rival's fit is searched for in simulations, and all that noise and drawn machines change is taken to first order there.
All of that lies in the few directions in which either plant can move the record, and in their difference.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.design.contrast import replays
from workbench.design.hypotheses import Hypothesis
from workbench.design.pieces import Condition
from workbench.design.rig import Rig
from workbench.design.search import ODDS
from workbench.fitting.covariance import inverse
from workbench.simulation.run import Run

MACHINES, REPETITIONS = 200, 50
"""Machines that are drawn, and records of each."""

INTERVAL = (5.0, 95.0)
"""Percentiles of the share told apart in the repetitions of one machine."""

ROUNDS, SETTLED = 6, 1e-2
"""Steps of a rival's refit, at most, and the share of T by which one has to lower it for another."""

NEAR = 0.2
"""Of an unknown as a search sees it, to which first order reaches: no machine is drawn farther away."""

KNOWN_START = 1e-8
"""Precision of the states at a start, in units of a little change of each: next to nothing."""

SEED = 11


@dataclass(frozen=True, eq=False)
class Told:
    """Of a true hypothesis and a rival (by number): T, how far the rival's unknowns move in its refit, in their
    deviations; the share of repetitions in which the true one is told, and between which shares those of one machine
    lie.
    """

    true: int
    rival: int
    distance: float
    moved: np.ndarray
    power: float
    low: float
    high: float


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


def told_apart(rig: Rig, hypotheses: Sequence[Hypothesis], legs: Sequence[Leg], runs: Sequence[Sequence[Run]]) -> list[Told]:
    """Every ordered pair of hypotheses; `runs` are those of each hypothesis over the legs."""
    found = []
    for i, true in enumerate(hypotheses):
        seen = [rig.seen(run) for run in runs[i]]
        own = _shown(rig, true, legs, runs[i])
        for j, rival in enumerate(hypotheses):
            if j == i:
                continue
            if own is None or any(each is None for each in seen):
                continue
            record = np.concatenate([each for each in seen if each is not None])
            other = _shown(rig, rival, legs, runs[i])
            found.append(_told(rig, (i, j), (true, rival), record, (own, other), legs, runs[i]))
    return found


def _shown(rig: Rig, of: Hypothesis, legs: Sequence[Leg], runs: Sequence[Run]) -> Shown | None:
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


def _told(
    rig: Rig,
    pair: tuple[int, int],
    of: tuple[Hypothesis, Hypothesis],
    record: np.ndarray,
    shown: tuple[Shown, Shown | None],
    legs: Sequence[Leg],
    runs: Sequence[Run],
) -> Told:
    true, rival = of
    own, other = shown
    if other is None:  # its plant runs away where the true one does not
        return Told(*pair, np.inf, np.zeros(len(rival.unknowns)), 1.0, 1.0, 1.0)
    moved, left = _refitted(rig, rival, record, other, legs, runs)
    difference = left + other.columns @ moved
    theirs, mine = np.column_stack([other.columns, other.starts]), np.column_stack([own.columns, own.starts])
    basis = np.linalg.qr(np.column_stack([difference, theirs, mine]))[0]
    known = _with_starts(rival, other), _with_starts(true, own)
    shares, distance = _repeated(
        basis.T @ difference, basis.T @ theirs, basis.T @ mine, known, true, asked=-ODDS if true.is_part_of(rival) else ODDS
    )
    low, high = np.percentile(shares, INTERVAL)
    deviations = np.sqrt(np.maximum(np.diag(rival.covariance), 1e-300))
    return Told(*pair, distance, moved / deviations, float(np.mean(shares)), float(low), float(high))


def _with_starts(of: Hypothesis, shown: Shown) -> np.ndarray:
    """The precision of its unknowns and of where it starts."""
    count, more = len(of.unknowns), shown.starts.shape[1]
    whole = np.diag(np.full(count + more, KNOWN_START))
    whole[:count, :count] = of.precision
    return whole


def _refitted(
    rig: Rig, rival: Hypothesis, record: np.ndarray, shown: Shown, legs: Sequence[Leg], runs: Sequence[Run]
) -> tuple[np.ndarray, np.ndarray]:
    """How far a rival's unknowns move in its refit, and what that leaves (rows,): Gauss and Newton's steps with the
    columns of where it began, as long as they lower T.
    """
    columns = np.column_stack([shown.columns, shown.starts])
    precision = _with_starts(rival, shown)
    whole, count = inverse(columns.T @ columns + precision), len(rival.unknowns)

    def worth(moved: np.ndarray, left: np.ndarray) -> tuple[float, np.ndarray]:
        slope = columns.T @ left - precision[:, :count] @ moved
        freed = left - shown.starts @ np.linalg.lstsq(shown.starts, left, rcond=1e-9)[0] if shown.starts.size else left
        return float(freed @ freed + moved @ rival.precision @ moved), whole @ slope

    moved, left = np.zeros(count), record - shown.seen
    least, step = worth(moved, left)
    for _ in range(ROUNDS):
        reached = np.clip(moved + step[:count], *rival.room)
        replayed = [
            rig.seen(rig.replayed(rival.moved(reached), run.command, leg.condition))
            for leg, run in zip(legs, runs, strict=True)
        ]
        seen = [each for each in replayed if each is not None]
        if len(seen) < len(replayed):
            break
        other = record - np.concatenate(seen)
        found, further = worth(reached, other)
        if found >= least:
            break
        flat = found > (1.0 - SETTLED) * least
        moved, left, least, step = reached, other, found, further
        if flat:
            break
    return moved, left


def _repeated(
    difference: np.ndarray,
    theirs: np.ndarray,
    mine: np.ndarray,
    known: tuple[np.ndarray, np.ndarray],
    true: Hypothesis,
    asked: float,
) -> tuple[np.ndarray, float]:
    """The share told apart on each machine, shape (machines,), and T; all in the directions that matter."""
    draw = np.random.default_rng(SEED)
    spread = drawn_from(true)

    def left(of: np.ndarray, columns: np.ndarray, precision: np.ndarray) -> np.ndarray:
        slope = of @ columns
        return np.sum(of**2, axis=-1) - np.sum((slope @ inverse(columns.T @ columns + precision)) * slope, axis=-1)

    count = len(true.unknowns)
    machines = draw.standard_normal((MACHINES, count)) @ spread.T @ mine[:, :count].T
    noise = draw.standard_normal((MACHINES, REPETITIONS, difference.size))
    own = machines[:, None, :] + noise
    gained = left(own + difference, theirs, known[0]) - left(own, mine, known[1])
    return np.mean(gained > asked, axis=1), max(float(left(difference, theirs, known[0])), 0.0)


def drawn_from(hypothesis: Hypothesis) -> np.ndarray:
    """What makes of standard normal numbers (unknowns,) by how much the unknowns of a machine are elsewhere: by what is
    known of them, where the hypothesis's effects are as large as it says.
    """
    own = hypothesis.own
    known = hypothesis.precision[np.ix_(own, own)] + np.eye(own.size) / NEAR**2
    sizes, ways = np.linalg.eigh(inverse(known))
    spread = np.zeros((len(hypothesis.unknowns),) * 2)
    spread[np.ix_(own, own)] = ways * np.sqrt(np.maximum(sizes, 0.0))
    return spread
