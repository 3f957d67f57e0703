"""What a residual depends on when no effect explains it: conditional means over one signal at a time, on blocks left
out; and the data-driven term that is offered for it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from plants.effects.attach import lacks
from plants.effects.curves import curves_over
from plants.effects.interface import Effect
from plants.interface import Plant
from workbench.diagnose.residuals.balance import BLOCKS, Balance
from workbench.diagnose.residuals.balances import FORCE
from workbench.diagnose.residuals.fit import Fit
from workbench.diagnose.residuals.motion import Motion, signals_of, ways_of
from workbench.diagnose.residuals.unknowns import Values

BINS = 24
"""Bins over a signal, with equally many values in each."""

LEAST = 0.15
"""Share of the residual's variance on left-out blocks that a signal has to explain."""

PRESSURES = ("pressure_1", "pressure_2", "load_pressure")
"""Signals of which a balance of forces is made where they are what drives the mass: a curve over them takes a part of
whatever is missing."""

ABOVE = 1.3
"""Floors above which a residual is not noise. A flow or a force that is known to the floor is explained."""

PLACES = ("position", "time", "rotation_angle")
"""Signals that no force makes: over them what is missing may turn with the direction of motion, as friction does."""


@dataclass(frozen=True)
class Dependence:
    """A balance that is not explained: the signals on which its residual depends, with the share of its variance that
    each explains. Of a simulated plant what a curve over the best of them gains in the logarithm of the likelihood, and
    what those over each gain as shares of that.
    """

    balance: str
    shares: Mapping[str, float]
    gain: float | None = None

    @property
    def signals(self) -> list[str]:
        """From the strongest."""
        return sorted(self.shares, key=lambda name: -self.shares[name])


@dataclass(frozen=True, eq=False)
class Term:
    """A data-driven term: the mean of a balance's residual (`unit`) in bins of a signal (SI), a line from node to node.

    It says what is missing where, and names no cause.
    """

    balance: Balance
    signal: str
    nodes: np.ndarray
    values: np.ndarray

    def left(self, motions: Sequence[Motion], values: Values) -> tuple[float, float]:
        """Rms of the residual where something moves, without the term and with it (`balance.unit`)."""
        parts = []
        for motion in motions:
            residual, moving = _moving(self.balance, motion, values)
            signal = signals_of(motion.thinned)[self.signal][moving]
            parts.append([residual, residual - np.interp(signal, self.nodes, self.values)])
        before, after = (np.concatenate(side) for side in zip(*parts, strict=True))
        return float(np.sqrt(np.mean(before**2))), float(np.sqrt(np.mean(after**2)))


@dataclass(frozen=True)
class TermErrors:
    """Rms of a residual where something moves, without a data-driven term and with it."""

    before: float
    after: float


@dataclass(frozen=True, eq=False)
class OfferedTerm:
    """A data-driven term over a signal (SI): its nodes and the residual there (`unit`), and what it does to the records
    that were fitted and to those that were held out; None where nothing moves in them.
    """

    signal: str
    nodes: np.ndarray
    values: np.ndarray
    unit: str
    fit: TermErrors | None = None
    held_out: TermErrors | None = None

    def to_json(self) -> dict[str, object]:
        """As report.json holds it."""
        tested = {use: asdict(errors) for use in ("fit", "held_out") if (errors := getattr(self, use)) is not None}
        return {
            "signal": self.signal,
            "nodes": self.nodes.tolist(),
            "values": self.values.tolist(),
            "unit": self.unit,
            **tested,
        }


@dataclass(frozen=True, eq=False)
class Unexplained:
    """What no effect explains: the balance, on which signals it depends, and the term that is offered for it."""

    dependence: Dependence
    term: OfferedTerm

    @property
    def balance(self) -> str:
        """The balance by name."""
        return self.dependence.balance

    def to_json(self) -> dict[str, object]:
        """As report.json holds it."""
        return {
            "balance": self.balance,
            "depends_on": self.dependence.signals,
            "shares": dict(self.dependence.shares),
            "gain": self.dependence.gain,
            "data_driven_term": self.term.to_json(),
        }


def curve_over(plant: Plant, balance: str, signal: str) -> Effect | None:
    """The curve that a plant can have of a balance over a signal; None where there is none."""
    offers = curves_over(balance, signal)
    return next((effect for effect in offers if not lacks(plant.bare or plant, effect)), None)


def unexplained_of(after: Fit, dependence: Dependence, held_out: Sequence[Motion], plant: Plant) -> Unexplained:
    """What a fit of a balance leaves unexplained, with a term over the signal on which it depends most, of those over
    which the plant can have a curve, if there are any.
    """
    balance, values, signals = after.balance, after.values, dependence.signals
    over = next((signal for signal in signals if curve_over(plant, balance.name, signal)), signals[0])
    term = data_driven_term(balance, values, over)
    fitted, tested = (
        TermErrors(*term.left(motions, values)) if is_moving(balance, motions) else None
        for motions in (balance.motions, held_out)
    )
    return Unexplained(dependence, OfferedTerm(term.signal, term.nodes, term.values, balance.unit, fitted, tested))


def is_moving(balance: Balance, motions: Sequence[Motion]) -> bool:
    """Whether anything moves in records of which a balance knows something."""
    return any(np.any(balance.known(motion) & ~motion.thinned.resting) for motion in motions)


def rms_moving(balance: Balance, motions: Sequence[Motion], values: Values) -> float:
    """Rms of the first residual of a balance (in its unit) where something moves."""
    return float(np.sqrt(np.mean(np.concatenate([_moving(balance, motion, values)[0] for motion in motions]) ** 2)))


def bins_of(signal: np.ndarray) -> np.ndarray:
    """The number of the bin in which each value of a signal is, from 0; fewer bins where many values are the same."""
    edges = np.unique(np.quantile(signal, np.linspace(0.0, 1.0, BINS + 1)[1:-1]))
    return np.searchsorted(edges, signal)


def data_driven_term(balance: Balance, values: Values, signal: str) -> Term:
    """The term of a signal, from the balance's own records."""
    residuals, signals = [], []
    for motion in balance.motions:
        residual, moving = _moving(balance, motion, values)
        residuals.append(residual)
        signals.append(signals_of(motion.thinned)[signal][moving])
    residual, known = np.concatenate(residuals), np.concatenate(signals)
    place = bins_of(known)
    bins = np.unique(place)
    nodes, means = (np.array([np.mean(values_of[place == bin_]) for bin_ in bins]) for values_of in (known, residual))
    return Term(balance, signal, nodes, means)


def _moving(balance: Balance, motion: Motion, values: Values) -> tuple[np.ndarray, np.ndarray]:
    """The first residual of a balance where something moves, and where that is."""
    moving = balance.known(motion) & ~motion.thinned.resting
    return balance.residuals(motion, values)[0][moving], moving


def dependence(balance: Balance, values: Values) -> Dependence | None:
    """The signals on which a balance's residual depends; None where it is at its floor or depends on none."""
    parts: dict[str, list[np.ndarray]] = {}
    residuals, ways = [], []
    for motion in balance.motions:
        residual, moving = _moving(balance, motion, values)
        residuals.append(residual / balance.floor)
        ways.append(ways_of(motion.thinned.velocity, motion.creep)[moving])
        for name, signal in signals_of(motion.thinned).items():
            parts.setdefault(name, []).append(signal[moving])
    residual = np.concatenate(residuals)
    if residual.size < BINS * BLOCKS or np.sqrt(np.mean(residual**2)) < ABOVE:
        return None
    turned = np.concatenate(ways) * residual
    strong = dict[str, float]()
    for name, pieces in parts.items():
        sides = (residual, turned) if name in PLACES else (residual,)
        share = max(foretold(side) if name == "time" else explained(np.concatenate(pieces), side) for side in sides)
        if share > LEAST:
            strong[name] = share
    others = {name: share for name, share in strong.items() if not is_made_of(balance, name)}
    return Dependence(balance.name, others or strong) if strong else None


def is_made_of(balance: Balance, signal: str) -> bool:
    """Whether a balance is made of a signal: one of forces where no sensor shows what drives the mass."""
    return balance.name == FORCE and signal in PRESSURES and not balance.motions[0].has(FORCE)


def explained(signal: np.ndarray, residual: np.ndarray) -> float:
    """Share of the residual's variance that its mean over bins of a signal explains, on blocks left out of the
    means.
    """
    place = bins_of(signal)
    size = int(np.max(place)) + 1
    means = []
    for block in _blocks(residual):
        rest = np.ones(residual.size, dtype=bool)
        rest[block] = False
        counts = np.bincount(place[rest], minlength=size)
        sums = np.bincount(place[rest], weights=(residual - np.mean(residual))[rest], minlength=size)
        means.append((sums / np.maximum(counts, 1))[place[block]])
    return _share(residual, np.concatenate(means))


def foretold(residual: np.ndarray) -> float:
    """Share of its variance that the blocks before and after one foretell by their means: over time a block that is
    left out is all that there is of its bins.
    """
    blocks = _blocks(residual)
    means = np.array([np.mean(residual[block]) for block in blocks]) - np.mean(residual)
    beside = [np.mean(means[[one for one in (k - 1, k + 1) if 0 <= one < BLOCKS]]) for k in range(BLOCKS)]
    return _share(residual, np.repeat(beside, [block.size for block in blocks]))


def _blocks(residual: np.ndarray) -> list[np.ndarray]:
    return np.array_split(np.arange(residual.size), BLOCKS)


def _share(residual: np.ndarray, told: np.ndarray) -> float:
    """Share of a residual's variance that goes with what is told of it beside its mean."""
    beside = residual - np.mean(residual)
    return 1.0 - float(np.mean((beside - told) ** 2) / np.mean(beside**2))


def strongest(dependences: Sequence[Dependence | None]) -> Dependence | None:
    """The dependence that explains most."""
    known = [dependence for dependence in dependences if dependence is not None]
    return max(known, key=lambda dependence: max(dependence.shares.values()), default=None)
