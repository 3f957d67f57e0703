"""The plant simulated along its records, without effects and with those that balances found, fitted as near as it gets.

A fit begins at once. What is far from noise then may lack something, or have lost its way: to look beyond hollows is
dear, to lead it along its records by loops dearer, and both are left to whom nothing else brings near.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from workbench.diagnose.residuals.fit import NEAR_NOISE, Fit, weighed_fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Bounds, Values
from workbench.diagnose.selection.selection import Effects
from workbench.diagnose.selection.sets import Asked
from workbench.diagnose.selection.trials import Shapes
from workbench.diagnose.simulation.filters import filtered, least_doubt
from workbench.diagnose.simulation.fits import (
    AT_NOISE,
    Fitting,
    Simulated,
    afresh,
    exactly,
    fit_simulation,
    settle,
)
from workbench.diagnose.simulation.lacking import BESIDE
from workbench.diagnose.simulation.nearer import fit_as_sensed, fit_led, fit_over_hollows
from workbench.diagnose.simulation.setup import as_coloured, as_quick, blurs, is_coloured, shooting_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.valleys import along_valley
from workbench.fitting.covariance import inverse
from workbench.fitting.threads import side_by_side
from workbench.progress import Progress
from workbench.records.experiment import Experiment

STRAIGHTENED = 1.25
"""Times the squares that a fit leaves far from noise, up to which another may leave less that leaves so much to first
order."""

SETTLED = 16
"""Fits of which it is remembered where they settle: a search asks for some more than once."""

LESS, ABOUT, LOST = 4.0, 2.0, 1e3
"""Times that a filter doubts its force less than the one before; up to which parameters may change between two; and
standard deviations from which a plant that a filter keeps beside its record is lost.
"""


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


def asked_of(how: Shooting, motions: Sequence[Motion], start: SimulationStart, bounds: Bounds) -> Asked:
    """What a search among effects of a plant that is simulated so may move, and what it asks of them."""

    def settling(motions: Sequence[Motion]) -> Callable[[Fit], Fit]:
        return lru_cache(SETTLED)(lambda fit: settle(how, motions, fit, bounds))

    times = BESIDE if how.is_beside else 1.0
    ask = Asked(start.declared, bounds, len(how.effects), start.shapes, settle=settling(motions), times=times)
    if all(motion.thinning == 1 for motion in motions):
        return ask
    every = as_quick(motions)
    whole = how.balance(every, ())
    return replace(ask, shown=lambda fit: weighed_fit(whole, fit.values, ()), all_samples=settling(every))


def simulated_baseline(
    experiment: Experiment, motions: Sequence[Motion], start: SimulationStart, progress: Progress
) -> Simulated | None:
    """The declared plant simulated along the records from end to end, the motions of whose fit are those to go on with;
    None where they cannot be simulated. One that is far from noise may lack something, or have lost its way:
    `farther_baseline`.
    """
    progress("simulating the declared plant", 0.2)
    begun = _begun(experiment, motions, [start.baseline], start.free, _as_declared(start, start.baseline))
    return None if begun is None else _baseline(experiment, settled(experiment, *begun))


def farther_baseline(experiment: Experiment, base: Simulated, start: SimulationStart, progress: Progress) -> Simulated:
    """The same, of one that is far from noise, over hollows. What is astray then may have lost its way, or lack much:
    `nearer_baseline`.
    """
    progress("looking for the declared plant beyond hollows")
    fitting = Fitting(base.fit.balance.motions, base.fit.names, experiment.bounds)
    best = base if base.how.is_beside else fit_over_hollows(base, fitting)
    best = _nearer(best, fitting, start.baseline) if best.is_near else best
    return base if best is base else _baseline(experiment, settled(experiment, best, fitting))


def nearer_baseline(experiment: Experiment, base: Simulated, start: SimulationStart, progress: Progress) -> Simulated:
    """The same once more, by ways that lead nearer to noise."""
    progress("leading the declared plant along its records")
    fitting = Fitting(base.fit.balance.motions, base.fit.names, experiment.bounds)
    return _baseline(experiment, settled(experiment, _nearer(base, fitting, start.baseline), fitting))


def _baseline(experiment: Experiment, base: Simulated) -> Simulated:
    """The same on motions that show what noise is like that has memory, or what is quick."""
    if not base.is_near:
        return base
    motions = base.fit.balance.motions
    finer = as_coloured(motions) if is_coloured(base.fit) else motions
    finer = as_quick(motions) if blurs(base.how, base.fit) else finer
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
    given = given_by(base, start)
    if not given:
        return None
    progress("simulating the plant with what was found", 0.5)
    names = [*base.fit.names, *(name for own in given.values() for name in own)]
    beside = _beside(base, start, names)
    begun = _begun(experiment, base.fit.balance.motions, [beside, start.corrected], names, _as_declared(start, beside))
    assert begun is not None  # the plant without effects was
    best, fitting = begun
    far = best.fit.excess > NEAR_NOISE and not best.how.is_beside
    return settled(experiment, fit_over_hollows(best, fitting) if far else best, fitting)


def nearer_with(
    experiment: Experiment, base: Simulated, them: Simulated, start: SimulationStart, progress: Progress
) -> Simulated:
    """The same once more, by ways that lead nearer to noise."""
    progress("leading the plant with what was found along its records")
    fitting = Fitting(them.fit.balance.motions, them.fit.names, experiment.bounds)
    return settled(experiment, _nearer(them, fitting, _beside(base, start, them.fit.names)), fitting)


def _beside(base: Simulated, start: SimulationStart, names: Sequence[str]) -> dict[str, float]:
    """The values of the plant without effects, and of what it has not those that balances found."""
    return {**base.fit.values, **{name: start.corrected[name] for name in names if name not in base.fit.names}}


def _as_declared(start: SimulationStart, values: Values) -> Values:
    """Values with the plant's own parameters as they are declared."""
    return {**values, **{name: start.declared[name] for name in start.free}}


def given_by(base: Simulated, start: SimulationStart) -> Effects:
    """The effects that balances found and that the simulated plant can have."""
    known = base.how.along.parameter_names
    return {effect: names for effect, names in start.effects.items() if set(names) <= known}


def _begun(
    experiment: Experiment,
    motions: Sequence[Motion],
    starts: Sequence[Values],
    names: Sequence[str],
    declared: Values,
) -> tuple[Simulated, Fitting] | None:
    """The plant fitted to simulation error from some starts, with those parameters that it has, and how it was; None
    where the records cannot be simulated. The voltage of a valve holds from sample to sample. What is kept beside its
    records begins as it is `declared`, too.
    """
    held = shooting_of(experiment, motions, held=True)
    if held is None:
        return None
    fitting = Fitting(motions, [name for name in names if name in held.along.parameter_names], experiment.bounds)
    if held.is_beside:
        return _fit_beside(experiment, held, fitting, [*starts, declared]), fitting
    return fit_simulation(held, fitting, starts), fitting


def _fit_beside(experiment: Experiment, held: Shooting, fitting: Fitting, starts: Sequence[Values]) -> Simulated:
    """The same of a plant that filters keep beside its records: from the first start, and from others as long as none
    leads near noise. At last the force holds from sample to sample or is a straight line, what leaves less: errors are
    so small then that half a sample counts.
    """
    motions, reached = fitting.motions, list[Simulated]()
    for start in starts:
        reached.append(_less_doubtful(held, fitting, start))
        if reached[-1].fit.excess < NEAR_NOISE:
            break
    values = min(reached, key=lambda one: one.fit.rms).fit.values
    ramps = shooting_of(experiment, motions, held=False)
    assert ramps is not None  # the other was
    fits = side_by_side(lambda how: fit_simulation(filtered(how, motions, values), fitting, [values]), (held, ramps))
    return min(fits, key=lambda one: one.fit.rms)


def _less_doubtful(held: Shooting, fitting: Fitting, start: Values) -> Simulated:
    """The plant with filters that doubt its force less from fit to fit, each found with the parameters of the one
    before; the more one doubts the less it tells, and the farther parameters that it hardly tells would go.
    """
    motions, values, doubt = fitting.motions, start, np.inf
    while True:
        stays = least_doubt(held, motions, values)
        doubt = stays if stays < doubt else max(doubt / LESS, 1.0)
        near = {name: (values[name] / ABOUT, values[name] * ABOUT) for name in fitting.names if values[name] > 0.0}
        bounded = replace(fitting, bounds={**fitting.bounds, **near}) if doubt > 1.0 else fitting
        best = fit_simulation(filtered(held, motions, values, doubt), bounded, [values])
        if doubt <= 1.0:
            return best
        if best.fit.rms > LOST:
            return fitting.begun(filtered(held, motions, start), start)
        values = best.fit.values


def _nearer(best: Simulated, fitting: Fitting, start: Values) -> Simulated:
    """The same, if it is far from noise, by loops that lead it from `start` on, with starts as they are sensed or that
    follow the parameters, and from there over hollows.
    """
    if best.fit.excess < NEAR_NOISE:
        return best
    sensed = fit_as_sensed(best, fitting, start)
    if sensed.fit.excess < NEAR_NOISE:
        return sensed
    led = fit_led(sensed, fitting, start)
    return led if led is best or led.fit.excess < NEAR_NOISE else fit_over_hollows(led, fitting)


def settled(experiment: Experiment, best: Simulated, fitting: Fitting) -> Simulated:
    """The same with a voltage that is a straight line between samples, if that leaves less, and out of the last
    hollows: a wrong one leaves more than noise, which would be taken for a hollow.
    """
    best = _as_commanded(experiment, exactly(best, fitting), fitting)
    further = along_valley(fitting, best)  # a coarse solver has hollows of its own
    best = best if further is best else _as_commanded(experiment, further, fitting)
    return exactly(afresh(best, fitting), fitting) if best.is_near else best


def _as_commanded(experiment: Experiment, best: Simulated, fitting: Fitting) -> Simulated:
    """The same with a voltage that is a straight line between samples, if that leaves less."""
    if not best.is_near or best.how.is_beside:
        return best
    ramps = shooting_of(experiment, fitting.motions, held=False)
    assert ramps is not None  # the other was
    ramps = ramps.with_tolerance(best.how.tolerance)
    if not may_leave_less(replace(ramps, begins=best.how.begins), best.fit, best.fit.values):
        return best
    straight = fitting.final(fitting.found(ramps, best.fit.values))  # the voltage was no computer's
    if straight.fit.rms >= best.fit.rms:
        return best
    if straight.fit.excess <= AT_NOISE:
        return straight
    again = fitting.final(fitting.found(replace(best.how, begins={}), straight.fit.values))  # or it was, and this has
    return min(straight, again, key=lambda one: one.fit.rms)  # led out of a hollow


def may_leave_less(how: Shooting, fitted: Fit, values: Values) -> bool:
    """Whether another way to simulate may leave less, by what it leaves beside `values` to first order in the
    parameters of a fit: beside one at noise, which nothing leaves less of, first order has to show it.
    """
    left, own = fitted.weighing(how.balance(fitted.balance.motions, ()).stacked(values)), fitted.jacobian
    own = own * fitted.free
    left = left - own @ (inverse(fitted.curvature) @ (own.T @ left))
    most = STRAIGHTENED if fitted.excess > AT_NOISE else 1.0
    return bool(left @ left < most * (fitted.weighed @ fitted.weighed))
