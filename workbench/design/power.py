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
from dataclasses import dataclass, replace

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
"""Machines that are drawn and simulated, shares of repeated records that are counted on each, and records of each."""

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


def told_apart(
    rig: Rig, hypotheses: Sequence[Hypothesis], legs: Sequence[Leg], runs: Sequence[Sequence[Run]]
) -> list[Told]:
    """Every ordered pair of hypotheses; `runs` are those of all that may be true over the legs."""
    truths, found = truths_of(hypotheses), []
    for i, hypothesis in enumerate(hypotheses):
        shapes = [
            shape
            for k, true in enumerate(truths)
            if true.effects == hypothesis.effects
            and (shape := _shape(rig, true, legs, runs[k], is_drawn=true is hypothesis)) is not None
        ]
        if not shapes or shapes[0].true is not hypothesis:
            continue
        for j, rival in enumerate(hypotheses):
            if j != i:
                fits = [_against(rig, shape, rival, legs) for shape in shapes]
                found.append(_told((i, j), rival, shapes, fits))
    return found


def distances(
    rig: Rig, hypotheses: Sequence[Hypothesis], legs: Sequence[Leg], runs: Sequence[Sequence[Run]]
) -> tuple[dict[Pair, float], int]:
    """T of every pair that a motion may tell apart, by refits of both to records without noise; and the steps that the
    solver took.
    """
    pairs, truths = pairs_of(hypotheses), truths_of(hypotheses)
    tested = sorted({i for i, _ in pairs})

    def itself(i: int) -> tuple[Machine, Refit] | None:
        machine = _machine(rig, truths[i], np.zeros(len(truths[i].unknowns)), runs[i])
        near = shown_along(rig, truths[i], legs, runs[i])
        if machine is None or near is None:
            return None
        return machine, _found_back(rig, truths[i], near, legs, machine)

    own = dict(zip(tested, side_by_side(itself, tested), strict=True))

    def distance(pair: Pair) -> tuple[float, int]:
        i, j = pair
        if (found := own[i]) is None:
            return 0.0, 0
        machine, back = found
        shown = shown_along(rig, hypotheses[j], legs, runs[i])
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
    and the columns of its unknowns and its starts there.
    """

    moved: np.ndarray
    left: np.ndarray
    shown: Shown


@dataclass(frozen=True, eq=False)
class Shape:
    """A hypothesis in one of its shapes, the runs of its motion, its machines, and its own fit to each of them."""

    true: Hypothesis
    runs: Sequence[Run]
    machines: Sequence[Machine]
    own: Sequence[Fitted]


def _shape(rig: Rig, true: Hypothesis, legs: Sequence[Leg], runs: Sequence[Run], *, is_drawn: bool) -> Shape | None:
    """A shape on its own machine and, if `is_drawn`, on others that it may be; None where it diverges on all."""
    nominal = _machine(rig, true, np.zeros(len(true.unknowns)), runs)
    machines = [one for one in (nominal, *(_drawn(rig, true, legs) if is_drawn else ())) if one is not None]
    if not machines or (shown := shown_along(rig, true, legs, runs)) is None:
        return None
    own = side_by_side(lambda machine: _itself(rig, true, shown, legs, machine), machines)
    return Shape(true, runs, machines, own)


def _against(rig: Rig, shape: Shape, rival: Hypothesis, legs: Sequence[Leg]) -> list[Fitted] | None:
    """A rival on the machines of a shape; None where its plant runs away and the true one does not."""
    shown = shown_along(rig, rival, legs, shape.runs)
    return None if shown is None else _refits(rig, (shape.true, rival), shown, legs, shape.machines)


def _itself(rig: Rig, true: Hypothesis, shown: Shown, legs: Sequence[Leg], machine: Machine) -> Fitted:
    """The true hypothesis fitted to its own machine; `shown` are its columns on the nominal one."""
    back = _found_back(rig, true, shown, legs, machine)
    return Fitted(back.moved, back.left, _columns_at(rig, true, back.moved, shown, legs, machine.runs))


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
        return Fitted(fit.moved, fit.left, _columns_at(rig, rival, fit.moved, shown, legs, machine.runs))

    return side_by_side(fitted, machines)


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
