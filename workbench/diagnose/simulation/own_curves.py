"""Curves over a signal that a plant can have itself, of all that no effect explains.

Along what the plant itself does, as an effect of its own (`plants.effects.curves`), and so of a flow into one chamber,
which no push on a command is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plants.effects.attach import possible
from plants.effects.curves import CURVES
from plants.effects.interface import Effect
from plants.interface import Plant
from workbench.diagnose.residuals.along import Along
from workbench.diagnose.residuals.fit import Fit, without_lost
from workbench.diagnose.residuals.motion import Motion, motion_of
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.to_first_order import errors_near
from workbench.diagnose.simulation.together import Asked

FELT = 5.0
"""Standard deviations of noise that a push is to make, or a node of a curve: to first order, and above the solver's
error."""

FIRST = 1e-3
"""Share of what is typical of a machine with which that is found."""


@dataclass(frozen=True, eq=False)
class OwnCurve:
    """A curve that a plant can have: how the plant is simulated with it, the values of a fit with it on and flat, and
    what a `size` of each node changes of the residual (rows, nodes).
    """

    balance: str
    signal: str
    nodes: tuple[str, ...]
    how: Shooting
    flat: Values
    size: float
    changed: np.ndarray


def curves_of(plant: Plant) -> list[tuple[str, Effect]]:
    """Those that a plant can have and has not, each with its signal."""
    able = {effect.name for effect in possible(plant)} - set(plant.effects)
    return [(signal, effect.along(plant.axis)) for (_, signal), effect in CURVES.items() if effect.name in able]


def flat_curve(
    how: Shooting, found: Fit, signal: str, effect: Effect, along: Sequence[Mapping[str, np.ndarray]]
) -> OwnCurve:
    """A curve that is on and flat beside a fit, over the range of its signal `along` the records: a size is that by
    which all nodes together are felt as so many are. One alone may be where the signal never is.
    """
    share, low, high, *nodes = effect.own_names
    flat = {**found.values, **dict.fromkeys(nodes, 0.0), share: 1.0}
    flat |= {low: min(np.min(one[signal]) for one in along), high: max(np.max(one[signal]) for one in along)}
    with_it = replace(how, along=Along(how.along.plant.with_effects(effect), how.along.flow))
    size = FIRST * effect.numbers[nodes[0]].scale(how.scales)
    motions = found.balance.motions
    balance = with_it.balance(motions, ())

    def changes(several: Sequence[Values]) -> list[np.ndarray]:
        asked = [Asked(with_it, motion, values) for values in (flat, *several) for motion in motions]
        errors = errors_near(how, found.values, asked, than=flat, least=1)
        base, *moved = [
            without_lost(balance.stack(errors[at : at + len(motions)])) for at in range(0, len(errors), len(motions))
        ]
        return [one - base for one in moved]

    (there,) = changes([{**flat, **dict.fromkeys(nodes, size)}])
    felt = float(np.linalg.norm(found.weighing(there)))
    size *= float(np.clip(FELT * len(nodes) ** 0.5 / max(felt, 1e-12), 1e-6, 1e6))
    changed = np.column_stack(changes([{**flat, node: size} for node in nodes]))
    return OwnCurve(balance_told(how, effect.balance), signal, tuple(nodes), with_it, flat, size, changed)


def balance_told(how: Shooting, balance: str) -> str:
    """What the balance is called of which a push is part, on a plant that has another."""
    names = tuple(how.along.plant.balances)
    return balance if balance in names else names[0]


def simulated_motion(how: Shooting, motion: Motion, fitted: Fit) -> Motion:
    """The motion as the plant shows it: a measured signal has in it the noise that is to be explained."""
    channels = {**motion.record.channels, **how.simulated(motion, fitted.values)}
    return motion_of(replace(motion.record, channels=channels))
