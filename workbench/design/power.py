"""How often the record of a whole motion tells a hypothesis from a rival: by simulated repetitions.

Both are fitted to the record of the motion with noise, beside what is known of them already; S is then what one leaves,
and the true one is told from its rival where S_rival - S_true exceeds what odds of 20 to 1 ask for. Where the rival can
do all that the true one does, it must not gain so much. Machines are drawn from what is known of the parameters, and
there is one of each further shape that an effect may have.

Both fits are searched for in simulations of each machine, the true one's from a little beside it: where contacts stick
and nothing leads the plant, the least change may grow to another motion, to which the truth itself cannot be fitted.
What noise changes of either is taken to first order: it lies in the few directions in which a plant can move the
record, and in their differences.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import permutations

import numpy as np

from workbench.design.contrast import Pair, pairs_of
from workbench.design.hypotheses import Hypothesis, truths_of
from workbench.design.refit import FOUND, Leg, Refit, Shown, can_search, refitted, shown_along, started
from workbench.design.rig import Rig
from workbench.design.search import ODDS
from workbench.fitting.covariance import inverse
from workbench.fitting.threads import side_by_side
from workbench.simulation.run import Run

MACHINES, SHARES, REPETITIONS = 4, 50, 50
"""Machines that are drawn and simulated, at most, shares of repeated records that are counted on each, and records of
each share.
"""

STEPS = 3e7
"""Of the solver after which no further machine is drawn, but for one: some twenty seconds on each of two cores."""

INTERVAL = (5.0, 95.0)
"""Percentiles of the share told apart in the repetitions of one machine."""

NEAR = 0.2
"""Of an unknown as a search sees it, to which first order reaches: no machine is drawn farther away."""

BESIDE = 0.1
"""Of a deviation, how far from a machine the fit of the true hypothesis begins."""

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
class Machine:
    """A machine as its record would be without noise, the runs that made it, leg by leg, and how far it is from the
    hypothesis that it is drawn of, by name of the unknown, as a search sees them.
    """

    record: np.ndarray
    runs: Sequence[Run]
    away: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Simulated:
    """A motion under hypotheses: its legs, the runs of all that may be true over them (`truths_of`), and what each
    hypothesis shows along the commands of each of these, as far as that was asked for.
    """

    rig: Rig
    hypotheses: Sequence[Hypothesis]
    legs: Sequence[Leg]
    runs: Sequence[Sequence[Run]]
    found: dict[tuple[int, int], Shown | None] = field(default_factory=dict)

    @cached_property
    def truths(self) -> list[Hypothesis]:
        """What may be true."""
        return truths_of(self.hypotheses)

    def machine(self, number: int) -> Machine | None:
        """What may be true as the machine that made its runs; None where it diverged."""
        return _machine(self.rig, self.truths[number], np.zeros(len(self.truths[number].unknowns)), self.runs[number])

    def shown(self, of: int, along: int) -> Shown | None:
        """What a truth shows along the commands of another, by number; None where it diverges."""
        if (of, along) not in self.found:
            self.found[of, along] = shown_along(self.rig, self.truths[of], self.legs, self.runs[along])
        return self.found[of, along]


def told_apart(motion: Simulated) -> list[Told]:
    """Every ordered pair of hypotheses."""
    hypotheses = motion.hypotheses
    nominal = [_shape(motion, k, [motion.machine(k)]) for k in range(len(motion.truths))]
    asked = [(i, j) for i, j in permutations(range(len(hypotheses)), 2) if nominal[i] is not None]
    shapes = {
        (i, j): [one for one in nominal if one is not None and one.true.effects == hypotheses[i].effects]
        for i, j in asked
    }
    fits = {(i, j): [_against(motion, one, j) for one in shapes[i, j]] for i, j in asked}
    taken = sum(one.steps for one in nominal if one is not None)
    taken += sum(fit.steps for each in fits.values() for theirs in each for fit in theirs or ())
    count = int(np.clip(STEPS / max(taken, 1) - 1.0, 1, MACHINES))
    for i in dict.fromkeys(i for i, _ in asked):
        drawn = _shape(motion, i, _drawn(motion.rig, hypotheses[i], motion.legs, count))
        if drawn is not None:
            for j in (rival for true, rival in asked if true == i):
                shapes[i, j].append(drawn)
                fits[i, j].append(_against(motion, drawn, j))
    return [_told(pair, hypotheses[pair[1]], shapes[pair], fits[pair]) for pair in asked]


def distances(motion: Simulated) -> tuple[dict[Pair, float], int]:
    """T of every pair that a motion may tell apart, by refits of both to records without noise; and the steps that the
    solver took.
    """
    rig, hypotheses, truths, legs, runs = motion.rig, motion.hypotheses, motion.truths, motion.legs, motion.runs
    pairs = pairs_of(hypotheses)
    tested = sorted({i for i, _ in pairs})

    def itself(i: int) -> tuple[Machine, Refit] | None:
        machine, near = motion.machine(i), motion.shown(i, i)
        if machine is None or near is None:
            return None
        return machine, _found_back(rig, truths[i], near, legs, machine)

    own = dict(zip(tested, side_by_side(itself, tested), strict=True))

    def distance(pair: Pair) -> tuple[float, int]:
        i, j = pair
        if (found := own[i]) is None:
            return 0.0, 0
        machine, back = found
        shown = motion.shown(j, i)
        if shown is None:  # its plant runs away where the true one does not
            return np.inf, back.steps
        start = started(hypotheses[j], truths[i], machine.away)
        fitted = refitted(rig, hypotheses[j], machine.record, shown, legs, runs[i], start)
        return max(fitted.squares - back.squares, 0.0), back.steps + fitted.steps

    each = side_by_side(distance, pairs)
    return {pair: left for pair, (left, _) in zip(pairs, each, strict=True)}, sum(steps for _, steps in each)


@dataclass(frozen=True, eq=False)
class Fitted:
    """A hypothesis at its best on a record without noise: how far its unknowns have `moved`, what is `left` (rows,),
    the columns of its unknowns and its starts there, and the steps that the solver took.
    """

    moved: np.ndarray
    left: np.ndarray
    shown: Shown
    steps: int


@dataclass(frozen=True, eq=False)
class Shape:
    """What may be true, by its number too, machines that it may be, and its own fit to each."""

    number: int
    true: Hypothesis
    machines: Sequence[Machine]
    own: Sequence[Fitted]

    @property
    def steps(self) -> int:
        """Of the solver, that the fits took."""
        return sum(one.steps for one in self.own)


def _shape(motion: Simulated, number: int, machines: Sequence[Machine | None]) -> Shape | None:
    """What may be true, on machines; None where it diverges on all."""
    true, kept = motion.truths[number], [one for one in machines if one is not None]
    if not kept or (shown := motion.shown(number, number)) is None:
        return None
    own = side_by_side(lambda machine: _itself(motion.rig, true, shown, motion.legs, machine), kept)
    return Shape(number, true, kept, own)


def _against(motion: Simulated, shape: Shape, rival: int) -> list[Fitted] | None:
    """A rival on the machines of a shape; None where its plant runs away and the true one does not."""
    shown, pair = motion.shown(rival, shape.number), (shape.true, motion.hypotheses[rival])
    return None if shown is None else _refits(motion.rig, pair, shown, motion.legs, shape.machines)


def _itself(rig: Rig, true: Hypothesis, shown: Shown, legs: Sequence[Leg], machine: Machine) -> Fitted:
    """The true hypothesis fitted to its own machine; `shown` are its columns on the nominal one."""
    back = _found_back(rig, true, shown, legs, machine)
    columns = _columns_at(rig, true, back.moved, shown, legs, machine.runs)
    return Fitted(back.moved, back.left, columns, back.steps)


def _found_back(rig: Rig, true: Hypothesis, shown: Shown, legs: Sequence[Leg], machine: Machine) -> Refit:
    """The refit of the true hypothesis to its own machine, from a little beside it."""
    away = np.array(list(machine.away.values()))
    beside = BESIDE * drawn_from(true) @ np.random.default_rng(SEED).standard_normal(away.size)
    there = np.clip(away + beside, *true.room)
    known = float(away @ true.precision @ away)
    return refitted(rig, true, machine.record, shown, legs, machine.runs, there, found=known + FOUND)


def _columns_at(
    rig: Rig, of: Hypothesis, moved: np.ndarray, near: Shown, legs: Sequence[Leg], runs: Sequence[Run]
) -> Shown:
    """A hypothesis's columns where it has `moved`, of a motion that is simulated soon enough; else those near it."""
    if not can_search(runs):
        return near
    return shown_along(rig, replace(of, values=of.moved(moved)), legs, runs) or near


def _refits(
    rig: Rig, pair: tuple[Hypothesis, Hypothesis], shown: Shown, legs: Sequence[Leg], machines: Sequence[Machine]
) -> list[Fitted]:
    """A rival on each machine of the true hypothesis."""
    true, rival = pair

    def fitted(machine: Machine) -> Fitted:
        start = started(rival, true, machine.away)
        fit = refitted(rig, rival, machine.record, shown, legs, machine.runs, start)
        columns = _columns_at(rig, rival, fit.moved, shown, legs, machine.runs)
        return Fitted(fit.moved, fit.left, columns, fit.steps)

    return side_by_side(fitted, machines)


def _machine(rig: Rig, of: Hypothesis, away: np.ndarray, runs: Sequence[Run]) -> Machine | None:
    """A machine by its runs; None where it diverged."""
    seen = [shown for run in runs if (shown := rig.seen(run)) is not None]
    by_name = dict(zip((u.name for u in of.unknowns), away.tolist(), strict=True))
    return Machine(np.concatenate(seen), runs, by_name) if len(seen) == len(runs) else None


def _drawn(rig: Rig, true: Hypothesis, legs: Sequence[Leg], count: int) -> list[Machine | None]:
    """So many machines that a hypothesis may be."""
    draw = np.random.default_rng(SEED)
    places = draw.standard_normal((count, len(true.unknowns))) @ drawn_from(true).T

    def driven(away: np.ndarray) -> Machine | None:
        values = true.moved(away)
        return _machine(rig, true, away, [rig.driven(values, leg.reference, leg.condition) for leg in legs])

    return side_by_side(driven, places)


def _told(pair: Pair, rival: Hypothesis, shapes: Sequence[Shape], fits: Sequence[list[Fitted] | None]) -> Told:
    """A pair by the shapes of the true one, and by the rival's fits to the machines of each."""
    true = shapes[0].true
    asked = -ODDS if true.is_part_of(rival) else ODDS
    draw = np.random.default_rng(SEED)
    shares, distances = list[np.ndarray](), list[float]()
    for shape, theirs in zip(shapes, fits, strict=True):
        if theirs is None:
            shares.append(np.ones(SHARES))
            distances.append(np.inf)
            continue
        repeated = [_repeated((shape.true, rival), both, asked, draw) for both in zip(shape.own, theirs, strict=True)]
        shares += [each for each, _ in repeated]
        distances.append(repeated[0][1])
    low, high = np.percentile(np.concatenate(shares), INTERVAL)
    power = float(np.mean(np.concatenate(shares)))
    first, deviations = fits[0], np.sqrt(np.maximum(np.diag(rival.covariance), 1e-300))
    moved = np.zeros(len(rival.unknowns)) if first is None else first[0].moved / deviations
    left = np.zeros(shapes[0].own[0].left.size) if first is None else first[0].left
    return Told(*pair, distances[0], moved, power, float(low), float(high), left)


def _repeated(
    of: tuple[Hypothesis, Hypothesis], fitted: tuple[Fitted, Fitted], asked: float, draw: np.random.Generator
) -> tuple[np.ndarray, float]:
    """Shares of repetitions on a machine that tell the true hypothesis, shape (shares,), and T without noise.

    Noise lies in the few directions in which either moves the record, and in what is left of it.
    """
    columns = [np.column_stack([one.shown.columns, one.shown.starts]) for one in fitted]
    basis = np.linalg.qr(np.column_stack([*columns, *(one.left for one in fitted)]))[0]
    noise = draw.standard_normal((SHARES, REPETITIONS, basis.shape[1]))
    left, clean = list[np.ndarray](), list[float]()
    for hypothesis, one, own in zip(of, fitted, columns, strict=True):
        within, known = basis.T @ own, hypothesis.precision_with(one.shown.starts.shape[1])
        moved = np.concatenate([one.moved, np.zeros(one.shown.starts.shape[1])])
        off = basis.T @ one.left
        left.append(_least(off + noise, within, known, moved))
        clean.append(float(_least(off, within, known, moved)))
    if of[0].is_part_of(of[1]):  # a rival that can do all that the true one does leaves no more, wherever its fit ends
        left[1], clean[1] = np.minimum(left[1], left[0]), min(clean[1], clean[0])
    return np.mean(left[1] - left[0] > asked, axis=-1), max(clean[1] - clean[0], 0.0)


def _least(of: np.ndarray, columns: np.ndarray, precision: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """What is left at least of squares (..., directions) by columns whose numbers have `moved` already, and are known
    with a precision: min over d of |of - C d|^2 + (m + d)' P (m + d).
    """
    held = precision @ moved
    slope = of @ columns - held
    taken = np.sum((slope @ inverse(columns.T @ columns + precision)) * slope, axis=-1)
    return np.asarray(np.sum(of**2, axis=-1) + moved @ held - taken)


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
