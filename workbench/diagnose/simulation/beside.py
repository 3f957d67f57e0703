"""A plant beside a record of which a sensor shows what drives it.

What a computer commands is known, and the plant is driven by it alone. A force that a sensor shows has noise, which a
mass integrates twice: of such records what tells is by how much the plant fails to foresee the next position, kept
beside those before it (prediction errors: Ljung 1999, sections 3 and 7). An extended Kalman filter keeps it there
(Jazwinski 1970, section 8.3), which knows the noise of both sensors and the contact:

    K = P H' / S,   S = H P H' + s_x^2,   P <- F (I - K H) P F' + G G' s_F^2

F and G are derivatives of where the plant goes within a sample, along the filter's own way. Under way noise of the
force moves a mass, and what is measured corrects it; a contact that rests holds it, and is hardly corrected, so that
nothing shakes it loose. Nothing is known of velocity and contact where a record begins: its first samples show them.
The gains go with time, and are found before a fit, not in it: then errors of one fit and another are as likely by the
same measure. The correction K e of a sample acts as constant rates r = B^-1 F K e until the next one.

A filter whose plant is far off goes astray, and gains along such a way lead no fit back. It is to `doubt` its force
more than the sensor's noise asks for, until what it does not foresee is hardly larger than it says.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from controllers import pid
from controllers.pid import PID
from plants.equation import to_array
from plants.observed import INNOVATION, MOTION, corrected, gain_of
from workbench.diagnose.residuals.along import Along
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.shown import given_by
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.simulation.kalman import fastest, keep_beside
from workbench.fitting.replay import Sampled
from workbench.simulation.compilation import plant_addresses
from workbench.simulation.references import Moving, Signal
from workbench.simulation.setup import Feed, Loop, Setup

NUDGED = 1e-6
"""Of a state's typical magnitude, or of the largest force, by which it is moved for a derivative."""

STEP, MOST_STEPS = 0.5, 256
"""Step within a sample over one over the plant's fastest rate, and steps at most: a contact so much faster is settled
at once."""

DOUBTS, STAYS = (1.0, 4.0, 16.0, 64.0, 256.0, 1024.0), 3.0
"""Times its noise for which a filter may have that of the force; and times what it says that it may not foresee."""


@dataclass(frozen=True, eq=False)
class Followed(Moving):
    """A measured position that a plant beside a record is to foresee: `corrections` are rates for each of the states
    that are `corrected`, over the error, shape (samples, states), `spread` the standard deviation of that error over
    the sensor's noise, both at the `samples` (s).
    """

    times: np.ndarray
    values: np.ndarray
    samples: np.ndarray
    corrected: tuple[str, ...]
    corrections: np.ndarray
    spread: np.ndarray

    def __call__(self, time: np.ndarray) -> Signal:
        return np.interp(time, self.times, self.values), np.zeros(time.size), np.zeros(time.size)

    def since(self, time: float) -> "Followed":
        """The same from a time (s) on."""
        return replace(self, times=self.times - time, samples=self.samples - time)

    @property
    def feeds(self) -> list[Feed]:
        """The gains, as inputs of the plant."""
        series = zip(self.corrected, self.corrections.T, strict=True)
        return [Feed(gain_of(name), Sampled(self.samples, own), linear=False) for name, own in series]


def kept_beside(setup: Setup, along: Along, motion: Motion, values: Values, doubt: float = 1.0) -> Setup:
    """The setup with a filter by which a plant with `values` foresees each position of the record from those before; it
    has the force's noise for so many times as large. Where such a plant is lost for good nothing corrects it.
    """
    record, plant = motion.record, along.plant
    corrections, spread, _ = _filters(setup, along, motion, values)(doubt)
    spread = np.where(np.isfinite(spread), spread, 1.0)
    reference = Followed(*_measured(motion), record.time, corrected(plant), corrections, spread)
    unit = PID.design(pid.Settings(kp=1.0), along.parameters(values), record.sample_time)
    return replace(setup, loop=Loop(PID, unit, INNOVATION), reference=reference)


def doubt_of(setup: Setup, along: Along, motion: Motion, values: Values) -> float:
    """The least of `DOUBTS` with which a plant with `values` stays beside a record; the most if it does with none."""
    filtered = _filters(setup, along, motion, values)
    for doubt in DOUBTS:
        _, spread, off = filtered(doubt)
        if np.sqrt(np.mean((off / spread) ** 2)) < STAYS:  # and not where it is lost
            return doubt
    return DOUBTS[-1]


def _measured(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Times (s) and positions that a record has."""
    position = motion.record.channels["position"]
    known = np.isfinite(position)
    return motion.record.time[known], position[known]


def _filters(
    setup: Setup, along: Along, motion: Motion, values: Values
) -> Callable[[float], tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """What gives for a doubt corrections and spread, as `Followed` has them, and what is not foreseen, over the noise
    of the position's sensor.
    """
    plant, span, names = along.plant, motion.record.sample_time, corrected(along.plant)
    places, command = np.array([along.names.index(name) for name in names]), plant.input_index(plant.command)
    tracked = along.tracked(motion, values, [name for name in names if name not in MOTION])
    idle, feeds = along.at_rest(motion, values)[1], tuple(arriving(setup.feeds, along, values))
    driven = replace(setup, parameters=tracked.parameters, inputs=idle, feeds=feeds)
    states, inputs = tracked.states(slice(None)), held_inputs(driven, motion.time)
    sizes = along.magnitudes(motion, values)[places]
    nudges, push = NUDGED * sizes, NUDGED * max(float(np.max(np.abs(inputs[:, command]))), 1e-30)
    whole = plant_addresses(plant)[0], to_array(tracked.parameters), places, nudges, command, push, span
    time = np.ascontiguousarray(motion.time)
    quickest = float(np.max(fastest((*whole, 1), time, np.ascontiguousarray(states), np.ascontiguousarray(inputs))))
    sampling = (*whole, int(np.clip(np.ceil(span * quickest / STEP), 1, MOST_STEPS)))
    (start,) = along.starting_states(motion, values, [0])
    noise = max(motion.sensed["position"], 1e-30)
    first = np.array([noise, float(np.max(np.abs(motion.velocity))), *sizes[len(MOTION) :]])
    position = np.interp(motion.time, *_measured(motion))

    def filtered(doubt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        noises = doubt * motion.sensed["force"], noise
        corrections, spread, off = keep_beside(sampling, time, to_array(start), inputs, position, noises, first)
        return corrections, spread / noise, off / noise

    return filtered


def arriving(feeds: Sequence[Feed], along: Along, values: Values) -> list[Feed]:
    """Feeds of which the command comes as late as it does to a plant with `values`."""
    late = along.late(values)
    return [replace(feed, delay=late) if feed.input == along.plant.command else feed for feed in feeds]


def held_inputs(setup: Setup, time: np.ndarray) -> np.ndarray:
    """Inputs (samples, inputs) as they act on average over each sample (s)."""
    plant, inputs = setup.plant, np.tile(to_array(setup.inputs), (time.size, 1))
    later = {name: float(delay(setup.parameters)) for name, delay in plant.delayed.items()}
    for feed in setup.feeds:
        for name, late in {feed.input: 0.0, **(later if feed.input == plant.command else {})}.items():
            series = feed.signal(time - feed.delay - late)[0]
            following = np.append(series[1:], series[-1])
            inputs[:, plant.input_index(name)] = 0.5 * (series + following) if feed.linear else series
    return inputs


def is_sensed(along: Along, motion: Motion) -> bool:
    """Whether it is a sensor of force alone that shows what drives the plant."""
    channels = motion.record.channels
    return given_by(channels, along.plant.command) == ("force",) and "pressure_1" not in channels
