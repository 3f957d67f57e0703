"""How an experiment's plant is simulated along its records, and how far it follows them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plants.equation import fields
from workbench.diagnose.residuals.balances import diagnosed_plant, effects_told, priors_of, scales_of
from workbench.diagnose.residuals.fit import Fit, stacks
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.simulation.beside import is_sensed
from workbench.diagnose.simulation.shooting import Shooting
from workbench.errors import UserError
from workbench.fitting.replay import observe
from workbench.records.experiment import Experiment
from workbench.records.reading import Record
from workbench.simulation.simulate import Setup

AWAY, ODD = 30.0, 1e3
"""Times what a record shows of the position at which a simulation has left it, and times what is typical of a state up
to which it goes in any case.
"""

COLOURED, FINER = 1.1, 4
"""Standard deviations of what is left over those of what could not be foreseen of it, from which it is coloured; and
times that a fit then looks more often.
"""

KEPT = 0.9
"""Share of what a parameter changes of all samples that the means at which a fit looks are to keep of it."""

MANY = 100_000
"""Samples of all channels from which a fit looks at means over some of them."""

ASTRAY = 0.1
"""Share of the measured position's standard deviation by which a simulation may be off and not start anew."""


def shooting_of(experiment: Experiment, motions: Sequence[Motion], *, held: bool = True) -> Shooting | None:
    """How to simulate `experiment`'s plant along motions from end to end; None where they hold no input of it.

    `held`: the valve's voltage holds from sample to sample, as a computer gives it, and is no straight line between.
    What is beside its records has no filters yet that keep it there: `filters`.
    """
    along = diagnosed_plant(experiment.plant, experiment.flow, motions[0].channels)
    believed = replace(experiment, plant=along.plant)
    setups, channels = dict[Record, Setup](), tuple[str, ...]()
    beside = is_sensed(along, motions[0])
    for motion in motions:
        record = motion.record
        if beside:
            record = replace(record, channels={**record.channels, along.plant.command: record.channels["force"]})
        try:
            observed = observe(record, believed)
        except UserError:
            return None
        feeds = tuple(
            replace(feed, linear=not (held and feed.input == along.plant.command)) for feed in observed.setup.feeds
        )
        channels = tuple(observed.measured)
        if "position" not in channels:
            return None
        setups[motion.record] = replace(
            observed.setup, feeds=feeds, sample_time=record.sample_time, farthest=_farthest(observed.setup, motion)
        )
    told = effects_told(along.plant, motions[0].channels)
    scales, priors = scales_of(motions, experiment.known_values()), priors_of(experiment, motions[0].channels)
    return Shooting(along, setups, channels, held, scales, told, beside, priors=priors)


def _farthest(setup: Setup, motion: Motion) -> float:
    """When a simulation has left its record for good: what runs away on it takes all that is stiff with it, and ever
    longer.
    """
    typical = next(item.scale for item in fields(setup.plant.State) if item.name == "position")
    return max(AWAY * float(np.max(np.abs(motion.measured["position"]))) / typical, ODD)


def as_simulated(experiment: Experiment, motions: Sequence[Motion]) -> list[Motion]:
    """Motions as a simulation looks at them: at every sample, as long as there are not `MANY`. Means over several keep
    less of what is quick, and under a loop, which passes on the noise of sensors, noise in them is taken for effects.
    A plant beside its record is to foresee every sample from those before, however many there are.

    What such a plant is off by is that of no loop behind a sensitivity S whose log|S| has the mean 0 over all
    frequencies up to half the sampling rate (Bode 1945, section 13; Sung and Hara 1988 for samples): a quicker loop
    makes the error of slow frequencies less and that of fast ones more. All samples together are as likely with the
    one as with the other. Means over some of them see the slow ones alone, and whatever makes the loop quicker, such as
    a load that hangs behind a spring, would gain by them.
    """
    if not motions:
        return []
    along = diagnosed_plant(experiment.plant, experiment.flow, motions[0].channels)
    samples = sum(values.size for motion in motions for values in motion.measured.values())
    return as_quick(motions) if samples <= MANY or is_sensed(along, motions[0]) else list(motions)


def is_coloured(fitted: Fit) -> bool:
    """Whether what a fit leaves of a channel can be foreseen from what it left before."""
    for slices in fitted.balance.series:
        for place, white in zip(slices, fitted.weighing.filters, strict=True):
            if white.numbers[0] * float(np.std(fitted.residual[place])) > COLOURED:
                return True
    return False


def as_coloured(motions: Sequence[Motion]) -> list[Motion]:
    """Motions as a simulation looks at them whose noise is coloured: means over a grain keep all that white noise lets
    one see of a slow motion, but noise that falls with the frequency hides least where it is fastest.
    """
    return [replace(motion, finer=max(motion.finer, FINER)) for motion in motions]


def blurs(how: Shooting, fitted: Fit) -> bool:
    """Whether the means at which a fit looks keep too little of what its parameters change, of most of them: what a
    quick machine shows goes to and fro from sample to sample. Each channel counts over what is left of it.
    """
    motions = fitted.balance.motions
    if not fitted.names or all(motion.thinning == 1 for motion in motions):
        return False
    balance = how.balance(as_quick(motions), fitted.names)
    every = replace(fitted, balance=balance, residual=stacks(balance, [fitted.values])[0])
    kept, whole = np.zeros(len(fitted.names)), np.zeros(len(fitted.names))
    for means, samples in zip(zip(*fitted.balance.series, strict=True), zip(*balance.series, strict=True), strict=True):
        left = float(np.sum([np.sum(every.residual[place] ** 2) for place in samples]))
        for total, one, places in ((kept, fitted, means), (whole, every, samples)):
            total += np.sum([np.sum(one.changes[place] ** 2, axis=0) for place in places], axis=0) / max(left, 1e-300)
    return bool(np.median(kept / np.maximum(whole, 1e-300)) < KEPT)


def as_quick(motions: Sequence[Motion]) -> list[Motion]:
    """Motions as a simulation looks at them whose means blur what it shows: at every sample."""
    return [replace(motion, finer=motion.grain) for motion in motions]


def follows(how: Shooting, motions: Sequence[Motion], values: Values) -> bool:
    """Whether the plant with `values` stays near what was measured on every record."""
    return all(_off(how, motion, values) < ASTRAY for motion in motions)


def _off(how: Shooting, motion: Motion, values: Values) -> float:
    """Rms of the position's error over the position's standard deviation; infinite where the plant diverges."""
    position = motion.measured["position"]
    error = position - how.simulated(motion, values)["position"]
    return float(np.nan_to_num(np.sqrt(np.mean(error**2)) / np.std(position), nan=np.inf))


def behind_backlash(whole: Shooting | None, motions: Sequence[Motion], values: Values) -> list[Motion]:
    """Motions with the rod on the side of a backlash where the simulated one is; as they are without a simulation."""
    return list(motions) if whole is None else [whole.with_backlash_of(motion, values) for motion in motions]
