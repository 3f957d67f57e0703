"""The simulation stage: effects compete for what the simulated plant leaves of the records.

The balances of the residual stage are quick and need no good start, but smoothing hides in them what is fast or small.
With the parameters that they give, the plant itself is simulated along the records and fitted to what its sensors
showed. Where it lacks nothing the sensors' noise is left; how much more is left is known, and a missing effect explains
nearly all of that.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.diagnose.residuals.fit import Fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.selection.selection import BalanceResult, Step
from workbench.diagnose.simulation.competition import Effects, add_effects, without_idle
from workbench.diagnose.simulation.fits import NOISE, TRUSTED, fit_simulation, mean_square, with_honest_deviations
from workbench.diagnose.simulation.setup import as_far_as_it_follows, shooting_of
from workbench.diagnose.simulation.shooting import VALVE, Shooting
from workbench.progress import Progress
from workbench.records.experiment import Experiment


@dataclass(frozen=True, eq=False)
class SimulationStage:
    """The plant fitted to simulation error: without effects, with those that the balances named, and with what this
    stage adds, whose rounds are `steps`. `first` and `effects` hold each effect with its parameters; `dropped` are
    effects of the balances that the simulated plant does without.
    """

    how: Shooting
    before: Fit
    named: Fit
    first: Effects
    after: Fit
    effects: Effects
    steps: Sequence[Step]
    dropped: Sequence[str]

    @property
    def result(self) -> BalanceResult:
        """As a balance's: both fits, and the rounds."""
        return BalanceResult(self.after.balance, self.before, self.after, self.steps)

    @property
    def starts_anew_every(self) -> float | None:
        """s after which the simulation starts anew from the record; None where it goes from end to end."""
        return None if np.isinf(self.how.length) else self.how.length

    @property
    def is_trusted(self) -> bool:
        """Whether what is left is so near to noise that the parameters are those of the machine."""
        return self.after.rms < TRUSTED

    @property
    def is_in_doubt(self) -> bool:
        """Whether this stage added effects with which the plant is still far from noise: stand-ins, maybe."""
        return bool(set(self.effects) - set(self.first)) and not self.is_trusted

    def without_additions(self) -> "SimulationStage":
        """The same before it added anything."""
        steps = [replace(self.steps[0], added=None, alternatives=[])]
        return replace(self, after=self.named, effects=self.first, steps=steps)

    def to_json(self) -> dict[str, object]:
        """As report.json holds it: errors in standard deviations of the sensors' noise."""
        return {
            "before": self.before.rms,
            "after": self.after.rms,
            "channels": list(self.how.channels),
            "starts_anew_every_s": self.starts_anew_every,
            "voltage_is_held": self.how.held,
            "parameters_from_it": self.is_trusted,
            "dropped": list(self.dropped),
        }


@dataclass(frozen=True)
class SimulationStart:
    """What the residual stage hands on: the plant's own `free` parameters, as `declared`; the values at which searches
    begin, without effects and with those that were found, which are in `effects`.
    """

    free: Sequence[str]
    declared: Values
    baseline: Values
    corrected: Values
    effects: Effects


def simulation_stage(
    experiment: Experiment, motions: Sequence[Motion], start: SimulationStart, progress: Progress
) -> SimulationStage | None:
    """Fit the plant to simulation error with the effects that the balances found, and let further ones compete.

    None where the records cannot be simulated.
    """
    held = shooting_of(experiment, motions)
    if held is None:
        return None
    holds = held.along.parameter_names
    start = replace(
        start,
        free=[name for name in start.free if name in holds],
        effects={effect: names for effect, names in start.effects.items() if set(names) <= holds},
    )
    stage = _along(held, experiment, motions, start, progress)
    ramps = shooting_of(experiment, motions, held=False)
    if stage.after.rms > NOISE and ramps is not None:
        tried = replace(ramps, length=stage.how.length)
        if mean_square(tried, stage.after) < mean_square(stage.how, stage.after):  # the voltage was no computer's
            other = _along(ramps, experiment, motions, start, progress)
            stage = min(stage, other, key=lambda either: either.after.rms)
    return stage


def _along(
    whole: Shooting, experiment: Experiment, motions: Sequence[Motion], start: SimulationStart, progress: Progress
) -> SimulationStage:
    """The stage with a plant that is simulated in this way."""
    bounds, given = experiment.bounds, start.effects
    progress("simulating the declared plant", 0.3)
    how = as_far_as_it_follows(whole, motions, start.baseline)
    before = fit_simulation(how, motions, start.baseline, start.free, bounds)
    current, dropped = before, list[str]()
    effects: Effects = {}
    if given:
        progress("simulating the plant with what was found", 0.4)
        with_them = as_far_as_it_follows(whole, motions, start.corrected)
        names = [*start.free, *(name for own in given.values() for name in own)]
        after = None
        if with_them.length >= how.length:  # else the record itself speaks against them
            after = fit_simulation(with_them, motions, start.corrected, names, bounds)
        if after is not None and (with_them.length > how.length or after.rms < before.rms):
            current, effects, how = after, given, with_them
        else:
            dropped = list(given)
    named, first, steps = current, effects, list[Step]()
    if how.along.plant.command == VALVE:  # elsewhere nobody has asked yet what a simulation adds
        current, effects, steps = add_effects(current, effects, start.declared, start.free, bounds, progress)
        named = steps[0].before if steps else named
        before = before if first else named
        current, effects, idle = without_idle(current, effects, start.declared, bounds, progress)
        dropped += [effect for effect in idle if effect in given]
    before, current = (with_honest_deviations(how, fitted) for fitted in (before, current))
    return SimulationStage(
        how=how,
        before=before,
        named=named,
        first=first,
        after=current,
        effects=effects,
        steps=steps,
        dropped=dropped,
    )
