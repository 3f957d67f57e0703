"""How often the record of a whole motion tells a hypothesis from a rival: by simulated repetitions.

Both are fitted to the record of the motion with noise, beside what is known of them already; S is then what one leaves,
and the true one is told from its rival where S_rival - S_true exceeds what odds of 20 to 1 ask for. Where the rival can
do all that the true one does, it must not gain so much. Machines are drawn from what is known of the parameters.

The rival's fit is searched for in simulations of each machine, and what noise changes of either is taken to first
order: it lies in the few directions in which a plant can move the record, and in their differences.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.design.contrast import replays
from workbench.design.hypotheses import Hypothesis
from workbench.design.pieces import Condition
from workbench.design.rig import Rig
from workbench.design.search import ODDS
from workbench.fitting.covariance import inverse
from workbench.fitting.threads import side_by_side
from workbench.simulation.run import Run

MACHINES, SHARES, REPETITIONS = 4, 50, 50
"""Machines that are drawn and simulated, shares of repeated records that are counted on each, and records of each."""

INTERVAL = (5.0, 95.0)
"""Percentiles of the share told apart in the repetitions of one machine."""

STEPS = (1.0, 1.0, 0.3, 1.0, 1.0, 0.3, 1.0, 0.1)
"""Shares of Gauss and Newton's steps, which a refit tries one after the other."""

SETTLED = 0.1
"""By which a step has to lower the squares for another."""

NEAR = 0.2
"""Of an unknown as a search sees it, to which first order reaches: no machine is drawn farther away."""

KNOWN_START = 1e-8
"""Precision of the states at a start, in units of a little change of each: next to nothing."""

SEED = 11


@dataclass(frozen=True, eq=False)
class Told:
    """Of a true hypothesis and a rival (by number): T, how far the rival's unknowns move in its refit, in their
    deviations; the share of repetitions in which the true one is told, and between which shares those of one machine
    lie; what the refitted rival leaves of a record without noise (rows,), as `Rig.seen` has them, leg by leg.
    """

    true: int
    rival: int
    distance: float
    moved: np.ndarray
    power: float
    low: float
    high: float
    left: np.ndarray


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
class Machine:
    """A machine as its record would be without noise, the runs that made it, leg by leg, and how far it is from the
    hypothesis that it is drawn of, by name of the unknown, as a search sees them.
    """

    record: np.ndarray
    runs: Sequence[Run]
    away: Mapping[str, float]


def told_apart(
    rig: Rig, hypotheses: Sequence[Hypothesis], legs: Sequence[Leg], runs: Sequence[Sequence[Run]]
) -> list[Told]:
    """Every ordered pair of hypotheses; `runs` are those of each hypothesis over the legs."""
    found = []
    for i, true in enumerate(hypotheses):
        nowhere = np.zeros(len(true.unknowns))
        machines = [one for one in (_machine(rig, true, nowhere, runs[i]), *_drawn(rig, true, legs)) if one is not None]
        own = shown_along(rig, true, legs, runs[i])
        if own is None or not machines:
            continue
        mine = [own.columns @ np.array(list(machine.away.values())) for machine in machines]
        for j, rival in enumerate(hypotheses):
            if j != i:
                other = shown_along(rig, rival, legs, runs[i])
                theirs = None if other is None else _left_of(rig, rival, other, legs, machines)
                found.append(_told((i, j), (true, rival), (own, other), (mine, theirs)))
    return found


def _machine(rig: Rig, of: Hypothesis, away: np.ndarray, runs: Sequence[Run]) -> Machine | None:
    """A machine by its runs; None where it diverged."""
    seen = [shown for run in runs if (shown := rig.seen(run)) is not None]
    by_name = dict(zip((u.name for u in of.unknowns), away.tolist(), strict=True))
    return Machine(np.concatenate(seen), runs, by_name) if len(seen) == len(runs) else None


def _drawn(rig: Rig, true: Hypothesis, legs: Sequence[Leg]) -> list[Machine | None]:
    """Machines that a hypothesis may be."""
    draw = np.random.default_rng(SEED)
    places = draw.standard_normal((MACHINES, len(true.unknowns))) @ drawn_from(true).T

    def driven(away: np.ndarray) -> Machine | None:
        values = true.moved(away)
        return _machine(rig, true, away, [rig.driven(values, leg.reference, leg.condition) for leg in legs])

    return side_by_side(driven, places)


def _left_of(
    rig: Rig, of: Hypothesis, shown: Shown, legs: Sequence[Leg], machines: Sequence[Machine]
) -> list[tuple[np.ndarray, np.ndarray]]:
    """For each machine how far a rival moves in its refit, and what it leaves without what that took away."""

    def left(machine: Machine) -> tuple[np.ndarray, np.ndarray]:
        start = np.array([machine.away.get(unknown.name, 0.0) for unknown in of.unknowns])
        _, moved, left = refitted(rig, of, machine.record, shown, legs, machine.runs, start)
        return moved, left + shown.columns @ moved

    return side_by_side(left, machines)


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


def _told(
    pair: tuple[int, int],
    of: tuple[Hypothesis, Hypothesis],
    shown: tuple[Shown, Shown | None],
    off: tuple[list[np.ndarray], list[tuple[np.ndarray, np.ndarray]] | None],
) -> Told:
    (true, rival), (own, other) = of, shown
    if other is None or off[1] is None:  # its plant runs away where the true one does not
        return Told(*pair, np.inf, np.zeros(len(rival.unknowns)), 1.0, 1.0, 1.0, np.zeros(own.seen.size))
    mine, theirs = (np.column_stack([one.columns, one.starts]) for one in (own, other))
    whole = [np.column_stack(off[0]), np.column_stack([each for _, each in off[1]]), mine, theirs]
    basis = np.linalg.qr(np.column_stack(whole))[0]
    within = [basis.T @ each for each in whole]
    known = _with_starts(true, own), _with_starts(rival, other)
    asked = -ODDS if true.is_part_of(rival) else ODDS
    shares, distance = _repeated((within[0], within[1]), (within[2], within[3]), known, asked)
    low, high = np.percentile(shares, INTERVAL)
    deviations = np.sqrt(np.maximum(np.diag(rival.covariance), 1e-300))
    moved, first = off[1][0]
    left = first - other.columns @ moved
    return Told(*pair, distance, moved / deviations, float(np.mean(shares)), float(low), float(high), left)


def _with_starts(of: Hypothesis, shown: Shown) -> np.ndarray:
    """The precision of its unknowns and of where it starts."""
    count, more = len(of.unknowns), shown.starts.shape[1]
    whole = np.diag(np.full(count + more, KNOWN_START))
    whole[:count, :count] = of.precision
    return whole


def refitted(
    rig: Rig,
    of: Hypothesis,
    record: np.ndarray,
    shown: Shown,
    legs: Sequence[Leg],
    runs: Sequence[Run],
    start: np.ndarray,
) -> tuple[float, np.ndarray, np.ndarray]:
    """What a hypothesis's refit leaves of a record, squared with what is known of its unknowns; how far these move, and
    what is left (rows,): Gauss and Newton's steps from a `start` with the columns of the hypothesis, as long as they
    lower the squares.
    """
    columns = np.column_stack([shown.columns, shown.starts])
    precision = _with_starts(of, shown)
    whole, count = inverse(columns.T @ columns + precision), len(of.unknowns)
    begins = np.linalg.qr(shown.starts)[0]

    def worth(moved: np.ndarray, left: np.ndarray) -> tuple[float, np.ndarray]:
        slope = columns.T @ left - precision[:, :count] @ moved
        freed = left - begins @ (begins.T @ left)
        return float(freed @ freed + moved @ of.precision @ moved), whole @ slope

    def left_at(moved: np.ndarray) -> np.ndarray | None:
        seen = [
            rig.seen(rig.replayed(of.moved(moved), run.command, leg.condition))
            for leg, run in zip(legs, runs, strict=True)
        ]
        whole = [each for each in seen if each is not None]
        return record - np.concatenate(whole) if len(whole) == len(seen) else None

    moved = np.clip(start, *of.room)
    begun = left_at(moved)
    left = record - shown.seen if begun is None else begun
    least, step = worth(moved, left)
    for share in STEPS:
        reached = np.clip(moved + share * step[:count], *of.room)
        other = left_at(reached)
        if other is None:
            continue
        found, further = worth(reached, other)
        if found < least:
            flat = found > least - SETTLED
            moved, left, least, step = reached, other, found, further
            if flat:
                break
    return least, moved, left


def _repeated(
    off: tuple[np.ndarray, np.ndarray],
    columns: tuple[np.ndarray, np.ndarray],
    known: tuple[np.ndarray, np.ndarray],
    asked: float,
) -> tuple[np.ndarray, float]:
    """Shares of repetitions that tell the true hypothesis, shape (machines, shares), and T of the first machine. By
    what the true one and its rival are `off` (directions, machines), with their columns and what is known of these.
    """
    count = off[0].shape[1]
    noise = np.random.default_rng(SEED).standard_normal((count, SHARES, REPETITIONS, off[0].shape[0]))
    left = [
        _least(one.T[:, None, None, :] + noise, own, precision)
        for one, own, precision in zip(off, columns, known, strict=True)
    ]
    clean = [_least(one[:, 0], own, precision) for one, own, precision in zip(off, columns, known, strict=True)]
    return np.mean(left[1] - left[0] > asked, axis=-1), max(float(clean[1] - clean[0]), 0.0)


def _least(of: np.ndarray, columns: np.ndarray, precision: np.ndarray) -> np.ndarray:
    """What is left at least of squares (..., directions) by columns whose numbers are known with a precision."""
    slope = of @ columns
    taken = np.sum((slope @ inverse(columns.T @ columns + precision)) * slope, axis=-1)
    return np.asarray(np.sum(of**2, axis=-1) - taken)


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
