"""The simulation stage: effects compete for what the simulated plant leaves of the records.

The balances of the residual stage are quick and need no good start, but smoothing hides in them what is fast or small.
With the parameters that they give, the plant itself is simulated along the records and fitted to what its sensors
showed. Where it lacks nothing the sensors' noise is left; how much more is left is known, and a missing effect explains
nearly all of that.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from workbench.diagnose.residuals.along import ARRIVES
from workbench.diagnose.residuals.fit import NEAR_NOISE, Fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.selection.search import Found, search
from workbench.diagnose.selection.selection import BalanceResult, Effects, Step
from workbench.diagnose.selection.sets import declared_again, without_effects
from workbench.diagnose.selection.unexplained import Dependence
from workbench.diagnose.simulation.believed import believed
from workbench.diagnose.simulation.by_curve import Curved, in_its_place
from workbench.diagnose.simulation.filters import filtered
from workbench.diagnose.simulation.fits import NOISE, TRUSTED, Fitting, Simulated, exactly
from workbench.diagnose.simulation.lacking import BESIDE
from workbench.diagnose.simulation.led_search import found_led
from workbench.diagnose.simulation.nearer import fit_farther
from workbench.diagnose.simulation.reached import SimulationStart, asked_of, given_by, may_leave_less
from workbench.diagnose.simulation.setup import shooting_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.valleys import along_valley
from workbench.fitting.threads import side_by_side
from workbench.progress import Progress
from workbench.records.experiment import Experiment


@dataclass(frozen=True, eq=False)
class SimulationStage:
    """The plant fitted to simulation error: without effects, with those that the balances named, and with what this
    stage adds, whose rounds are `steps`. `first` and `effects` hold each effect with its parameters, `gains` what each
    gains in the logarithm of the likelihood, `alternatives` those that do as well in its place; `dropped` are effects
    of the balances that the simulated plant does without; `lacks` is on what depends that which no effect explains, and
    `stood_in` were effects that only stood in for it; `refuted` were those against which held-out records speak;
    `curved` is the plant with a curve for what it lacks, where that alone brings it near its records; `otherwise` are
    for each effect other numbers of it that do as well.
    """

    how: Shooting
    before: Fit
    named: Fit
    first: Effects
    after: Fit
    effects: Effects
    steps: Sequence[Step]
    gains: Mapping[str, float]
    alternatives: Mapping[str, Sequence[str]]
    dropped: Sequence[str]
    lacks: Dependence | None = None
    stood_in: Sequence[str] = ()
    refuted: Sequence[str] = ()
    curved: Curved | None = None
    otherwise: Mapping[str, Sequence[tuple[str, ...]]] = field(default_factory=dict)

    @property
    def result(self) -> BalanceResult:
        """As a balance's: both fits, and the rounds."""
        fits = self.after.balance, self.before, self.after
        return BalanceResult(*fits, self.steps, self.effects, self.gains, self.alternatives, self.otherwise)

    @property
    def starts_anew_every(self) -> float | None:
        """s after which the simulation starts anew from the record; None where it goes from end to end."""
        return None if np.isinf(self.how.length) else self.how.length

    @property
    def is_beside(self) -> bool:
        """Whether a filter keeps the plant beside its records, since a sensor shows with noise what drives it."""
        return self.how.is_beside

    @property
    def loop(self) -> float | None:
        """rad/s: the crossover of the loop that leads the plant along its records, which it does not follow without;
        None where none does.
        """
        return self.how.crossover

    @property
    def is_near(self) -> bool:
        """Whether it tells by itself what is missing, and that nothing is."""
        return Simulated(self.how, self.after).is_near

    @property
    def is_trusted(self) -> bool:
        """Whether what is left is near to noise, which may be slow: then the parameters are those of the machine."""
        return self.is_near or self.after.excess < TRUSTED

    @property
    def baseline_is_trusted(self) -> bool:
        """The same of the plant without effects."""
        return self.before.excess < TRUSTED or (self.before is self.after and self.is_trusted)

    @property
    def follows(self) -> bool:
        """Whether the plant follows its records within noise: then nothing is missing that they could show."""
        return self.after.excess < NOISE

    def along(self, experiment: Experiment, motions: Sequence[Motion]) -> Shooting:
        """The plant from end to end of other records, beside which filters keep it or a loop leads it, where it has
        such, that know what was found.
        """
        whole = shooting_of(experiment, motions, held=self.how.held)
        assert whole is not None  # one record of an experiment is simulated as another is
        whole = filtered(whole, motions, self.after.values)
        return whole if self.loop is None else whole.led(motions, self.after.values, self.loop)

    def to_json(self) -> dict[str, object]:
        """As report.json holds it: errors in standard deviations of the sensors' noise."""
        return {
            "before": self.before.rms,
            "after": self.after.rms,
            "channels": list(self.how.channels),
            "starts_anew_every_s": self.starts_anew_every,
            "voltage_is_held": self.how.held,
            "beside_the_record": self.is_beside,
            "led_by_rad_s": self.loop,
            "parameters_from_it": self.is_trusted,
            "dropped": list(self.dropped),
            "stood_in": list(self.stood_in),
            "refuted": list(self.refuted),
            "with_curve": None if self.curved is None else self.curved.simulated.fit.rms,
        }


def _as_late(fitted: Fit, sample_time: float, held: bool) -> Values:
    """The values of a fit; of a delay that it found half a sample less where a voltage is now `held`, which makes it so
    much later than a straight line between samples.
    """
    if not held or ARRIVES not in fitted.names:
        return fitted.values
    return {**fitted.values, ARRIVES: max(fitted.values[ARRIVES] - 0.5 * sample_time, 0.0)}


@dataclass(frozen=True, eq=False)
class Searches:
    """Searches among effects for what an experiment's simulated plant leaves of its records, by what the residual stage
    hands on to `start` with.
    """

    experiment: Experiment
    motions: Sequence[Motion]
    start: SimulationStart
    progress: Progress

    def among_effects(self, base: Simulated, with_them: Simulated | None, given: Effects) -> SimulationStage:
        """One from the fit of the plant without effects or with those that were `given`, and what it lacks then."""
        before, current, how, dropped = base.fit, base.fit, base.how, list[str]()
        effects: Effects = {}
        if with_them is not None:
            if with_them.fit.rms < _left_over(base, with_them.how.length, self.motions):
                current, effects, how = with_them.fit, given, with_them.how
            else:  # the record itself speaks against them
                dropped = list(given)
        lacks, stood_in = None, tuple[str, ...]()
        ask = asked_of(how, self.motions, self.start, self.experiment.bounds)
        if how.is_kept:
            ask = replace(ask, times=BESIDE)
        if Simulated(how, current).is_near:
            self.progress("what the simulated plant lacks", 0.6)
            found = search(current, effects, ask)
            self.progress("what no effect explains", 0.8)
            named = tuple(found.effects)
            without = without_effects(found.fit, found.effects, ask)
            found, lacks = believed(how, found, without, ask)
            stood_in = () if found.effects else named
        else:  # so far from noise stand-ins gain most
            found = Found(current, effects, [Step(current, [])], {}, {}, {})
            without = without_effects(current, effects, ask)
        dropped += [effect for effect in given if effect not in found.effects and effect not in dropped]
        if not found.effects and how is base.how and before.rms < found.fit.rms:
            found = replace(found, fit=before)
        if found.fit.rms < before.rms:  # what is left without what was found is no effect's
            plain = ask.settled(without) if found.effects else found.fit
            before = min(before, plain, key=lambda one: one.rms)
        return SimulationStage(
            how=how,
            before=before,
            named=current,
            first=effects,
            after=found.fit,
            effects=found.effects,
            steps=found.steps,
            gains=found.gains,
            alternatives=found.alternatives,
            otherwise=found.otherwise,
            dropped=dropped,
            lacks=lacks,
            stood_in=stood_in,
        )

    def in_place_of(self, curved: Curved, base: Simulated, given: Effects) -> SimulationStage:
        """What a plant lacks that comes near noise with a curve: an effect that does in its place, with all that is
        found beside that, or what nobody knows.
        """
        self.progress("effects in the place of a curve", 0.7)
        instead = in_its_place(self.experiment, curved, self.start)
        with_it, effects = (None, {}) if instead is None else instead
        found = _without(given, self.among_effects(base, with_it, effects))
        if found.after.excess < NEAR_NOISE:
            return found
        found = found if not found.effects else self.among_effects(base, None, {})
        dropped = [effect for effect in given if effect not in curved.effects]
        return replace(found, dropped=dropped, lacks=curved.dependence, curved=curved)

    def by_pieces(self, first: Simulated, values: Values) -> Simulated:
        """The plant fitted by way of pieces of the records."""
        fitting = self._fitting(first.fit.names)
        return along_valley(fitting, exactly(fit_farther(first, fitting, values), fitting))

    def anew(self, base: Simulated, found: SimulationStage) -> SimulationStage:
        """The search once more from the plant without effects, where that has come nearer to noise by what was found
        than the plant with it: it had lost its way, and what was found says no more than that. Pieces say nothing of
        it.
        """
        if not found.effects or base.how.length != found.how.length or found.before.rms >= found.after.rms:
            return found
        fitting = self._fitting(base.fit.names)
        nearer = fitting.final(fitting.found(replace(found.how, begins={}), found.before.values))
        again = self.among_effects(exactly(nearer, fitting), None, {})
        return _without((*found.dropped, *found.effects), again)

    def held_otherwise(self, base: Simulated, found: SimulationStage, given: Effects) -> SimulationStage:
        """The search once more with the voltage between samples as it was not taken to be, where that leaves less with
        what was found: effects stand in for a voltage that holds where it does not, and a delay of half a sample for
        one that does.
        """
        other = shooting_of(self.experiment, self.motions, held=not found.how.held)
        if other is None or not (found.effects and found.is_near):
            return found
        other = filtered(other, self.motions, found.after.values)
        values = _as_late(found.after, self.motions[0].record.sample_time, other.held)
        if not may_leave_less(replace(found.how, setups=other.setups, held=other.held), found.after, values):
            return found
        fitting = self._fitting(found.after.names)
        otherwise = fitting.final(fitting.found(other, values))
        if otherwise.fit.rms >= found.after.rms:
            return found
        own = self._fitting(base.fit.names)
        effective = {name for numbers in found.effects.values() for name in numbers}
        without = declared_again(otherwise.fit.values, effective, self.start.declared)
        plain = own.final(own.found(other, without))
        with_them = exactly(otherwise, fitting) if plain.fit.excess > NEAR_NOISE else None
        return _without(given, self.among_effects(plain, with_them, found.effects if with_them else {}))

    def _fitting(self, names: Sequence[str]) -> Fitting:
        return Fitting(self.motions, names, self.experiment.bounds)


def simulation_stage(
    experiment: Experiment,
    start: SimulationStart,
    base: Simulated,
    with_them: Simulated | None,
    curved: Curved | None,
    progress: Progress,
) -> SimulationStage:
    """Let effects compete for what the plant leaves, without any and with those that the balances found.

    Of a plant that a curve alone brings near to noise an effect is sought that does in its place. Of one that nothing
    brings near they are sought while loops lead it along its records, and count beside one where no run follows
    without. Where that finds none it may have lost its way, and is fitted once more by way of pieces.
    """
    motions, given = base.fit.balance.motions, given_by(base, start) if with_them is not None else {}
    searches = Searches(experiment, motions, start, progress)
    found = searches.among_effects(base, with_them, given)
    if curved is not None and found.after.excess > NEAR_NOISE:
        return searches.held_otherwise(base, searches.in_place_of(curved, base, given), given)
    led = None
    if found.after.excess > NEAR_NOISE:
        progress("effects while a loop leads the plant along its records")
        led = found_led(experiment, motions, base, start)
    if led is not None and led.alone is not None:
        again = searches.among_effects(led.alone, led.simulated, led.effects)
        if again.effects and again.follows:  # what little remains may be what a loop makes of noise
            return replace(_without(given, again), steps=[*led.steps, *again.steps], lacks=None)
    elif led is not None:
        again = searches.anew(base, searches.among_effects(base, led.simulated, led.effects))
        if _tells_more(again, found):
            gained = {**led.gains, **again.gains}  # far from noise none is sought from end to end
            gains = {effect: gained[effect] for effect in again.effects if effect in gained}
            found = replace(_without(given, again), steps=[*led.steps, *again.steps], gains=gains)
            return searches.held_otherwise(base, found, given)
    if found.after.excess > NEAR_NOISE:
        progress("simulating pieces of the records", 0.7)
        before = base, with_them
        begun = [(base, start.baseline), *([] if with_them is None else [(with_them, start.corrected)])]
        base, *others = side_by_side(lambda one: searches.by_pieces(*one), begun)
        with_them = others[0] if others else None
        if base is not before[0] or with_them is not before[1]:
            found = searches.among_effects(base, with_them, given)
    return searches.held_otherwise(base, searches.anew(base, found), given)


def _without(given: Iterable[str], found: SimulationStage) -> SimulationStage:
    """What was found, and of the effects that were `given` those that the plant does without."""
    return replace(found, dropped=[effect for effect in given if effect not in found.effects])


def _tells_more(again: SimulationStage, found: SimulationStage) -> bool:
    """Whether effects that loops showed bring the plant nearer to noise than what was `found` without: but where one
    curve did in the place of effects, others that leave one, too, only stand in for it once more.
    """
    once_more = bool(found.stood_in) and found.lacks is not None and again.lacks is not None
    return bool(again.effects) and again.after.rms < found.after.rms and not once_more


def _left_over(of: Simulated, length: float, motions: Sequence[Motion]) -> float:
    """Rms that a plant leaves of pieces of that length, without bound if it follows shorter ones alone."""
    if of.how.length == length:
        return of.fit.rms
    shorter = replace(of.how, length=length, begins={})
    return Fitting(motions, (), {}).begun(shorter, of.fit.values).fit.rms if of.how.length > length else np.inf
