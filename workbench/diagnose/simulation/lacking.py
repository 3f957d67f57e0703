"""What a simulated plant lacks that no effect is: a force, or a flow, over a signal.

Beside the plant's own parameters a curve over one signal at a time is fitted to what the simulated plant leaves, to
first order, as a push on its mass, or on its valve's command, that follows the signal as it was recorded; of flow into
one chamber as a curve that the plant has itself. Where a curve gains more in likelihood than noise would, something is
missing, however small.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plants.effects.interface import Effect
from workbench.diagnose.residuals.fit import Fit, stacked, without_lost
from workbench.diagnose.residuals.motion import Motion, signals_of, ways_of
from workbench.diagnose.selection.likelihood import asked, gain_of, own_noise
from workbench.diagnose.selection.unexplained import Dependence
from workbench.diagnose.simulation.own_curves import (
    FELT,
    FIRST,
    balance_told,
    curves_of,
    flat_curve,
    simulated_motion,
)
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.to_first_order import errors_pushed
from workbench.diagnose.simulation.together import Push
from workbench.fitting.threads import side_by_side
from workbench.records.reading import Record

NODES, FINE = 8, 24
"""Of a curve: hats between them, at even shares of the signal's values; and of the curves that gain most, once more,
since what happens at one place or speed alone is narrow."""

DEGREE = 3
"""Of the polynomial over the signal that is one of a curve's shapes: what bends little has few numbers."""

REFINED, LEADING, SEEN = 0.3, 3, 0.25
"""Share of what the best curve gains from which another is refined, too; how many are, at most; and the share of what
is asked of a fine curve that a coarse one gains of it at least, whose steps are three times as wide."""

FORCE, FLOW = "force", "flow"

PUSHES: Mapping[str, Sequence[tuple[str, bool]]] = {
    FORCE: (
        ("position", False),
        ("position", True),
        ("time", False),
        ("time", True),
        ("velocity", False),
        ("acceleration", False),
        ("command", False),
        ("load_pressure", False),
    ),
    FLOW: (("pressure_1", False), ("pressure_2", False), ("valve_voltage", False), ("velocity", False)),
}
"""By balance the signals over which something may be missing, and whether it turns with the direction of motion."""

CERTAIN, CERTAIN_FINE, BESIDE = 1.15, 1.5, 2.0
"""Times what is asked of a curve from which it is told; of a refined one, which follows slow noise over time, too; and
of one, as of an effect, on a plant that a filter keeps beside its record, whose likelihood is of first order in noise
that bends with the contact [of 14 machines by hand without effect one had a name and one was unexplained without it].
"""

LEVEL = 0.5
"""Share of what the best curve gains from which another signal is told beside it."""


@dataclass(frozen=True, eq=False)
class Lacking:
    """A curve over a signal: what it gains in the logarithm of the likelihood, what is asked of it, and what its
    numbers change of the residual (rows, numbers).
    """

    balance: str
    signal: str
    gain: float
    asked: float
    columns: np.ndarray

    @property
    def is_certain(self) -> bool:
        """Whether noise would not gain so much."""
        return self.gain > self.asked


def lacking(how: Shooting, fitted: Fit) -> list[Lacking]:
    """What a fit of the simulated plant lacks, over each signal, from what gains most."""
    motions = fitted.balance.motions
    followed = [simulated_motion(how, motion, fitted) for motion in motions]
    beside = BESIDE if how.is_kept else 1.0
    base = stacked(how.balance(motions, ()), fitted.values)
    wanted = [
        (balance, *each) for balance, own in PUSHES.items() for each in own if _is_there(how, motions, balance, each[0])
    ]
    along = [signals_of(motion) for motion in followed]
    flows = [] if how.is_beside else _flows(how, along)
    candidates = 2 * (len(wanted) + len(flows))
    own_noise(fitted)  # once for all threads

    def over(each: tuple[str, str, bool], count: int) -> list[Lacking]:
        balance, signal, turns = each
        nodes, pushes = _hats(motions, followed, signal, turns, count)
        if not pushes:
            return []
        hats, name = _columns(how, fitted, base, balance, pushes), balance_told(how, balance)
        shapes, certain = ([hats], CERTAIN_FINE) if count == FINE else ([hats @ _powers(nodes), hats], CERTAIN)
        return [
            Lacking(name, signal, _gain(fitted, block), max(certain, beside) * asked(block.shape[1], candidates), block)
            for block in shapes
        ]

    def into_chamber(offer: tuple[str, Effect]) -> list[Lacking]:
        curve = flat_curve(how, fitted, *offer, along)
        hats, name = curve.changed, curve.balance
        return [
            Lacking(name, curve.signal, _gain(fitted, block), CERTAIN * asked(block.shape[1], candidates), block)
            for block in (hats @ _powers(np.linspace(0.0, 1.0, len(curve.nodes))), hats)
        ]

    curves_over = side_by_side(lambda each: over(each, NODES), wanted)
    tried = [(curves, each) for curves, each in zip(curves_over, wanted, strict=True) if curves]
    most = max((curve.gain for curves, _ in tried for curve in curves), default=0.0)
    leading = sorted(tried, key=lambda one: -max(curve.gain for curve in one[0]))[:LEADING]
    least = max(REFINED * most, SEEN * CERTAIN_FINE * asked(FINE, candidates))
    refined = [each for curves, each in leading if max(curve.gain for curve in curves) > least]
    finer = side_by_side(lambda each: over(each, FINE), refined)
    own = side_by_side(into_chamber, flows)
    return sorted(
        (one for curves in [*(c for c, _ in tried), *finer, *own] for one in curves),
        key=lambda one: one.asked - one.gain,
    )


def _gain(fitted: Fit, block: np.ndarray) -> float:
    wide = np.full(block.shape[1], np.inf)
    return gain_of(fitted, block, -wide, wide)[0]


def dependence_of(found: Sequence[Lacking]) -> Dependence | None:
    """On which signals of which balance something certain depends, with what each gains as a share of the best."""
    certain = [one for one in found if one.is_certain]
    if not certain:
        return None
    best = certain[0]
    beside = [one for one in certain if one.balance == best.balance and one.gain > LEVEL * best.gain]
    shares = dict[str, float]()
    for one in beside:
        shares[one.signal] = max(shares.get(one.signal, 0.0), one.gain / best.gain)
    return Dependence(best.balance, shares, best.gain)


def _flows(how: Shooting, along: Sequence[Mapping[str, np.ndarray]]) -> list[tuple[str, Effect]]:
    """The curves of flow that a plant can have, over signals that are there `along` all records."""
    curves = [(signal, effect) for signal, effect in curves_of(how.along.plant) if effect.balance == FLOW]
    return [(signal, effect) for signal, effect in curves if all(signal in signals for signals in along)]


def _is_there(how: Shooting, motions: Sequence[Motion], balance: str, signal: str) -> bool:
    if not (how.has_valve if balance == FLOW else how.takes_a_force):
        return False
    return all(signal in signals_of(motion) for motion in motions)


def _hats(
    motions: Sequence[Motion], followed: Sequence[Motion], signal: str, turns: bool, count: int
) -> tuple[np.ndarray, list[dict[Record, np.ndarray]]]:
    """Nodes of a signal, at even shares of its values, so many at most; and hats over it at every sample of each
    record.
    """
    along = [signals_of(motion)[signal] for motion in followed]
    nodes = np.unique(np.quantile(np.concatenate(along), np.linspace(0.0, 1.0, count)))
    hats = []
    for k in range(nodes.size if nodes.size > 1 else 0):
        heights = np.zeros(nodes.size)
        heights[k] = 1.0
        hat = {}
        for motion, smooth, values in zip(motions, followed, along, strict=True):
            ways = ways_of(smooth.velocity, motion.creep) if turns else 1.0
            hat[motion.record] = ways * np.interp(values, nodes, heights)
        hats.append(hat)
    return nodes, hats


def _powers(nodes: np.ndarray) -> np.ndarray:
    """Heights at the nodes of polynomials up to `DEGREE`, shape (nodes, polynomials)."""
    low, high = float(nodes[0]), float(nodes[-1])
    return np.polynomial.legendre.legvander((2.0 * nodes - low - high) / (high - low), min(DEGREE, nodes.size - 1))


def _columns(
    how: Shooting, fitted: Fit, base: np.ndarray, balance: str, pushes: Sequence[Mapping[Record, np.ndarray]]
) -> np.ndarray:
    """What each push changes of the residual, which without it is `base`, in units that make as much of it: by how the
    simulations answer, or by simulations of their own where they start more than once or a loop leads them.
    """
    on_command, motions, plain = balance == FLOW, fitted.balance.motions, how.balance(fitted.balance.motions, ())

    def moved(several: Sequence[Mapping[Record, np.ndarray]], size: float) -> list[np.ndarray]:
        pushes = [Push(on_command, {record: size * values for record, values in one.items()}) for one in several]
        errors = errors_pushed(how, motions, fitted.values, pushes)
        return [without_lost(plain.stack(own)) - base for own in errors]

    size = FIRST * how.push_scale(on_command)
    felt = float(np.linalg.norm(fitted.weighing(moved([pushes[len(pushes) // 2]], size)[0])))
    size *= float(np.clip(FELT / max(felt, 1e-12), 1e-6, 1e6))
    return np.column_stack(moved(pushes, size))
