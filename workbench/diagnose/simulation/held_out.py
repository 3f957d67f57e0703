"""Whether held-out records speak against what was found.

An effect that noise made, of g in the logarithm of the likelihood, lowers that of another record by about as much. One
that is there raises it, and one that the other record does not move leaves it as it is. What swings by itself, such as
a pump, meets each record in a phase of its own: another record says nothing of it.

What a plant is off by on another record comes from its own parameters, too: where these are so uncertain that they make
more than noise there, it is they that speak. An effect is refuted by what is left once they suit that record.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plants.effects.registry import effects
from workbench.diagnose.residuals.fit import Fit, fit, weighing_at
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Bounds
from workbench.diagnose.selection.search import LEVEL
from workbench.diagnose.selection.sets import fitted_without
from workbench.diagnose.simulation.fits import NOISE, Fitting, begun
from workbench.diagnose.simulation.reached import SimulationStart, asked_of
from workbench.diagnose.simulation.setup import as_simulated
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.stage import SimulationStage
from workbench.fitting.threads import side_by_side
from workbench.records.experiment import Experiment


@dataclass(frozen=True)
class HeldOut:
    """Held-out records, and how a plant is simulated from end to end of them."""

    motions: Sequence[Motion]
    whole: Shooting
    bounds: Bounds

    @classmethod
    def of(cls, experiment: Experiment, simulation: SimulationStage, held_out: Sequence[Motion]) -> "HeldOut":
        """As the simulated plant of an experiment goes along them."""
        motions = as_simulated(experiment, held_out)
        return cls(motions, simulation.along(experiment, motions), experiment.bounds)

    def left_by(self, one: Fit) -> Fit:
        """What the plant of a fit leaves of them."""
        return fit(begun(self.whole, self.motions, one.values).balance(self.motions, ()), one.values, ())

    def left_at_best(self, one: Fit, own: Sequence[str]) -> Fit:
        """The same once its `own` parameters suit these records."""
        fitting = Fitting(self.motions, own, self.bounds)
        return fitting.final(fitting.found(begun(self.whole, self.motions, one.values), one.values)).fit


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
    and they are likelier, by odds that data can tell, whether its own parameters suit them or not.
    """
    if not (held_out and found.effects and found.is_near):
        return found
    records = HeldOut.of(experiment, found, held_out)
    ask = asked_of(found.how, found.after.balance.motions, start, experiment.bounds)
    kept, current, refuted = dict(found.effects), found.after, list[str]()
    there = records.left_by(current)
    while asked := [effect for effect in kept if not swings_by_itself(effect)]:
        fewer = side_by_side(
            lambda effect, current=current, kept=dict(kept): ask.settled(fitted_without(current, kept, (effect,), ask)),
            asked,
        )
        rivals = side_by_side(records.left_by, fewer)
        gains = [likelier(rival, there) if rival.excess < NOISE else -np.inf for rival in rivals]
        worst = int(np.argmax(gains))
        if gains[worst] < LEVEL or not _speak_against(records, current, fewer[worst]):
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


def _speak_against(records: HeldOut, found: Fit, without: Fit) -> bool:
    """Whether held-out records are likelier without an effect once the plant's own parameters suit them with it, as it
    was found, and without.
    """
    both = side_by_side(lambda one: records.left_at_best(one, without.names), (without, found))
    return likelier(*both) >= LEVEL
