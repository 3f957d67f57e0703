"""What a balance lacks over a signal, as a curve of the plant's own that is fitted beside its parameters.

A residual that depends on a signal is what parameters leave that make up for a part of what is missing. A curve over
the signal (`plants.effects.curves`) takes that from them: where it brings the balance to its floor, both are right.
"""

from dataclasses import dataclass, replace

import numpy as np

from plants.effects.attach import possible
from plants.effects.interface import Effect
from plants.interface import Plant
from workbench.diagnose.residuals.balances import balances_of, richest
from workbench.diagnose.residuals.baseline import baseline
from workbench.diagnose.residuals.fit import Fit, over, weighing_at
from workbench.diagnose.residuals.motion import signals_of
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.selection.likelihood import asked, gained, left_by
from workbench.diagnose.selection.search import LEVEL
from workbench.diagnose.selection.selection import BalanceResult
from workbench.diagnose.selection.sets import Asked
from workbench.diagnose.selection.unexplained import ABOVE, curve_over, dependence, is_made_of
from workbench.records.experiment import Experiment

HIGHEST = 3.0
"""Times the largest residual that a balance leaves, beyond which no node of a curve goes: where a record hardly is, it
says nothing of it."""

FLOOR = 1.15
"""Floors up to which what is left is at its floor: where nothing is missing nine machines in ten leave no more."""

TAKEN = 0.3
"""Share of what a balance leaves without effects that it leaves at most with a curve that is worth looking at, if that
is above its floor."""


@dataclass(frozen=True, eq=False)
class CurveFit:
    """A balance with a curve over a signal, fitted beside its own parameters: the curve, its range and nodes, and on
    which plant.
    """

    signal: str
    effect: Effect
    plant: Plant
    fit: Fit

    @property
    def nodes(self) -> tuple[str, ...]:
        """The curve's values, by name."""
        return tuple(self.effect.own_names[3:])

    def is_likelier(self, result: BalanceResult, ask: Asked) -> bool:
        """Whether the curve is likelier than the effects of a balance, with what is asked of either."""
        balance, after = self.fit.balance, result.after
        price = asked(len(self.nodes), ask.candidates)
        price -= sum(ask.of(effect, names, result.balance) for effect, names in result.effects.items())
        _, left, vague = left_by(self.fit)
        own = weighing_at(self.fit), left, vague  # the fit may have led far from where it was weighed
        return gained(balance, own, left_by(after)) > price + LEVEL


def curve_of(experiment: Experiment, result: BalanceResult, values: Values, declared: Values) -> CurveFit | None:
    """The curve over a signal, of those on which a balance still depends, or depends without effects that leave more
    than its floor, that takes most of what it leaves without them; None if none takes enough. `values` are those that
    fit the balances.
    """
    before = result.before
    depends = dependence(result.balance, result.after.values) if before.names else None
    if depends is None and result.effects and result.after.rms > FLOOR:
        depends = dependence(result.balance, before.values)
    fits = list[CurveFit]()
    for signal in depends.signals if depends is not None else ():
        effect = curve_over(richest(experiment.plant), result.balance.name, signal)
        if effect is None or is_made_of(result.balance, signal) or effect.name in experiment.plant.effects:
            continue
        fits.append(fitted_curve(experiment, before, signal, effect, {**values, **before.moved}, declared))
    best = min(fits, key=lambda one: one.fit.rms, default=None)
    return best if best is not None and best.fit.rms < max(TAKEN * before.rms, ABOVE) else None


def fitted_curve(
    experiment: Experiment, before: Fit, signal: str, effect: Effect, values: Values, declared: Values
) -> CurveFit:
    """A curve over a signal that is fitted to a balance, with its parameters from where they are declared and from
    where they were `before`, without it.
    """
    balance = before.balance
    effect, whole = effect.along(experiment.plant.axis), richest(experiment.plant)
    had = [one for one in possible(whole) if one.name in experiment.plant.effects]
    plant = (whole.bare or whole).with_effects(*had, effect)
    share, low, high, *nodes = effect.own_names
    along = [signals_of(motion)[signal] for motion in balance.motions]
    flat = {share: 1.0, low: min(map(np.min, along)), high: max(map(np.max, along)), **dict.fromkeys(nodes, 0.0)}
    believed = replace(experiment, plant=plant)
    (own,) = (one for one in balances_of(believed, balance.motions, {**values, **flat}) if one.name == balance.name)
    own = replace(own, free=(*balance.free, *nodes))
    highest = HIGHEST * balance.floor * float(np.max(np.abs(before.residual)))
    bounds = {**experiment.bounds, **dict.fromkeys(nodes, (-highest, highest))}
    starts = [{**values, **{name: declared[name] for name in balance.free}, **flat}, {**values, **flat}]
    fits = list[Fit]()
    for start in starts:
        fits.append(baseline(own, start, bounds))
        if fits[-1].rms < ABOVE:  # of the sensors' noise
            break
    best = min(fits, key=lambda one: one.rms)
    return CurveFit(signal, effect, plant, over(best, replace(best.balance, floor=balance.floor)))
