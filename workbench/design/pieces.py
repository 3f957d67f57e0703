"""Pieces of a motion: sums of sines, steps with holds, ramps through reversal, slow strokes and sweeps.

Each is three shares of what the rig allows, between 0 and 1, which a search moves: how large it is, how fast, and about
which place of the range. It begins and ends at rest in the middle of the range, so that pieces can follow each other.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from workbench.simulation.references import Chirp, Multisine, ReferenceSignal, Steps, Triangle

HARMONICS = (1, 2, 3, 5, 8)
"""Of a sum of sines."""

SMALLEST, SLOWEST = 3e-3, 3e-3
"""Of half the range and of the largest speed: from there to all of it a size and a speed are chosen, log-uniform."""

LARGEST_STEP = 0.5
"""Of half the range."""

HOLDS = (0.25, 3.0)
"""s, of a step; the longest is a quarter of the piece at most."""

SWEPT = 20.0
"""Fastest frequency of a sweep over its slowest."""

APPROACH = 0.1
"""Share of a piece in which it goes to its place, and at its end comes back, at least."""

PEAK_SPEED, PEAK_ACCELERATION = 1.875, 5.774
"""Of a motion of least jerk over a way of 1 in a time of 1."""

ROUNDING = 1e-9
"""Relative, of a number of periods: one that is whole but for the last digits is whole."""

SAMPLES_A_PERIOD = 20.0
"""Of the fastest sine, at least."""


class Reach(NamedTuple):
    """What a reference may ask for: values between `low` and `high`, no faster than `speed`, of a rig that is sampled
    every `sample_time` (s). Of a closed loop positions (m or rad), of an open one commands.
    """

    low: float
    high: float
    speed: float
    sample_time: float

    @property
    def middle(self) -> float:
        """Where pieces begin and end."""
        return 0.5 * (self.low + self.high)

    @property
    def half(self) -> float:
        """Half the range."""
        return 0.5 * (self.high - self.low)


class Condition(NamedTuple):
    """At which speed of rotation (rad/s), and under which load (N or N m) beside what is declared, a piece is run."""

    rotation: float = 0.0
    load: float = 0.0


@dataclass(frozen=True)
class Piece:
    """A piece of a `kind`, its three shares, how long it lasts (s), and under which condition."""

    kind: str
    shares: tuple[float, float, float]
    duration: float
    condition: Condition

    def with_shares(self, shares: np.ndarray) -> "Piece":
        """The same kind of piece, larger, faster or elsewhere."""
        size, pace, place = np.clip(shares, 0.0, 1.0).tolist()
        return replace(self, shares=(size, pace, place))


class Shaped(NamedTuple):
    """A piece as a signal about its `place` (m, rad or of the command), after an approach (s), in words and numbers."""

    signal: ReferenceSignal
    place: float
    approach: float
    numbers: Mapping[str, float]


Shape = Callable[[float, float, float], tuple[ReferenceSignal, dict[str, float]]]
"""(size, speed, span) -> signal that begins at 0, and its numbers (SI)."""


def _sines(size: float, speed: float, span: float, reach: Reach) -> tuple[ReferenceSignal, dict[str, float]]:
    trial = Multisine(size, 1.0, HARMONICS)
    fastest = float(np.max(np.abs(trial(np.linspace(0.0, 1.0, 2000))[1])))
    highest = 1.0 / (SAMPLES_A_PERIOD * HARMONICS[-1] * reach.sample_time)
    frequency = _whole(min(speed / fastest, highest), span)
    return Multisine(size, frequency, HARMONICS), {"amplitude": size, "frequency": frequency}


def _steps(size: float, speed: float, span: float, reach: Reach) -> tuple[ReferenceSignal, dict[str, float]]:
    size *= LARGEST_STEP
    shortest, longest = HOLDS
    share = np.log(speed / (SLOWEST * reach.speed)) / -np.log(SLOWEST)
    longest = max(min(longest, span / 4.0), shortest)
    hold = float(longest * (shortest / longest) ** share)
    levels = (size, 0.0, -size, 0.0) * max(int(span / (4.0 * hold)), 1)
    return Steps(levels, hold), {"amplitude": size, "hold": hold}


def _ramps(size: float, speed: float, span: float, reach: Reach) -> tuple[ReferenceSignal, dict[str, float]]:
    frequency = _whole(speed / (4.0 * size), span)
    return Triangle(size, frequency), {"amplitude": size, "speed": 4.0 * size * frequency}


def _slow_strokes(size: float, speed: float, span: float, reach: Reach) -> tuple[ReferenceSignal, dict[str, float]]:
    size = min(size, 0.25 * speed * span)
    return Triangle(size, 1.0 / span), {"amplitude": size, "speed": 4.0 * size / span}


def _sweep(size: float, speed: float, span: float, reach: Reach) -> tuple[ReferenceSignal, dict[str, float]]:
    highest = min(speed / (2.0 * np.pi * size), 1.0 / (SAMPLES_A_PERIOD * reach.sample_time))
    fast = max(highest, 2.0 / span)
    slow = fast / SWEPT
    return Chirp(size, slow, fast, span), {"amplitude": size, "from": slow, "to": fast}


KINDS: Mapping[str, Callable[[float, float, float, Reach], tuple[ReferenceSignal, dict[str, float]]]] = {
    "sines": _sines,
    "steps": _steps,
    "ramps": _ramps,
    "slow strokes": _slow_strokes,
    "sweep": _sweep,
}
"""Each makes a signal that begins at 0 of a size, a speed, its span (s) and what the rig allows."""


def _whole(frequency: float, span: float) -> float:
    """The fastest frequency up to the one that is asked with whole periods in a span (s), of which there is one."""
    return max(int(frequency * span * (1.0 + ROUNDING)), 1) / span


def shaped(piece: Piece, reach: Reach) -> Shaped:
    """The signal of a piece on a rig."""
    size, pace, place = piece.shares
    half = reach.half * SMALLEST ** (1.0 - size)
    speed = reach.speed * SLOWEST ** (1.0 - pace)
    away = (2.0 * place - 1.0) * (reach.half - half)
    approach = max(APPROACH * piece.duration, PEAK_SPEED * abs(away) / reach.speed)
    approach = min(approach, 0.3 * piece.duration)
    away = float(np.clip(away, -approach * reach.speed / PEAK_SPEED, approach * reach.speed / PEAK_SPEED))
    signal, numbers = KINDS[piece.kind](half, speed, piece.duration - 2.0 * approach, reach)
    return Shaped(signal, reach.middle + away, approach, numbers)


def sampled(piece: Piece, reach: Reach) -> np.ndarray:
    """The reference of a piece at its samples, shape (samples,): it goes to its place, moves there, and comes back."""
    of = shaped(piece, reach)
    time = reach.sample_time * np.arange(samples(piece, reach))
    inside = np.clip(time - of.approach, 0.0, piece.duration - 2.0 * of.approach)
    moving = np.where(time < of.approach, 0.0, of.signal(inside)[0])
    late = np.clip((piece.duration - time) / of.approach, 0.0, 1.0)
    begun = np.clip(time / of.approach, 0.0, 1.0)
    there = _least_jerk(begun) * _least_jerk(late)
    return np.asarray(reach.middle + there * (of.place - reach.middle) + _least_jerk(late) * moving)


def samples(piece: Piece, reach: Reach) -> int:
    """Of a piece."""
    return round(piece.duration / reach.sample_time)


def _least_jerk(share: np.ndarray) -> np.ndarray:
    """From 0 to 1 with the least jerk: 10 s^3 - 15 s^4 + 6 s^5 (Flash and Hogan 1985)."""
    return np.asarray(share**3 * (10.0 - share * (15.0 - 6.0 * share)))
