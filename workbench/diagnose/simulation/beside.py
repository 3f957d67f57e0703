"""A plant beside a record of which a sensor shows what drives it.

What a computer commands is known, and the plant is driven by it alone. A force that a sensor shows has noise, which a
mass integrates twice: of such records what tells is by how much the plant fails to foresee the next position, kept
beside those before it (prediction errors: Ljung 1999, sections 3 and 7). An extended Kalman filter keeps it there
(Jazwinski 1970, section 8.3), which knows the noise of both sensors and the contact:

    K = P H' / S,   S = H P H' + s_x^2,   P <- F (I - K H) P F' + G G' s_F^2,   F = e^(A T)

A are the derivatives of the plant's rates along the motion. Under way noise of the force moves a mass, and what is
measured corrects it; a contact that rests holds it, and is hardly corrected, so that nothing shakes it loose. The gains
go with time, and are found before a fit, not in it: then errors of one fit and another are as likely by the same
measure. The correction K e of a sample acts as a constant rate until the next one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import expm

from controllers import pid
from controllers.pid import PID
from plants.compiled import njit
from plants.equation import fields, to_array
from plants.observed import INNOVATION, MOTION, corrected, gain_of
from workbench.diagnose.residuals.along import Along
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.shown import given_by
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.residuals.walk import NUDGE
from workbench.fitting.replay import Sampled
from workbench.simulation.references import Moving, Signal
from workbench.simulation.setup import Feed, Loop, Setup
from workbench.simulation.simulate import Run

UNDER_WAY = 5.0
"""Standard deviations of the velocity from which noise does not decide in which direction a contact goes."""

PASSING, FORGOTTEN = 10.0, 6.0
"""Times one over the filter's bandwidth in which a rod that turns back is under way again, till when noise has not done
much; and after which it has forgotten how a rest ended: when a contact breaks away a little noise decides.
"""

CREEPS = 2.0 / np.pi
"""Square of the mean magnitude of noise, over its variance."""


@dataclass(frozen=True, eq=False)
class Followed(Moving):
    """A measured position that a plant beside a record is to foresee: `corrections` are rates for each of the states
    that are `corrected`, over the error, shape (samples, states), `spread` the standard deviation of that error over
    the sensor's noise, and where that `tells` something, all at the `samples` (s).
    """

    times: np.ndarray
    values: np.ndarray
    samples: np.ndarray
    corrected: tuple[str, ...]
    corrections: np.ndarray
    spread: np.ndarray
    tells: np.ndarray

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


def kept_beside(setup: Setup, along: Along, motion: Motion, values: Values, run: Run | None = None) -> Setup:
    """The setup with a filter by which a plant with `values` foresees each position of the record from those before;
    it knows the contact as the smoothed motion bends it, or as a `run` beside the record did.
    """
    record = motion.record
    corrections, spread, tells = _filtered(along, motion, values, run)
    known = np.isfinite(record.channels["position"])
    times, position = record.time[known], record.channels["position"][known]
    reference = Followed(times, position, record.time, corrected(along.plant), corrections, spread, tells)
    unit = PID.design(pid.Settings(kp=1.0), along.parameters(values), record.sample_time)
    return replace(setup, loop=Loop(PID, unit, INNOVATION), reference=reference)


def _filtered(
    along: Along, motion: Motion, values: Values, run: Run | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What `Followed` has of a filter along a motion, or along a run: corrections, spread, and where it tells."""
    names, step = corrected(along.plant), motion.record.sample_time
    states, inputs, parameters = _passed(along, motion, values, names, run)
    rates, pushed = _linearised(along, motion, values, names, states, inputs, parameters)
    count = len(names)
    both = np.zeros((rates.shape[0], 2 * count, 2 * count))
    both[:, :count, :count], both[:, :count, count:] = rates, np.eye(count)
    whole = expm(step * both)
    moved, held = np.ascontiguousarray(whole[:, :count, :count]), whole[:, :count, count:]
    noise = motion.sensed["force"], max(motion.sensed["position"], 1e-30)
    speed = np.abs(states[:, along.names.index("velocity")])
    gains, spread, tells = riccati(moved, held @ pushed * noise[0], noise[1], speed, step)
    return np.linalg.solve(held, moved @ gains[:, :, None])[:, :, 0], spread / noise[1], tells


def _passed(
    along: Along, motion: Motion, values: Values, names: Sequence[str], run: Run | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States and inputs (samples, ...) that a plant with `values` goes through along a motion, or went through in a
    run, and its parameters.
    """
    tracked = along.tracked(motion, values, [name for name in names if name not in MOTION])
    states = tracked.states(slice(None))
    if run is not None:
        states[:, [along.names.index(item.name) for item in fields(run.plant.State)]] = run.states
    return states, tracked.inputs, to_array(tracked.parameters)


def _linearised(
    along: Along,
    motion: Motion,
    values: Values,
    names: Sequence[str],
    states: np.ndarray,
    inputs: np.ndarray,
    parameters: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of the rates of the states `names` by these, shape (samples, states, states), and by the command,
    shape (states,).
    """
    places, sizes = [along.names.index(name) for name in names], along.magnitudes(motion, values)

    def rates(states: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        return along.rates(motion.time, states, inputs, parameters)[:, places]

    out = np.zeros((motion.time.size, len(names), len(names)))
    for column, place in enumerate(places):
        move = np.zeros(states.shape[1])
        move[place] = NUDGE * sizes[place]
        out[:, :, column] = (rates(states + move, inputs) - rates(states - move, inputs)) / (2.0 * move[place])
    command = np.zeros(inputs.shape[1])
    command[along.plant.input_index(along.plant.command)] = 1.0
    pushed = rates(states[:1], inputs[:1] + command) - rates(states[:1], inputs[:1])
    return out, pushed[0]


@njit(cache=True, nogil=True)
def riccati(
    moved: np.ndarray, pushed: np.ndarray, noise: float, speed: np.ndarray, step: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gains, shape (samples, states), standard deviations of the innovations, and where these tell something, of a
    Kalman filter that sees the first state with a `noise`.

    Its transitions are `moved` (samples, states, states); noise of one drives it by `pushed` (samples, states). Where
    noise decides in which direction it goes, since its `speed` is no more, friction is no straight line: the noise
    makes it creep by the mean of its own speed, as no machine does; and when it breaks away from a rest. The filter
    begins as uncertain as it ends.
    """
    samples, count = pushed.shape
    gains, spread, tells = np.zeros((samples, count)), np.zeros(samples), np.ones(samples, dtype=np.bool_)
    uncertain, most = noise**2 * np.eye(count), np.max(np.abs(pushed[:, 1]))
    pace = np.sqrt(step * noise / most) / step if most > 0.0 else 0.0
    for _ in range(2):
        rested, remembers = 0, 0.0
        for k in range(samples):
            variance = uncertain[0, 0] + noise**2
            gain = uncertain[:, 0] / variance
            gains[k], spread[k] = gain, np.sqrt(variance)
            left = np.eye(count)
            left[:, 0] -= gain
            kept = left @ uncertain @ left.T + noise**2 * np.outer(gain, gain)
            kept = moved[k] @ kept @ moved[k].T + np.outer(pushed[k], pushed[k])
            uncertain = 0.5 * (kept + kept.T)
            goes = speed[k] ** 2 > UNDER_WAY**2 * uncertain[1, 1]
            if goes and rested > PASSING * pace:
                remembers = FORGOTTEN * pace
            rested, remembers = 0 if goes else rested + 1, remembers - 1.0
            tells[k] = goes and remembers <= 0.0
            uncertain[0, 0] += (2 * rested - 1) * CREEPS * step**2 * uncertain[1, 1] if rested else 0.0
    return gains, spread, tells


def is_sensed(along: Along, motion: Motion) -> bool:
    """Whether it is a sensor of force alone that shows what drives the plant."""
    channels = motion.record.channels
    return given_by(channels, along.plant.command) == ("force",) and "pressure_1" not in channels
