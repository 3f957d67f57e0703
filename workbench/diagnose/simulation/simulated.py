"""The second look: effects compete for what the simulated plant leaves of the records.

The balances are quick and need no good start, but smoothing hides in them what is fast or small. With the parameters
that they give, the plant itself is simulated along the records and fitted to what its sensors showed. Where it lacks
nothing the sensors' noise is left; how much more is left is known, and a missing effect explains nearly all of that.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plants.equation import NEGATIVE, fields
from plants.two_chamber import TWO_CHAMBER
from workbench.diagnose.residuals.fitting import Fit, Search, fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import NEUTRAL, Values
from workbench.diagnose.selection.promising import EXPLAINS, QUICK, candidates, explained
from workbench.diagnose.selection.selection import (
    AT_FLOOR,
    LEAST_GAIN,
    MOST,
    SURE,
    BalanceResult,
    Candidate,
    Step,
    gain,
    is_level,
)
from workbench.diagnose.simulation.shooting import SEGMENT, Shooting, as_far_as_it_follows, set_up, simulation_balance
from workbench.diagnose.stages import Tell
from workbench.records.experiment import Experiment

SEARCH = Search(flat=1e-4, near=1e-5, most_steps=30)
"""Of the plant with what is known."""

NOISE = 1.5
"""Standard deviations of noise up to which nothing has to be explained further."""

TRUSTED = 3.0
"""Standard deviations of noise up to which the parameters of a simulated plant are believed before those that the
balances give: beyond it what the model lacks decides them, and what adds up over time most of all."""


PLAINLY = 1.0
"""Times the mean square by which it has to rise without an effect, to first order, that no fit has to be made without
it: that fit would be long, since nothing fits."""


@dataclass(frozen=True, eq=False)
class Simulated:
    """The plant fitted to simulation error: without effects, with those that the balances named, and after a look of
    its own, whose rounds are `steps`. `first` and `effects` hold each effect with its parameters; `dropped` are effects
    of the balances that the simulated plant does without.
    """

    how: Shooting
    before: Fit
    named: Fit
    first: Mapping[str, tuple[str, ...]]
    after: Fit
    effects: Mapping[str, tuple[str, ...]]
    steps: Sequence[Step]
    dropped: Sequence[str]

    @property
    def result(self) -> BalanceResult:
        """As a balance's: both fits, and the rounds."""
        return BalanceResult(self.after.balance, self.before, self.after, self.steps)

    @property
    def data(self) -> dict[str, Any]:
        """As report.json holds it: errors in standard deviations of the sensors' noise."""
        return {
            "before": self.before.rms,
            "after": self.after.rms,
            "channels": list(self.how.channels),
            "starts_anew_every_s": None if np.isinf(self.how.length) else self.how.length,
            "voltage_is_held": self.how.held,
            "parameters_from_it": self.is_trusted,
            "dropped": list(self.dropped),
        }

    @property
    def is_trusted(self) -> bool:
        """Whether what is left is so near to noise that the parameters are those of the machine."""
        return self.after.rms < TRUSTED

    @property
    def is_in_doubt(self) -> bool:
        """Whether this look added effects with which the plant is still far from noise: stand-ins, maybe."""
        return bool(set(self.effects) - set(self.first)) and not self.is_trusted

    def without_additions(self) -> "Simulated":
        """The same before its own look."""
        steps = [replace(self.steps[0], added=None, alternatives=[])]
        return replace(self, after=self.named, effects=self.first, steps=steps)


@dataclass(frozen=True)
class FirstLook:
    """What the balances hand on: the plant's own `free` parameters, as `declared`; the values at which searches begin,
    without effects and with those that were `found`, by name with their parameters.
    """

    free: Sequence[str]
    declared: Values
    baseline: Values
    corrected: Values
    found: Mapping[str, tuple[str, ...]]


def second_look(experiment: Experiment, motions: Sequence[Motion], first: FirstLook, tell: Tell) -> Simulated | None:
    """Fit the plant to simulation error with the effects that the balances found, and look again.

    None where the records cannot be simulated.
    """
    held = set_up(experiment, motions)
    if held is None:
        return None
    holds = {item.name for item in fields(held.plant.Parameters)}
    first = replace(
        first,
        free=[name for name in first.free if name in holds],
        found={effect: names for effect, names in first.found.items() if set(names) <= holds},
    )
    seen = _along(held, experiment, motions, first, tell)
    ramps = set_up(experiment, motions, held=False)
    if seen.after.rms > NOISE and ramps is not None:
        tried = replace(ramps, length=seen.how.length)
        if _error(tried, seen.after) < _error(seen.how, seen.after):  # the voltage was no computer's
            other = _along(ramps, experiment, motions, first, tell)
            seen = min(seen, other, key=lambda one: one.after.rms)
    return seen


def _along(
    whole: Shooting,
    experiment: Experiment,
    motions: Sequence[Motion],
    given: FirstLook,
    tell: Tell,
) -> Simulated:
    """The second look with a plant that is simulated in this way."""
    bounds, found = experiment.bounds, given.found
    tell("simulating the declared plant", 0.3)
    how = as_far_as_it_follows(whole, motions, given.baseline)
    before = _fitted(how, motions, given.baseline, given.free, bounds)
    current, effects, dropped = before, dict[str, tuple[str, ...]](), list[str]()
    if found:
        tell("simulating the plant with what was found", 0.4)
        with_them = as_far_as_it_follows(whole, motions, given.corrected)
        names = [*given.free, *(name for own in found.values() for name in own)]
        after = None
        if with_them.length >= how.length:  # else the record itself speaks against them
            after = _fitted(with_them, motions, given.corrected, names, bounds)
        if after is not None and (with_them.length > how.length or after.rms < before.rms):
            current, effects, how = after, dict(found), with_them
        else:
            dropped = list(found)
    named, first, steps = current, dict(effects), list[Step]()
    if how.plant is TWO_CHAMBER:
        own = {name: given.declared[name] for name in given.free}
        current, effects, steps = _look(current, effects, own, bounds, tell)
        current, effects, idle = _without_idle(current, effects, given.declared, bounds, tell)
        dropped += [effect for effect in idle if effect in found]
    before, current = (_with_honest_deviations(how, one) for one in (before, current))
    return Simulated(how, before, named, first, current, effects, steps, dropped)


def _error(how: Shooting, fitted: Fit) -> float:
    """Mean square of the simulation error with the values of a fit."""
    balance = simulation_balance(how, fitted.balance.motions, fitted.names)
    return float(np.nan_to_num(np.mean(balance.stacked(fitted.values) ** 2), nan=np.inf))


def _fitted(
    how: Shooting,
    motions: Sequence[Motion],
    start: Values,
    names: Sequence[str],
    bounds: Mapping[str, tuple[float, float]],
) -> Fit:
    """The plant fitted piece by piece, and from there as far as it follows: a contact that breaks away at another time
    puts hollows into the error of a long run.
    """
    near = fit(simulation_balance(replace(how, length=SEGMENT), motions, names), start, names, bounds, QUICK)
    if not np.isinf(how.length):
        return near
    return fit(simulation_balance(how, motions, names), near.values, names, bounds, SEARCH)


def _look(
    first: Fit,
    effects: Mapping[str, tuple[str, ...]],
    own: Values,
    bounds: Mapping[str, tuple[float, float]],
    tell: Tell,
) -> tuple[Fit, dict[str, tuple[str, ...]], list[Step]]:
    """Add effects one by one until none passes."""
    current, named, steps = first, dict(effects), list[Step]()
    while current.rms > AT_FLOOR and len(named) < MOST:
        tell(f"what the simulated plant lacks, round {len(steps) + 1}", 0.85 - 0.35 * 0.5 ** len(steps))
        found = candidates(current, named, bounds)
        passing = [one for one in found if _passes(current, one, named)]
        added = passing[0] if passing else None
        rivals = [one.effect for one in passing[1:] if added is not None and is_level(added, one)]
        steps.append(Step(current, found, added, rivals))
        if added is None:
            break
        named[added.effect] = tuple(dict.fromkeys([*named.get(added.effect, ()), *added.variant]))
        tell(f"the plant with {added.effect}, simulated", 0.85 - 0.25 * 0.5 ** len(steps))
        current = _polished(added.fit, own, bounds)
    return current, named, steps


def _polished(near: Fit, own: Values, bounds: Mapping[str, tuple[float, float]]) -> Fit:
    """A fit at its best; where more than noise is left, also from the plant's `own` parameters as declared."""
    best = fit(near.balance, near.values, near.names, bounds, SEARCH)
    if best.rms < NOISE:
        return best
    again = fit(near.balance, {**near.values, **own}, near.names, bounds, SEARCH)
    return min(best, again, key=lambda one: one.rms)


def _passes(before: Fit, one: Candidate, named: Mapping[str, object]) -> bool:
    """Whether an effect explains enough; a further parameter of one that is there has to be worth its price alone."""
    share, sure = gain(before, one.fit)
    enough = one.effect in named or explained(before, one.fit) > EXPLAINS
    estimated = not one.fit.bounded - set(before.balance.free)
    return share > LEAST_GAIN and sure > SURE and enough and estimated


def _neutral(name: str, values: Values, known: Values) -> float:
    """The value at which an effect's parameter does nothing: of one direction that of the other."""
    plain = name.removesuffix(f"_{NEGATIVE}")
    return values[plain] if plain != name else known.get(name, 0.0)


def _with_honest_deviations(how: Shooting, found: Fit) -> Fit:
    """A fit from end to end with the larger of its standard deviations and those of the same plant in pieces.

    The error of a long run has hollows: a contact that breaks away a little later shifts all that follows. A search
    stops in one of them, and its curvature is that of the hollow: a Coulomb friction came out 6 N off with a standard
    deviation of 0.02 N. Pieces are too short for it, and say 7 N. A fit that is far from noise stays as it is: what the
    plant lacks makes more of its pieces' errors than any parameter.
    """
    if not np.isinf(how.length) or found.rms > TRUSTED:
        return found
    pieces = simulation_balance(replace(how, length=SEGMENT), found.balance.motions, found.names)
    wide = fit(pieces, found.values, found.names, search=Search(most_steps=1)).deviations
    return replace(found, deviations={name: max(one, wide[name]) for name, one in found.deviations.items()})


def _without_idle(
    current: Fit,
    effects: dict[str, tuple[str, ...]],
    declared: Values,
    bounds: Mapping[str, tuple[float, float]],
    tell: Tell,
) -> tuple[Fit, dict[str, tuple[str, ...]], list[str]]:
    """Drop effects without which the rest does as well, the last first."""
    known = {**NEUTRAL, **declared}
    dropped = []
    for effect in list(reversed(effects)) if len(effects) > 1 else []:
        neutral = {name: _neutral(name, current.values, known) for name in effects[effect]}
        if current.rise_without(neutral) > PLAINLY * current.rms**2:
            continue
        tell(f"the plant without {effect}", 0.85)
        own = effects[effect]
        names = [name for name in current.names if name not in own]
        values = {name: value for name, value in current.values.items() if name not in own}
        values |= {name: known[name] for name in own if name in known}
        fitted = fit(current.balance, values, names, bounds, QUICK)
        if gain(fitted, current)[0] < LEAST_GAIN:
            current, effects = fitted, {name: one for name, one in effects.items() if name != effect}
            dropped.append(effect)
    return current, effects, dropped
