"""Whether held-out records speak against what was found.

An effect that noise made, of g in the logarithm of the likelihood, lowers that of another record by about as much. One
that is there raises it, and one that the other record does not move leaves it as it is. What swings by itself, such as
a pump, meets each record in a phase of its own: another record says nothing of it.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from plants.effects.registry import effects
from workbench.diagnose.residuals.fit import Fit, fit, weighing_at
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.selection.likelihood import Proposal
from workbench.diagnose.selection.search import LEVEL
from workbench.diagnose.selection.sets import fitted_with
from workbench.diagnose.simulation.fits import NOISE, begun
from workbench.diagnose.simulation.reached import SimulationStart, asked_of
from workbench.diagnose.simulation.setup import as_simulated
from workbench.diagnose.simulation.stage import SimulationStage
from workbench.fitting.threads import side_by_side
from workbench.records.experiment import Experiment


def along_held_out(
    experiment: Experiment, simulation: SimulationStage, held_out: Sequence[Motion]
) -> Callable[[Fit], Fit]:
    """What a fit leaves of held-out records: a function that simulates its plant from end to end of them."""
    held_out = as_simulated(experiment, held_out)
    whole = simulation.along(experiment, held_out)
    return lambda one: fit(begun(whole, held_out, one.values).balance(held_out, ()), one.values, ())


def likelier(one: Fit, other: Fit) -> float:
    """By how much the logarithm of the likelihood of records is higher with one plant than with another, by the noise
    that the first leaves of them: an error that goes up with slow noise alone says nothing.
    """
    noise = weighing_at(one)
    return 0.5 * (other.seen_by(noise) - one.seen_by(noise))


def swings_by_itself(effect: str) -> bool:
    """Whether an effect has a frequency at which it goes on, and does not ring at it when something moves."""
    return any(number.frequency_of and not number.damped_by for number in effects()[effect].numbers.values())


def without_refuted(
    experiment: Experiment, found: SimulationStage, held_out: Sequence[Motion], start: SimulationStart
) -> SimulationStage:
    """What was found without the effects without which the plant, fitted anew, follows held-out records within noise,
    and they are likelier, by odds that data can tell.
    """
    if not (held_out and found.effects and found.is_near):
        return found
    along = along_held_out(experiment, found, held_out)
    ask = asked_of(found.how, found.after.balance.motions, start, experiment.bounds)
    kept, current, refuted = dict(found.effects), found.after, list[str]()
    there = along(current)
    while asked := [effect for effect in kept if not swings_by_itself(effect)]:
        fewer = side_by_side(
            lambda effect, current=current, kept=dict(kept): ask.settled(
                fitted_with(current, kept, Proposal((), (effect,), 0.0, 0.0, {}), ask)
            ),
            asked,
        )
        rivals = side_by_side(along, fewer)
        gains = [likelier(rival, there) if rival.excess < NOISE else -np.inf for rival in rivals]
        worst = int(np.argmax(gains))
        if gains[worst] < LEVEL:
            break
        refuted.append(asked[worst])
        current, there = fewer[worst], rivals[worst]
        del kept[refuted[-1]]
    if not refuted:
        return found
    before = found.before if kept else min(found.before, current, key=lambda one: one.rms)
    return replace(
        found,
        before=before,
        after=current if kept else before,
        effects=kept,
        gains={effect: gain for effect, gain in found.gains.items() if effect in kept},
        alternatives={effect: others for effect, others in found.alternatives.items() if effect in kept},
        dropped=[*found.dropped, *(effect for effect in found.first if effect in refuted)],
        refuted=refuted,
    )
