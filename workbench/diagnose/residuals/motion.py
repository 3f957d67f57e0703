"""A record as the balances see it: every channel smoothed alike, the position differentiated twice.

All channels pass one filter, a Hann window, or its derivatives: none is late or sharper than another, and a linear
balance that holds for the raw signals holds for these too. Local polynomials (Savitzky and
Golay 1964) do not do that: their second derivative and their mean pass different frequencies, and a measured drive's
mass comes out 6.6 % too large.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.ndimage import convolve1d, maximum_filter1d
from scipy.signal import oaconvolve

from workbench.records.reading import Record
from workbench.records.sampling.sight import FEWEST, window_points

WALKED = 0.002
"""s between the instants at which a plant goes along a motion, at most: what is hidden is followed exactly between
them, as long as what is measured hardly changes."""

THINNED = 0.01
"""s between the samples that a fit sees: smoothed channels hold no more."""

CREEP = 3.0
"""Standard deviations of the velocity's noise below which nothing is known to move."""

CROSSING = 0.1
"""s in which a rod that turns back crosses a backlash, at most: it does so just before the sensor moves."""

SHARP = 6.0
"""Standard deviations of noise by which half the window has to differ from the whole for a channel to be blurred."""

LEVELS = 4096
"""Levels that a channel's range has at most, those of twelve bits. A simulated record without any noise would have
effects of the digits in which its samples differ from its motion."""

UNIFORM = 12.0**-0.5
"""Standard deviation of what is spread evenly over one step of a converter."""

CLEAN = 5e-3
"""Share of a channel's deviation up to which no difference is a blur: in a record with less noise than that all is
blurred else, and nothing is left to judge."""

THROUGHOUT = 0.9
"""Share of a record from which it is blurred throughout."""

WIDE = 500
"""Points of a window from which its sums are made by Fourier transforms, whose time hardly grows with it."""

DIFFERENTIATED = ("pressure_1", "pressure_2", "rotation_speed", "motor_current")
"""Channels that show a state of which a balance gives the rate."""

DIFFERENCES = (
    np.array([1.0]),
    np.array([1.0, -9.0, 45.0, 0.0, -45.0, 9.0, -1.0]) / 60.0,
    np.array([2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0]) / 180.0,
)
"""Central differences of sixth order by the order of the derivative. Those of second order are 12 % small at 10 Hz in a
record of 100 Hz, and pressures, which are not differentiated, do not share that."""

REACH = 3
"""Points by which they reach beyond a window."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A record's smoothed channels (SI) over time; `valid` is False near its ends and gaps.

    `resting` is True where the noise of the velocity hides any motion, `blurred` where something happened too fast
    for the smoothing: a contact that breaks away in a few milliseconds. `slack` is the side of a backlash on which
    the rod is, from -1/2 to 1/2 of its width, with two derivatives: it changes at reversals, while the sensor rests.
    `measured` are the channels as they were, gaps bridged.

    `noise` has for each channel the standard deviation of its raw noise, that of twelve bits at least, `sensed` without
    that limit; `smooth` what the filter leaves of it, and of the position's derivatives: factors in 1, 1/s, 1/s^2.

    A fit looks at one sample of a `grain`, or `finer` times as often.
    """

    record: Record
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    channels: Mapping[str, np.ndarray]
    rates: Mapping[str, np.ndarray]
    measured: Mapping[str, np.ndarray]
    valid: np.ndarray
    resting: np.ndarray
    blurred: np.ndarray
    noise: Mapping[str, float]
    sensed: Mapping[str, float]
    smooth: tuple[float, float, float]
    slack: tuple[np.ndarray, np.ndarray, np.ndarray]
    finer: int = 1

    @property
    def creep(self) -> float:
        """Velocity (m/s) below which nothing is known to move."""
        return CREEP * self.smooth[1] * self.noise.get("position", 0.0)

    @property
    def sample_time(self) -> float:
        """Time (s) between the instants of the arrays."""
        return float(self.time[1] - self.time[0])

    @property
    def grain(self) -> int:
        """Samples in which smoothed channels hold no more than one of them does."""
        return max(round(THINNED / self.sample_time), 1)

    @property
    def thinning(self) -> int:
        """Every how many samples a fit looks at."""
        return max(self.grain // self.finer, 1)

    @cached_property
    def instants(self) -> np.ndarray:
        """The samples of a fit's instants: every `thinning`."""
        return np.arange(0, self.record.time.size, self.thinning)

    @property
    def stride(self) -> int:
        """Every how many samples a plant goes along: a divisor of the thinning."""
        most = max(int(WALKED / self.sample_time + 1e-6), 1)
        return max(step for step in range(1, most + 1) if self.thinning % step == 0)

    @cached_property
    def mean_speed(self) -> float:
        """Of what is valid (m/s)."""
        return float(np.mean(np.abs(self.velocity[self.valid])))

    @cached_property
    def top_speed(self) -> float:
        """Of what is valid (m/s)."""
        return float(np.max(np.abs(self.velocity[self.valid])))

    @cached_property
    def thinned(self) -> "Motion":
        """The motion at the instants at which a fit looks."""
        return self._every(self.thinning)

    @cached_property
    def walked(self) -> "Motion":
        """The motion at the instants at which a plant goes along; what was measured as means from one to the next."""
        every = self.stride
        starts = np.arange(0, self.time.size, every)
        sizes = np.diff(np.append(starts, self.time.size))
        means = {name: np.add.reduceat(values, starts) / sizes for name, values in self.measured.items()}
        return replace(self._every(every), measured=means)

    def _every(self, every: int) -> "Motion":
        """The motion at every so many instants."""
        return replace(
            self,
            time=self.time[::every],
            position=self.position[::every],
            velocity=self.velocity[::every],
            acceleration=self.acceleration[::every],
            channels={name: values[::every] for name, values in self.channels.items()},
            rates={name: values[::every] for name, values in self.rates.items()},
            valid=self.valid[::every],
            resting=self.resting[::every],
            blurred=self.blurred[::every],
            slack=(self.slack[0][::every], self.slack[1][::every], self.slack[2][::every]),
        )

    def has(self, *names: str) -> bool:
        """Whether these channels were measured; position is one of them."""
        return all(name in self.channels for name in names)


def load_pressure(motion: Motion) -> np.ndarray:
    """P1 - P2 (Pa); the one pressure where there is one; 0 without any."""
    zeros = np.zeros(motion.time.size)
    return np.asarray(motion.channels.get("pressure_1", zeros) - motion.channels.get("pressure_2", zeros))


def signals_of(motion: Motion) -> dict[str, np.ndarray]:
    """All on which a residual may depend, by name (SI)."""
    signals = {name: getattr(motion, name) for name in ("position", "velocity", "acceleration", "time")}
    for name in ("pressure_1", "pressure_2", "valve_voltage", "command", "rotation_angle"):
        if name in motion.channels:
            signals[name] = motion.channels[name]
    if motion.has("pressure_1", "pressure_2"):
        signals["load_pressure"] = load_pressure(motion)
    return signals


def with_backlash(motion: Motion, width: float) -> Motion:
    """The motion of the rod behind a backlash of a `width` (m): position and velocity with what the sensor
    does not see.
    """
    if width == 0.0:
        return motion
    hidden, rate, bend = motion.slack
    return replace(
        motion,
        position=motion.position + width * hidden,
        velocity=motion.velocity + width * rate,
        acceleration=motion.acceleration + width * bend,
    )


def with_pressure_offset(motion: Motion, offset: float) -> Motion:
    """The motion with the first pressure (Pa) as it is, where the sensor shows it by an offset too high."""
    if offset == 0.0 or not motion.has("pressure_1"):
        return motion
    return replace(motion, channels={**motion.channels, "pressure_1": motion.channels["pressure_1"] - offset})


def with_slack(motion: Motion, slack: np.ndarray) -> Motion:
    """The motion with another side of its backlash, from -1/2 to 1/2 at every sample of the record."""
    step = motion.record.sample_time
    return replace(motion, slack=_with_rates(slack, window_points(step), step))


def _with_rates(values: np.ndarray, points: int, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return smoothed(values, points), smoothed(values, points, 1, step), smoothed(values, points, 2, step)


def smoothed(values: np.ndarray, points: int, order: int = 0, sample_time: float = 1.0) -> np.ndarray:
    """Values smoothed over a window, or a derivative of them; beyond its ends a record goes on as it came, turned about
    the end: what moves there keeps its velocity.
    """
    kernel = _kernel(points, order, sample_time)
    reach = min(kernel.size // 2, values.size - 1)
    padded = np.pad(values, reach, mode="reflect", reflect_type="odd")
    return _weighed(padded, kernel)[reach : reach + values.size]


def _weighed(values: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    """The sum of weighed values about each of them."""
    if kernel.size < WIDE:
        return np.asarray(convolve1d(values, kernel, mode="nearest"))
    return np.asarray(oaconvolve(values, kernel, mode="same"))


def _kernel(points: int, order: int = 0, sample_time: float = 1.0) -> np.ndarray:
    """Weights of a Hann window, or of its first or second derivative (1/s, 1/s^2)."""
    weights = np.sin(np.pi * np.arange(1, points + 1) / (points + 1)) ** 2
    return np.convolve(weights / np.sum(weights), DIFFERENCES[order]) / sample_time**order


def white_noise(values: np.ndarray) -> float:
    """Standard deviation of a channel's noise, from its third differences, which a slow signal lacks.

    It is at least that of the steps in which a converter counts, uniform over one step: a slow signal rests on them.
    """
    known = values[np.isfinite(values)]
    return max(fluctuation(known), converter_step(known) * UNIFORM)


def converter_step(values: np.ndarray) -> float:
    """The least difference between two values of a channel: a step of its converter, or next to nothing."""
    levels = np.diff(np.unique(values[np.isfinite(values)]))
    return float(np.min(levels)) if levels.size else 0.0


def fluctuation(values: np.ndarray) -> float:
    """Standard deviation of white noise with such third differences, by their median, which few large ones leave."""
    third = np.diff(values, 3)
    return float(np.sqrt(np.median(third**2) / 0.4549 / 20.0)) if third.size else 0.0


def ways_of(velocity: np.ndarray, creep: float) -> np.ndarray:
    """The direction of a motion at each instant, -1 to 1: between them where it creeps."""
    return np.asarray(velocity / (np.abs(velocity) + max(creep, 1e-30)))


def motion_of(record: Record) -> Motion:
    """Smooth and differentiate a record. A gap is bridged for the filter alone, and what it touches is not valid."""
    step, points = record.sample_time, window_points(record.sample_time)
    places = np.arange(record.time.size)
    bridged = {}
    for name, values in record.channels.items():
        known = np.isfinite(values)
        bridged[name] = np.interp(places, places[known], values[known])
    reach = points // 2 + REACH
    whole = maximum_filter1d((~record.valid).astype(np.uint8), 2 * reach + 1, mode="constant", cval=1) == 0
    zeros = np.zeros(record.time.size)
    position = bridged.get("position", zeros)
    channels = {name: smoothed(values, points) for name, values in bridged.items()}
    rates: dict[str, np.ndarray] = {
        name: smoothed(values, points, 1, step) for name, values in bridged.items() if name in DIFFERENTIATED
    }
    smooth = tuple(float(np.linalg.norm(_kernel(points, order, step))) for order in range(3))
    sensed = {name: white_noise(values) for name, values in record.channels.items()}
    noise = {name: max(std, UNIFORM * float(np.ptp(bridged[name])) / LEVELS) for name, std in sensed.items()}
    velocity = smoothed(position, points, 1, step)
    creep = CREEP * smooth[1] * noise.get("position", 0.0)
    slack = _slack(velocity, creep, step)
    return Motion(
        record=record,
        time=record.time,
        position=smoothed(position, points),
        velocity=velocity,
        acceleration=smoothed(position, points, 2, step),
        channels=channels,
        rates=rates,
        measured=bridged,
        valid=whole,
        resting=np.asarray(maximum_filter1d(np.abs(velocity), 2 * points) <= creep),
        blurred=_blurred(bridged, noise, points, step),
        noise=noise,
        sensed=sensed,
        smooth=(smooth[0], smooth[1], smooth[2]),
        slack=_with_rates(slack, points, step),
    )


def _blurred(channels: Mapping[str, np.ndarray], noise: Mapping[str, float], points: int, step: float) -> np.ndarray:
    """Where a pressure or a force differs between the window and half of it by more than noise, and a window around;
    where none is measured the acceleration. A record that is blurred throughout has no better part.
    """
    half = max(2 * (points // 4) + 1, FEWEST - 2)
    fast = np.zeros(next(iter(channels.values())).size)
    shown = [name for name in ("pressure_1", "pressure_2", "force") if name in channels]
    for name, order in [(name, 0) for name in shown] or [("position", 2)] * ("position" in channels):
        narrow, wide = (smoothed(channels[name], width, order, step) for width in (half, points))
        left = noise[name] * float(np.linalg.norm(_kernel(half, order, step)))
        least = CLEAN * float(np.std(wide if order else channels[name])) * float(np.linalg.norm(_kernel(half)))
        fast += np.abs(narrow - wide) > SHARP * max(left, least)
    blurred = np.asarray(maximum_filter1d((fast > 0).astype(float), points) > 0)
    return blurred if np.mean(blurred) < THROUGHOUT else np.zeros_like(blurred)


def _slack(velocity: np.ndarray, creep: float, step: float) -> np.ndarray:
    """Where the rod is in a backlash: with the side that it pushes while it moves, crossing before it pushes
    the other.
    """
    moving = np.flatnonzero(np.abs(velocity) > creep)
    if moving.size == 0:
        return np.zeros(velocity.size)
    sides = 0.5 * np.sign(velocity[moving])
    turns = np.flatnonzero(np.diff(sides) != 0.0)
    places, values = [0.0], [float(sides[0])]
    for turn in turns.tolist():
        end, begin = float(moving[turn]), float(moving[turn + 1])
        places += [max(end, begin - CROSSING / step), begin]
        values += [float(sides[turn]), float(sides[turn + 1])]
    return np.interp(np.arange(velocity.size), places, values)
