"""A plant that is far from noise, with a curve for what a balance lacks over a signal.

Where a balance depends on a signal and no effect explains it, the plant's parameters make up for a part of what is
missing, and a simulation goes astray by them. A curve of the plant's own (`plants.effects.curves`), fitted to the
balance beside the parameters, gives both in seconds, and a place from which a simulation comes near its records. If it
does, and does not without the curve, that is what the plant lacks: an effect that is known, if one does in the place of
the curve, or one that nobody knows.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from workbench.diagnose.residuals.fit import NEAR_NOISE, Fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.selection.balance_curves import HIGHEST, CurveFit
from workbench.diagnose.selection.likelihood import Outlook, Proposal, gained, left_by
from workbench.diagnose.selection.search import LEVEL
from workbench.diagnose.selection.selection import Effects
from workbench.diagnose.selection.sets import Asked, away_of, declared_again, fitted_with, is_estimated
from workbench.diagnose.selection.trials import seen_of, together, trials_of
from workbench.diagnose.selection.unexplained import (
    Dependence,
    OfferedTerm,
    TermErrors,
    Unexplained,
    is_moving,
    rms_moving,
)
from workbench.diagnose.simulation.fits import ASTRAY, Fitting, Simulated, fit_simulation
from workbench.diagnose.simulation.reached import SimulationStart, asked_of, settled
from workbench.diagnose.simulation.setup import shooting_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.fitting.threads import side_by_side
from workbench.progress import Progress
from workbench.records.experiment import Experiment

NEARLY, FITTED = 0.1, 2
"""Share of what a curve gains that an effect may lose in its place, to first order, and be fitted there; and how many
are, at most."""


STEPPED = 0.1
"""Share of what a plant that is astray leaves that it may leave with a curve and count as led to its records, however
far that is from noise: straight lines between a dozen nodes do not follow what steps or bends at a place.
"""


@dataclass(frozen=True, eq=False)
class Curved:
    """A plant near its records with a curve for what a balance lacks: the curve's fit to that balance, the plant
    simulated with it, and what is left without it. It has the `effects` that other balances named.
    """

    fitted: CurveFit
    simulated: Simulated
    without: Fit
    effects: Effects

    @property
    def own(self) -> Fit:
        """The fit, of which the plant's own parameters are told."""
        names = tuple(name for name in self.simulated.fit.names if name not in self.fitted.nodes)
        return replace(self.simulated.fit, names=names)

    @cached_property
    def gain(self) -> float:
        """What the curve gains in the logarithm of the likelihood."""
        found = self.simulated.fit
        return gained(found.balance, left_by(found), left_by(self.without))

    @property
    def dependence(self) -> Dependence:
        """On what depends that which no effect explains."""
        return Dependence(self.fitted.fit.balance.name, {self.fitted.signal: 1.0}, self.gain)

    def along(self, experiment: Experiment, motions: Sequence[Motion]) -> Shooting:
        """The plant with the curve from end to end of other records."""
        whole = shooting_of(replace(experiment, plant=self.fitted.plant), motions, held=self.simulated.how.held)
        assert whole is not None  # one record of an experiment is simulated as another is
        return whole

    def unexplained(self, after: Fit, held_out: Sequence[Motion]) -> Unexplained:
        """What it leaves unexplained: the curve is what is offered for it, beside a fit of the balance without it."""
        curve, values = self.fitted, self.simulated.fit.values
        _, low, high, *nodes = curve.effect.own_names
        offered = OfferedTerm(
            curve.signal,
            np.linspace(values[low], values[high], len(nodes)),
            np.array([values[name] for name in nodes]),
            after.balance.unit,
            *(
                TermErrors(
                    rms_moving(after.balance, motions, after.values), rms_moving(curve.fit.balance, motions, values)
                )
                if is_moving(after.balance, motions)
                else None
                for motions in (after.balance.motions, held_out)
            ),
        )
        return Unexplained(self.dependence, offered)


def curved(
    experiment: Experiment,
    base: Simulated,
    them: Simulated | None,
    curves: Sequence[CurveFit],
    effects: Effects,
    start: SimulationStart,
    progress: Progress,
) -> tuple[Simulated, Simulated | None, Curved | None]:
    """The plant without effects, and that with those that balances named, nearer to their records where a curve has led
    there and is not needed; and the plant with these `effects` and the curve, where it is needed and comes near noise
    by it. Of the `curves` of balances that counts which leaves least.
    """
    curve = min(curves, key=lambda one: one.fit.rms, default=None)
    if curve is None or base.how.is_beside:
        return base, them, None
    progress("simulating the plant with a curve for what no effect explains", 0.55)
    near, given, most = None, effects, max(NEAR_NOISE, min(STEPPED * base.fit.excess, ASTRAY))
    while near is None:
        names = [*base.fit.names, *(name for own in effects.values() for name in own)]
        near = _simulated(experiment, base.fit.balance.motions, names, curve, most)
        if near is None or near.fit.excess > most:
            return base, them, None
        if idle := _idle(experiment, near, effects, start):
            gone = {name for effect in idle for name in effects[effect]}
            fitted = replace(curve.fit, values=declared_again(curve.fit.values, gone, start.declared))
            curve, near = replace(curve, fit=fitted), None
            effects = {effect: own for effect, own in effects.items() if effect not in idle}
    plain = _without(experiment, names, curve, near, near.fit.values)
    if effects and effects == given:
        them = plain if them is None or plain.fit.rms < them.fit.rms else them
    elif not effects:
        base = min(base, plain, key=lambda one: one.fit.rms)
    needed = plain.fit.excess > NEAR_NOISE
    return base, them, Curved(curve, near, plain.fit, effects) if needed else None


def _idle(experiment: Experiment, near: Simulated, effects: Effects, start: SimulationStart) -> list[str]:
    """Effects of balances that gain less beside a curve than is asked of them."""
    ask = asked_of(near.how, near.fit.balance.motions, start, experiment.bounds)
    outlook = Outlook(near.fit, {})
    return [
        effect
        for effect, own in effects.items()
        if -outlook.gain([], away_of(near.fit, own, ask))[0] < ask.of(effect, own, near.fit.balance)
    ]


def _simulated(
    experiment: Experiment, motions: Sequence[Motion], names: Sequence[str], curve: CurveFit, most: float
) -> Simulated | None:
    """The plant with a curve along its records from end to end; None where it leaves more than so many standard
    deviations, at `most`.
    """
    believed, values = replace(experiment, plant=curve.plant), curve.fit.values
    how = shooting_of(believed, motions, held=True)
    assert how is not None  # the plant without the curve was simulated
    highest = HIGHEST * max(abs(values[name]) for name in curve.nodes)
    bounds = {**experiment.bounds, **dict.fromkeys(curve.nodes, (-highest, highest))}
    fitting = Fitting(motions, [*names, *curve.nodes], bounds)
    near = fit_simulation(how, fitting, [values])
    if near.fit.excess < NEAR_NOISE:
        return settled(believed, near, fitting)
    return near if near.fit.excess < most else None  # what it leaves is no hollow's


def _without(
    experiment: Experiment, names: Sequence[str], curve: CurveFit, near: Simulated, values: Values
) -> Simulated:
    """The plant that is near its records with a curve, without it, fitted from these values on."""
    motions = near.fit.balance.motions
    how = shooting_of(experiment, motions, held=near.how.held)
    assert how is not None  # it was simulated with the curve
    fitting = Fitting(motions, names, experiment.bounds)
    plain = {name: value for name, value in values.items() if name not in curve.effect.own_names}
    return fitting.final(fitting.found(how.with_tolerance(near.how.tolerance), plain))


def in_its_place(experiment: Experiment, found: Curved, start: SimulationStart) -> tuple[Simulated, Effects] | None:
    """The plant with an effect that does in the place of a curve; None where none is as likely, with what is asked of
    either.
    """
    near, curve = found.simulated.fit, found.fitted
    ask = asked_of(found.simulated.how, near.balance.motions, start, experiment.bounds)
    taken = {curve.effect.name: curve.nodes}
    offers = _offers(near, taken, found, ask)
    fits = side_by_side(lambda offer: ask.settled(fitted_with(near, taken, offer, ask)), offers)
    known = [
        (gained(near.balance, left_by(near), left_by(other)) + ask.price_of(offer, taken, near.balance), offer, other)
        for offer, other in zip(offers, fits, strict=True)
        if is_estimated(other, near.balance)
    ]
    lost, offer, other = min(known, key=lambda one: one[0], default=(LEVEL, None, None))
    if offer is None or other is None or lost >= LEVEL:
        return None
    (trial,) = offer.added
    plain = _without(experiment, [*found.own.names, *trial.names], curve, found.simulated, other.values)
    return plain, {**found.effects, trial.effect: trial.names}


def _offers(near: Fit, taken: Effects, found: Curved, ask: Asked) -> list[Proposal]:
    """Effects that come near a curve in its place, to first order, from the best."""
    trials = trials_of(near, [*taken, *found.effects], ask.shapes)
    outlook = Outlook(near, together(seen_of(near, trials, ask.bounds), trials))
    away = {curve: away_of(near, nodes, ask) for curve, nodes in taken.items()}
    best = dict[str, Proposal]()
    for trial in outlook.columns:
        price = ask.price((trial,), list(taken), taken, near.balance)
        offer = outlook.proposal([trial], away, price)
        if trial.effect not in best or offer.score > best[trial.effect].score:
            best[trial.effect] = offer
    close = [offer for offer in best.values() if offer.gain > -NEARLY * found.gain]
    return sorted(close, key=lambda offer: -offer.score)[:FITTED]
