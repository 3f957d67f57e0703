"""The simulation stage: effects compete for what the simulated plant leaves of the records.

The balances of the residual stage are quick and need no good start, but smoothing hides in them what is fast or small.
With the parameters that they give, the plant itself is simulated along the records and fitted to what its sensors
showed. Where it lacks nothing the sensors' noise is left; how much more is left is known, and a missing effect explains
nearly all of that.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from workbench.diagnose.residuals.along import ARRIVES
from workbench.diagnose.residuals.fit import NEAR_NOISE, Fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.selection.search import Found, search
from workbench.diagnose.selection.selection import BalanceResult, Effects, Step
from workbench.diagnose.selection.sets import Asked, declared_again, without_effects
from workbench.diagnose.selection.trials import Shapes
from workbench.diagnose.selection.unexplained import Dependence
from workbench.diagnose.simulation.fits import (
    AT_NOISE,
    NOISE,
    TRUSTED,
    Fitting,
    Simulated,
    afresh,
    exactly,
    fit_simulation,
    settle,
)
from workbench.diagnose.simulation.lacking import dependence_of, lacking
from workbench.diagnose.simulation.nearer import fit_farther, fit_led, fit_over_hollows
from workbench.diagnose.simulation.setup import as_coloured, is_coloured, shooting_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.stand_ins import Place, standing_in
from workbench.diagnose.simulation.valleys import along_valley
from workbench.fitting.covariance import inverse
from workbench.progress import Progress
from workbench.records.experiment import Experiment

STRAIGHTENED = 1.25
"""Times the squares that a fit leaves, up to which another may leave less that leaves so much to first order."""

SETTLED = 16
"""Fits of which it is remembered where they settle: a search asks for some more than once."""

MANY = 3
"""Effects that together are less likely than one that nobody knows, if something is left beside them."""


@dataclass(frozen=True, eq=False)
class SimulationStage:
    """The plant fitted to simulation error: without effects, with those that the balances named, and with what this
    stage adds, whose rounds are `steps`. `first` and `effects` hold each effect with its parameters, `gains` what each
    gains in the logarithm of the likelihood, `alternatives` those that do as well in its place; `dropped` are effects
    of the balances that the simulated plant does without; `lacks` is on what depends that which no effect explains, and
    `stood_in` were effects that only stood in for it.
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

    @property
    def result(self) -> BalanceResult:
        """As a balance's: both fits, and the rounds."""
        return BalanceResult(
            self.after.balance, self.before, self.after, self.steps, self.effects, self.gains, self.alternatives
        )

    @property
    def starts_anew_every(self) -> float | None:
        """s after which the simulation starts anew from the record; None where it goes from end to end."""
        return None if np.isinf(self.how.length) else self.how.length

    @property
    def is_beside(self) -> bool:
        """Whether a loop keeps the plant beside its records, since a sensor shows with noise what drives it."""
        return self.how.is_beside(self.after.balance.motions[0])

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

    def to_json(self) -> dict[str, object]:
        """As report.json holds it: errors in standard deviations of the sensors' noise."""
        return {
            "before": self.before.rms,
            "after": self.after.rms,
            "channels": list(self.how.channels),
            "starts_anew_every_s": self.starts_anew_every,
            "voltage_is_held": self.how.held,
            "beside_the_record": self.is_beside,
            "parameters_from_it": self.is_trusted,
            "dropped": list(self.dropped),
            "stood_in": list(self.stood_in),
        }


@dataclass(frozen=True)
class SimulationStart:
    """What the residual stage hands on: the plant's own `free` parameters, as `declared`; the values at which searches
    begin, without effects and with those that were found, which are in `effects`; and the `shapes` of others.
    """

    free: Sequence[str]
    declared: Values
    baseline: Values
    corrected: Values
    effects: Effects
    shapes: Shapes


def simulated_baseline(
    experiment: Experiment, motions: Sequence[Motion], start: SimulationStart, progress: Progress
) -> Simulated | None:
    """The declared plant simulated along the records from end to end, the motions of whose fit are those to go on with;
    None where they cannot be simulated. One that is astray may have lost its way, or lack much: `nearer_baseline`.
    """
    progress("simulating the declared plant", 0.2)
    begun = _begun(experiment, motions, [start.baseline], start.free)
    if begun is None:
        return None
    best, fitting = begun
    best = _nearer(best, fitting, start.baseline) if best.is_near else best
    return _baseline(experiment, _settled(experiment, best, fitting))


def nearer_baseline(experiment: Experiment, base: Simulated, start: SimulationStart, progress: Progress) -> Simulated:
    """The same once more, by ways that lead nearer to noise."""
    progress("simulating the declared plant", 0.45)
    fitting = Fitting(base.fit.balance.motions, base.fit.names, experiment.bounds)
    return _baseline(experiment, _settled(experiment, _nearer(base, fitting, start.baseline), fitting))


def _baseline(experiment: Experiment, base: Simulated) -> Simulated:
    """The same on motions that show what noise is like that has memory."""
    if not (base.is_near and is_coloured(base.fit)):
        return base
    motions = base.fit.balance.motions
    finer = as_coloured(motions)
    if all(motion.thinning == before.thinning for motion, before in zip(finer, motions, strict=True)):
        return base
    fitting = Fitting(finer, base.fit.names, experiment.bounds)
    return exactly(afresh(fitting.final(fitting.found(base.how, base.fit.values)), fitting), fitting)


def simulated_with(
    experiment: Experiment, base: Simulated, start: SimulationStart, progress: Progress
) -> Simulated | None:
    """The plant with the effects that balances found; None if there are none that it can have. One that does not
    follow may have lost its way: `nearer_with`.
    """
    given = _given(base, start)
    if not given:
        return None
    progress("simulating the plant with what was found", 0.5)
    names = [*base.fit.names, *(name for own in given.values() for name in own)]
    begun = _begun(experiment, base.fit.balance.motions, [_beside(base, start, names), start.corrected], names)
    assert begun is not None  # the plant without effects was
    return _settled(experiment, *begun)


def nearer_with(experiment: Experiment, base: Simulated, them: Simulated, start: SimulationStart) -> Simulated:
    """The same once more, by ways that lead nearer to noise."""
    fitting = Fitting(them.fit.balance.motions, them.fit.names, experiment.bounds)
    return _settled(experiment, _nearer(them, fitting, _beside(base, start, them.fit.names)), fitting)


def _beside(base: Simulated, start: SimulationStart, names: Sequence[str]) -> dict[str, float]:
    """The values of the plant without effects, and of what it has not those that balances found."""
    return {**base.fit.values, **{name: start.corrected[name] for name in names if name not in base.fit.names}}


def _given(base: Simulated, start: SimulationStart) -> Effects:
    """The effects that balances found and that the simulated plant can have."""
    known = base.how.along.parameter_names
    return {effect: names for effect, names in start.effects.items() if set(names) <= known}


def _begun(
    experiment: Experiment, motions: Sequence[Motion], starts: Sequence[Values], names: Sequence[str]
) -> tuple[Simulated, Fitting] | None:
    """The plant fitted to simulation error from some starts, with those parameters that it has, over hollows where that
    is far from noise, and how it was; None where the records cannot be simulated. The voltage of a valve holds from
    sample to sample.
    """
    held = shooting_of(experiment, motions, held=True)
    if held is None:
        return None
    fitting = Fitting(motions, [name for name in names if name in held.along.parameter_names], experiment.bounds)
    best = fit_simulation(held, fitting, starts)
    return best if best.fit.excess < NEAR_NOISE else fit_over_hollows(best, fitting), fitting


def _nearer(best: Simulated, fitting: Fitting, start: Values) -> Simulated:
    """The same, if it is far from noise, by loops that lead it from `start` on, and from there over hollows."""
    if best.fit.excess < NEAR_NOISE:
        return best
    led = fit_led(best, fitting, start)
    return led if led is best or led.fit.excess < NEAR_NOISE else fit_over_hollows(led, fitting)


def _settled(experiment: Experiment, best: Simulated, fitting: Fitting) -> Simulated:
    """The same out of the last hollows, and with a voltage that is a straight line between samples, if that leaves
    less.
    """
    motions = fitting.motions
    best = along_valley(fitting, best)
    best = afresh(best, fitting) if best.is_near else best
    ramps = shooting_of(experiment, motions, held=False)
    assert ramps is not None  # the other was
    if best.is_near and _may_leave_less(replace(best.how, setups=ramps.setups, held=False), best.fit, best.fit.values):
        straight = fitting.final(fitting.found(ramps, best.fit.values))  # the voltage was no computer's
        if straight.fit.rms < best.fit.rms:
            held, best = replace(best.how, begins={}), straight
            if best.fit.excess > AT_NOISE:  # or it was, and this has led out of a hollow
                again = fitting.final(fitting.found(held, best.fit.values))
                best = min(best, again, key=lambda one: one.fit.rms)
    return exactly(best, fitting) if best.is_near else best


def _may_leave_less(how: Shooting, fitted: Fit, values: Values) -> bool:
    """Whether another way to simulate may leave less, by what it leaves beside `values` to first order in the
    parameters of a fit.
    """
    left, own = fitted.weighing(how.balance(fitted.balance.motions, ()).stacked(values)), fitted.jacobian
    own = own * fitted.free
    left = left - own @ (inverse(fitted.curvature) @ (own.T @ left))
    return bool(left @ left < STRAIGHTENED * (fitted.weighed @ fitted.weighed))


def _as_late(fitted: Fit, sample_time: float, held: bool) -> Values:
    """The values of a fit; of a delay that it found half a sample less where a voltage is now `held`, which makes it so
    much later than a straight line between samples.
    """
    if not held or ARRIVES not in fitted.names:
        return fitted.values
    return {**fitted.values, ARRIVES: max(fitted.values[ARRIVES] - 0.5 * sample_time, 0.0)}


def _farther(experiment: Experiment, motions: Sequence[Motion], first: Simulated, start: Values) -> Simulated:
    """The same by way of pieces of the records."""
    fitting = Fitting(motions, first.fit.names, experiment.bounds)
    best = along_valley(fitting, fit_farther(first, fitting, start))
    return exactly(best, fitting) if best.is_near and best is not first else best


def simulation_stage(
    experiment: Experiment,
    start: SimulationStart,
    base: Simulated,
    with_them: Simulated | None,
    progress: Progress,
) -> SimulationStage:
    """Let effects compete for what the plant leaves, without any and with those that the balances found.

    A plant that none of them brings near to noise may have lost its way: it is fitted once more, by way of pieces.
    """
    motions, given = base.fit.balance.motions, _given(base, start) if with_them is not None else {}
    found = _stage(experiment, motions, start, base, with_them, given, progress)
    if found.after.excess > NEAR_NOISE:
        progress("simulating pieces of the records", 0.7)
        before = base, with_them
        base = _farther(experiment, motions, base, start.baseline)
        if with_them is not None:
            with_them = _farther(experiment, motions, with_them, start.corrected)
        if base is not before[0] or with_them is not before[1]:
            found = _stage(experiment, motions, start, base, with_them, given, progress)
    return _held_otherwise(experiment, motions, start, base, found, given, progress)


def _held_otherwise(
    experiment: Experiment,
    motions: Sequence[Motion],
    start: SimulationStart,
    base: Simulated,
    found: SimulationStage,
    given: Effects,
    progress: Progress,
) -> SimulationStage:
    """The search once more with the voltage between samples as it was not taken to be, where that leaves less with what
    was found: effects stand in for a voltage that holds where it does not, and a delay of half a sample for one that
    does.
    """
    other = shooting_of(experiment, motions, held=not found.how.held)
    if other is None or not (found.effects and found.is_near):
        return found
    values = _as_late(found.after, motions[0].record.sample_time, other.held)
    if not _may_leave_less(replace(found.how, setups=other.setups, held=other.held), found.after, values):
        return found
    fitting = Fitting(motions, found.after.names, experiment.bounds)
    otherwise = fitting.final(fitting.found(other, values))
    if otherwise.fit.rms >= found.after.rms:
        return found
    own = Fitting(motions, base.fit.names, experiment.bounds)
    effective = {name for numbers in found.effects.values() for name in numbers}
    without = declared_again(otherwise.fit.values, effective, start.declared)
    plain = own.final(own.found(other, without))
    with_them = exactly(otherwise, fitting) if plain.fit.excess > NEAR_NOISE else None
    again = _stage(experiment, motions, start, plain, with_them, found.effects if with_them else {}, progress)
    return replace(again, dropped=[effect for effect in given if effect not in again.effects])


def _stage(
    experiment: Experiment,
    motions: Sequence[Motion],
    start: SimulationStart,
    base: Simulated,
    with_them: Simulated | None,
    given: Effects,
    progress: Progress,
) -> SimulationStage:
    """One search from the fit of the plant without effects or with those that were `given`, and what it lacks then."""
    bounds = experiment.bounds
    before, current, how, dropped = base.fit, base.fit, base.how, list[str]()
    effects: Effects = {}
    if with_them is not None:
        if with_them.fit.rms < _left_over(base, with_them.how.length, motions):
            current, effects, how = with_them.fit, given, with_them.how
        else:  # the record itself speaks against them
            dropped = list(given)
    lacks, stood_in = None, tuple[str, ...]()
    settled = lru_cache(SETTLED)(lambda fit: settle(how, motions, fit, bounds))
    ask = Asked(start.declared, bounds, len(how.effects), start.shapes, settle=settled)
    if Simulated(how, current).is_near:
        progress("what the simulated plant lacks", 0.6)
        found = search(current, effects, ask)
        progress("what no effect explains", 0.8)
        named = tuple(found.effects)
        without = without_effects(found.fit, found.effects, ask)
        found, lacks = _without_stand_ins(how, found, without, ask)
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
        dropped=dropped,
        lacks=lacks,
        stood_in=stood_in,
    )


def _left_over(of: Simulated, length: float, motions: Sequence[Motion]) -> float:
    """Rms that a plant leaves of pieces of that length, without bound if it follows shorter ones alone."""
    if of.how.length == length:
        return of.fit.rms
    shorter = replace(of.how, length=length, begins={})
    return Fitting(motions, (), {}).begun(shorter, of.fit.values).fit.rms if of.how.length > length else np.inf


def _without_stand_ins(how: Shooting, found: Found, without: Fit, ask: Asked) -> tuple[Found, Dependence | None]:
    """What was found, and on what depends that which no effect explains. Nothing is found where something is left
    beside many effects, or beside few where one curve in their place loses nothing; nor where effects leave nothing,
    but one curve would do for them. `without` is the fit without effects.
    """
    pushes = lacking(how, found.fit)
    lacks = dependence_of(pushes)
    if not found.effects:
        return found, lacks
    cost = sum(ask.of(effect, names, found.fit.balance) for effect, names in found.effects.items())
    place = Place.of(found.fit, found.effects, 0.5 * (without.squares - found.fit.squares), ask)
    instead = standing_in(how, place, pushes, cost if lacks is None else None)
    if instead or (lacks is not None and len(found.effects) >= MANY):
        found = replace(found, fit=without, effects={}, gains={}, alternatives={})
        lacks = dependence_of(instead or lacking(how, without)) or lacks
    return found, lacks
