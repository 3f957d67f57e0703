"""What the position (or an open-loop input) is asked to do, with exact derivatives.

A reference is a function of time. At a jump the later value holds. `dwells` are the spans in which it is constant;
`period` is what repeats, `fundamental` the frequency at which a phase lag is meant.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

Signal = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Value, first and second derivative over time."""


class ReferenceSignal(Protocol):
    """What every reference offers."""

    @property
    def period(self) -> float | None:
        """Time after which it repeats (s), or None."""

    @property
    def fundamental(self) -> float | None:
        """Frequency (Hz) of the sine that a phase lag refers to, or None."""

    def dwells(self, duration: float) -> list[tuple[float, float]]:
        """Spans (s) within [0, duration] in which the reference is constant."""

    def __call__(self, time: np.ndarray) -> Signal:
        """Value, first and second derivative at `time` (s)."""


class Moving:
    """A reference that rests nowhere that is known, and does not repeat: for others to say what else they are."""

    @property
    def period(self) -> float | None:
        return None

    @property
    def fundamental(self) -> float | None:
        return None

    def dwells(self, duration: float) -> list[tuple[float, float]]:
        return []


@dataclass(frozen=True)
class Wave(Moving):
    """A reference of this `amplitude` that repeats with this `frequency` (Hz)."""

    amplitude: float
    frequency: float

    @property
    def period(self) -> float:
        return 1.0 / self.frequency

    @property
    def fundamental(self) -> float | None:
        return self.frequency


@dataclass(frozen=True)
class Sine(Wave):
    """offset + amplitude sin(2 pi f t + phase)."""

    offset: float = 0.0
    phase: float = 0.0

    def __call__(self, time: np.ndarray) -> Signal:
        w = 2.0 * np.pi * self.frequency
        angle = w * time + self.phase
        sine = np.sin(angle)
        return (
            self.offset + self.amplitude * sine,
            w * self.amplitude * np.cos(angle),
            -w * w * self.amplitude * sine,
        )


@dataclass(frozen=True)
class Steps(Moving):
    """The levels one after another, each held for `dwell` seconds, the last to the end; from `start`, before it 0."""

    levels: tuple[float, ...]
    dwell: float
    start: float = 0.0

    def dwells(self, duration: float) -> list[tuple[float, float]]:
        begins = [self.start + i * self.dwell for i in range(len(self.levels))]
        ends = [*begins[1:], duration]
        return [(a, min(b, duration)) for a, b in zip(begins, ends, strict=True) if a < duration]

    def __call__(self, time: np.ndarray) -> Signal:
        # Sample instants are k h: a little slack keeps a jump at its own instant, not one sample late.
        index = np.floor((time - self.start) / self.dwell + 1e-9).astype(int)
        values = np.array([0.0, *self.levels])[np.clip(index + 1, 0, len(self.levels))]
        return values, np.zeros_like(time), np.zeros_like(time)


@dataclass(frozen=True)
class Ramp(Moving):
    """`offset` until `start`, then at `rate` until `stop`, then constant."""

    rate: float
    start: float = 0.0
    stop: float = np.inf
    offset: float = 0.0

    def dwells(self, duration: float) -> list[tuple[float, float]]:
        spans = [(0.0, min(self.start, duration)), (self.stop, duration)]
        return [(a, b) for a, b in spans if a < b]

    def __call__(self, time: np.ndarray) -> Signal:
        moving = (time >= self.start) & (time < self.stop)
        value = self.offset + self.rate * (np.clip(time, self.start, self.stop) - self.start)
        return value, np.where(moving, self.rate, 0.0), np.zeros_like(time)


@dataclass(frozen=True)
class Held(Moving):
    """Another reference up to an `instant` (s) within one of its dwells, and what it is then from there on."""

    signal: ReferenceSignal
    instant: float

    def dwells(self, duration: float) -> list[tuple[float, float]]:
        spans = self.signal.dwells(min(self.instant, duration))
        return [*spans[:-1], (spans[-1][0], duration)] if duration > self.instant else spans

    def __call__(self, time: np.ndarray) -> Signal:
        return self.signal(np.minimum(time, self.instant))


@dataclass(frozen=True)
class Triangle(Wave):
    """offset + a triangle wave of `amplitude` that starts upward at 0: constant speed through each reversal."""

    offset: float = 0.0

    def __call__(self, time: np.ndarray) -> Signal:
        cycle = np.mod(time * self.frequency + 0.25, 1.0)
        rising = cycle < 0.5
        value = self.amplitude * np.where(rising, 4.0 * cycle - 1.0, 3.0 - 4.0 * cycle)
        speed = 4.0 * self.amplitude * self.frequency
        return self.offset + value, np.where(rising, speed, -speed), np.zeros_like(time)


@dataclass(frozen=True)
class Multisine(Wave):
    """Sum of harmonics of `frequency` with equal amplitudes, scaled to the peak `amplitude`; it starts at 0.

    Phases after Schroeder (1970), which keep the peak low; the value at t = 0 is taken off.
    """

    harmonics: tuple[int, ...]

    @property
    def fundamental(self) -> None:
        return None

    def _sum(self, time: np.ndarray) -> Signal:
        value, first, second = (np.zeros_like(time, dtype=float) for _ in range(3))
        count = len(self.harmonics)
        for i, harmonic in enumerate(self.harmonics):
            w = 2.0 * np.pi * self.frequency * harmonic
            angle = w * time - np.pi * i * (i + 1) / count
            value += np.sin(angle)
            first += w * np.cos(angle)
            second -= w * w * np.sin(angle)
        return value, first, second

    def __call__(self, time: np.ndarray) -> Signal:
        grid = np.linspace(0.0, self.period, 200 * max(self.harmonics), endpoint=False)
        start = self._sum(np.zeros(1))[0][0]
        scale = self.amplitude / np.max(np.abs(self._sum(grid)[0] - start))
        value, first, second = self._sum(time)
        return scale * (value - start), scale * first, scale * second


@dataclass(frozen=True)
class Chirp(Moving):
    """A sine whose frequency rises linearly from `start_frequency` to `end_frequency` over `sweep` seconds."""

    amplitude: float
    start_frequency: float
    end_frequency: float
    sweep: float

    def __call__(self, time: np.ndarray) -> Signal:
        slope = 2.0 * np.pi * (self.end_frequency - self.start_frequency) / self.sweep
        sweeping = time < self.sweep
        clipped = np.minimum(time, self.sweep)
        w = 2.0 * np.pi * self.start_frequency + slope * clipped
        angle = 2.0 * np.pi * self.start_frequency * clipped + 0.5 * slope * clipped**2
        angle = angle + np.where(sweeping, 0.0, w * (time - self.sweep))
        sine, cosine = np.sin(angle), np.cos(angle)
        bend = np.where(sweeping, slope, 0.0)
        a = self.amplitude
        return a * sine, a * w * cosine, a * (bend * cosine - w * w * sine)


@dataclass(frozen=True, eq=False)
class Recorded(Moving):
    """A record (times in s, values), as a cubic spline; constant before its start and after its end."""

    times: np.ndarray
    values: np.ndarray

    def __call__(self, time: np.ndarray) -> Signal:
        from scipy.interpolate import CubicSpline  # slow to import, and no other reference needs it

        spline = CubicSpline(self.times, self.values)
        clipped = np.clip(time, self.times[0], self.times[-1])
        inside = clipped == time
        first, second = (np.where(inside, spline(clipped, order), 0.0) for order in (1, 2))
        return spline(clipped), first, second
