"""Effects that are sought while a loop leads the plant along its records.

Far from noise a run from end to end breaks away elsewhere with every parameter, and what an effect would change to
first order there is no guide. A loop takes most of what builds up, so that the plant stays beside its records: there
first order leads far. What was found so is then fitted to free runs, which decide.

Some plants no run follows from end to end, not even with their very parameters: over the hills of a cogging force the
noise of a start grows until it decides on which side a mass comes down. What leads such a plant near noise beside loops
that are weaker by far is decided beside the weakest of these.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice

from plants.effects.registry import effects
from workbench.diagnose.residuals.fit import NEAR_NOISE, Fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.selection.search import Found, search
from workbench.diagnose.selection.selection import Effects, Step
from workbench.diagnose.simulation.fits import ASTRAY, BETTER, NOISE, Fitting, Simulated
from workbench.diagnose.simulation.nearer import crossovers, fit_as_sensed, fit_evolved, weaker
from workbench.diagnose.simulation.reached import SimulationStart, asked_of
from workbench.diagnose.simulation.setup import shooting_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.records.experiment import Experiment

SEARCHES, LOOPS = 2, 6
"""Loops beside which effects are sought, and loops that are tried, from the quickest, at most."""

CARRIES = 4.0
"""Times that a loop is weaker at least beside which what was found keeps a plant near noise than the one beside which
it was found: what makes up for a way that was lost does so beside one loop."""


@dataclass(frozen=True, eq=False)
class FoundLed:
    """The plant from end to end with what was found beside a loop: its effects, the rounds of the search, and what each
    effect gains there in the logarithm of the likelihood. Where no free run is near noise it is beside a loop, as it is
    `alone` without effects.
    """

    simulated: Simulated
    effects: Effects
    steps: Sequence[Step]
    gains: Mapping[str, float]
    alone: Simulated | None = None


def found_led(
    experiment: Experiment, motions: Sequence[Motion], base: Simulated, start: SimulationStart
) -> FoundLed | None:
    """What brings the plant nearest to noise of that which loops show, without any loop or beside one; None where
    nothing brings it nearer than it is without effects. A loop beside which nothing is left, or beside which the plant
    is astray, shows nothing, and one that leaves as much as no loop what that shows. The command holds from sample to
    sample: so far from noise nobody can tell.
    """
    whole = shooting_of(experiment, motions, held=True)
    assert whole is not None  # the plant without effects was simulated
    fitting, values = Fitting(motions, base.fit.names, experiment.bounds), start.baseline
    reached, searched = list[FoundLed](), 0
    for crossover in islice(crossovers(whole, motions, values), LOOPS):
        led = fitting.final(fitting.found(whole.led(motions, values, crossover), values))
        values = led.fit.values
        if led.fit.excess > ASTRAY or searched == SEARCHES:
            break
        if led.fit.excess > NOISE and led.fit.rms < BETTER * base.fit.rms:
            searched += 1
            found = search(led.fit, {}, asked_of(led.how, motions, start, experiment.bounds))
            beside = carried(whole, fitting, led, found)
            if beside is not None and _freely(whole, fitting, beside.simulated.fit).fit.excess > NEAR_NOISE:
                return beside
            for one in _each_freely(whole, fitting, found):
                reached.append(one)
                if one.simulated.fit.excess < NEAR_NOISE:
                    return one
    best = min(reached, key=lambda one: one.simulated.fit.rms, default=None)
    return best if best is not None and best.simulated.fit.rms < BETTER * base.fit.rms else None


def _freely(whole: Shooting, fitting: Fitting, led: Fit) -> Simulated:
    """A fit beside a loop, fitted to free runs."""
    own = replace(fitting, names=led.names)
    free = fit_as_sensed(own.final(own.begun(whole, led.values)), own, led.values)
    return fit_evolved(free, own, led) if led.excess < NEAR_NOISE else free


def _each_freely(whole: Shooting, fitting: Fitting, found: Found) -> Iterator[FoundLed]:
    """What a search found, fitted to free runs, as it was after each of its rounds: what comes late may make up for
    numbers that free runs tell better.
    """
    known, tried = effects(found.fit.balance.axis), {frozenset(fitting.names)}
    for place, one in enumerate([*(step.before for step in found.steps[1:]), found.fit]):
        if frozenset(one.names) in tried:
            continue
        tried.add(frozenset(one.names))
        numbers = {
            name: tuple(number for number in effect.numbers if number in one.names) for name, effect in known.items()
        }
        yield FoundLed(
            _freely(whole, fitting, one),
            {name: those for name, those in numbers.items() if those and not set(those) <= set(fitting.names)},
            found.steps[: place + 1],
            found.gains,
        )


def carried(whole: Shooting, fitting: Fitting, led: Simulated, found: Found) -> FoundLed | None:
    """What a search beside a loop found, beside the weakest loop that keeps the plant near noise with it; None where
    that is no weaker by far.
    """
    sought = led.how.crossover
    if sought is None or not found.effects or found.fit.excess > NOISE:
        return None
    own, motions, best = replace(fitting, names=found.fit.names), fitting.motions, Simulated(led.how, found.fit)
    for crossover in islice(weaker(sought, motions), 1, None):
        how = whole.led(motions, best.fit.values, crossover)
        weak = own.found(replace(how, begins=best.how.begins), best.fit.values)
        if weak.fit.excess > NOISE:
            break
        best = weak
    if best.how.crossover is None or best.how.crossover > sought / CARRIES:
        return None
    alone = fitting.final(fitting.found(replace(best.how, begins={}), led.fit.values))
    return FoundLed(own.final(best), dict(found.effects), found.steps, found.gains, alone)
