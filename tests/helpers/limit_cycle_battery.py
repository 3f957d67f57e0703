"""Signals whose verdict is known because of how they were made: those that hunt, and those that do not.

Every number that could matter is drawn over decades: how long the record is, how large the motion, how far above the
noise band, how many cycles the record holds. The noise that is added has a third of the band at most for its standard
deviation, as in a study.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from workbench.metrics.limit_cycle import LimitCycle, judge

SAMPLES = 16_000
"""Of each record."""

SUSTAINED, DYING, NONE = ("sustained",), ("decaying", "none"), ("none",)
SLOW = ("sustained", "too_short")


@dataclass(frozen=True)
class Made:
    """A signal, its noise band (m), the verdicts that are right, and where known its size (m) and period (s)."""

    kind: str
    time: np.ndarray
    error: np.ndarray
    band: float
    right: tuple[str, ...]
    amplitude: float | None = None
    period: float | None = None

    @property
    def hunts(self) -> bool:
        """Whether it never ends."""
        return "sustained" in self.right

    def verdict(self) -> LimitCycle:
        """What the judge says."""
        return judge(self.time, self.error, np.gradient(self.error, self.time), self.band)


class Draw:
    """One record: its length, the height of its motion, the band, and noise within it."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.duration = self.decades(3.0, 300.0)
        self.time = np.linspace(0.0, self.duration, SAMPLES)
        self.height = self.decades(1e-5, 1e-2)
        self.band = self.height / self.decades(2.5, 3e3)
        self.noise = self.band / 3.0 * rng.uniform(0.0, 1.0) * rng.standard_normal(SAMPLES)

    def decades(self, low: float, high: float) -> float:
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def between(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def wave(self, cycles: float, phase: float | None = None) -> np.ndarray:
        """A sine of height 1."""
        start = self.between(0.0, 2.0 * np.pi) if phase is None else phase
        return np.sin(2.0 * np.pi * cycles * self.time / self.duration + start)

    def slips(self, cycles: float, jitter: float, uneven: float, share: float = 0.5) -> np.ndarray:
        """Which half wave each sample is in: their lengths scatter by `jitter`; `share` is that of the upper ones."""
        count = int(4 * cycles) + 20
        lengths = np.where(np.arange(count) % 2, share, 1.0 - share) * self.duration / cycles
        lengths = lengths * np.clip(1.0 + jitter * self.rng.standard_normal(count), 0.2, 3.0)
        ends = np.cumsum(lengths) - self.between(0.0, float(lengths[0]))
        self.ends, self.heights = ends, 1.0 + uneven * self.rng.standard_normal(count)
        return np.searchsorted(ends, self.time)

    def step(self) -> np.ndarray:
        """The approach to a step of up to a hundred times the height, over within a tenth of the record."""
        return self.decades(3.0, 100.0) * np.exp(-self.time / (self.duration * self.between(0.002, 0.02)))

    def made(self, kind: str, shape: np.ndarray, right: tuple[str, ...], **known: float) -> Made:
        offset = self.between(-3.0, 3.0)
        return Made(kind, self.time, self.height * (shape + offset) + self.noise, self.band, right, **known)


# --- that hunt --------------------------------------------------------------------------------------------------


def sine(d: Draw) -> Made:
    cycles = d.decades(9.5, 300.0)
    drift = d.between(-3.0, 3.0) * d.time / d.duration
    known = {"amplitude": 2.0 * d.height, "period": d.duration / cycles}
    return d.made("sine", d.wave(cycles) + drift, SUSTAINED, **known)


def quantised_sine(d: Draw) -> Made:
    made = d.made("quantised sine", d.wave(d.decades(9.5, 200.0)), SUSTAINED)
    return Made(made.kind, made.time, made.band * np.rint(made.error / made.band), made.band, SUSTAINED)


def stick_slip(d: Draw) -> Made:
    cycles = d.decades(10.0, 100.0)
    index = d.slips(cycles, 0.05, 0.03)
    shape = (-1.0) ** index * d.heights[index]
    return d.made("stick-slip", shape, SUSTAINED, amplitude=2.0 * d.height, period=d.duration / cycles)


def sawtooth(d: Draw) -> Made:
    """Creeps one way and slips back."""
    cycles, start = d.decades(10.0, 200.0), d.between(0.0, 1.0)
    return d.made("sawtooth", 2.0 * np.mod(cycles * d.time / d.duration + start, 1.0) - 1.0, SUSTAINED)


def long_holds(d: Draw) -> Made:
    """Unequal holds, up to ten to one."""
    cycles = d.decades(2.5, 40.0)
    index = d.slips(cycles, 0.05, 0.05, d.between(0.09, 0.91))
    return d.made("long holds", (-1.0) ** index * d.heights[index], SUSTAINED if cycles > 11.0 else SLOW)


def two_tones(d: Draw) -> Made:
    cycles = d.decades(12.0, 60.0)
    second = d.between(0.2, 0.9) * d.wave(cycles * d.between(1.3, 7.0))
    return d.made("two tones", d.wave(cycles) + second, SUSTAINED)


def beats(d: Draw) -> Made:
    nodes = d.between(3.0, 12.0)
    carrier = nodes * d.between(5.0, 15.0)
    depth = d.between(0.3, 1.0)
    return d.made("beats", d.wave(carrier) + depth * d.wave(carrier + nodes), SUSTAINED)


def jittering(d: Draw) -> Made:
    """Periods that scatter by a fifth."""
    d.slips(d.decades(12.0, 100.0), 0.2, 0.0)
    phase = np.pi * np.interp(d.time, d.ends, np.arange(d.ends.size))
    return d.made("20 % jitter of the period", np.sin(phase), SUSTAINED)


def uneven(d: Draw) -> Made:
    """Heights that scatter by a fifth."""
    index = d.slips(d.decades(12.0, 100.0), 0.05, 0.2)
    return d.made("20 % jitter of the amplitude", (-1.0) ** index * d.heights[index], SUSTAINED)


def on_creep(d: Draw) -> Made:
    cycles = d.decades(16.0, 150.0)
    creep = d.decades(3.0, 100.0) * np.exp(-d.time / (d.duration * d.between(0.1, 0.5)))
    return d.made("small on a creep", d.wave(cycles) + creep, SUSTAINED, period=d.duration / cycles)


def on_drift(d: Draw) -> Made:
    cycles = d.decades(10.0, 100.0)
    drift = d.between(-1.5, 1.5) * 2.0 * np.pi * cycles * d.time / d.duration
    return d.made("small on a drift", d.wave(cycles) + drift, SUSTAINED, period=d.duration / cycles)


def slow(d: Draw) -> Made:
    return d.made("2 to 5 periods", d.wave(d.between(2.0, 5.0)), SLOW)


def slow_after_a_step(d: Draw) -> Made:
    return d.made("2 to 8 periods after a step", d.wave(d.between(2.0, 8.0)) + d.step(), SLOW)


def slow_stick_slip(d: Draw) -> Made:
    index = d.slips(d.between(2.0, 5.0), 0.1, 0.1)
    return d.made("slow stick-slip", (-1.0) ** index * d.heights[index] + d.step(), SLOW)


def growing(d: Draw) -> Made:
    rise = np.exp(-d.between(0.2, 4.0) * (1.0 - d.time / d.duration))
    return d.made("growing", rise * d.wave(d.decades(10.0, 100.0)), SLOW)


def settling_to_a_cycle(d: Draw) -> Made:
    """After a step the amplitude falls to that of the limit cycle."""
    excess = d.between(0.5, 10.0) * np.exp(-d.time / (d.duration * d.between(0.01, 0.08)))
    return d.made("falls to its limit cycle", (1.0 + excess) * d.wave(d.decades(12.0, 100.0)), SUSTAINED)


# --- that do not ------------------------------------------------------------------------------------------------


def decay(d: Draw) -> Made:
    envelope = np.exp(-d.decades(0.4, 12.0) * d.time / d.duration)
    return d.made("exponential decay", envelope * d.wave(d.decades(10.0, 200.0)), DYING)


def coulomb_decay(d: Draw) -> Made:
    envelope = np.clip(1.0 - d.time / (d.duration * d.decades(0.3, 8.0)), 0.0, None)
    return d.made("linear decay", envelope * d.wave(d.decades(10.0, 100.0)), DYING)


def ringing(d: Draw) -> Made:
    """After a step, gone within a fifth of the record."""
    envelope = d.decades(1.0, 30.0) * np.exp(-d.time / (d.duration * d.between(0.005, 0.03)))
    return d.made("ringing that dies", envelope * d.wave(d.decades(10.0, 200.0)), DYING)


def stops(d: Draw) -> Made:
    cycles = d.decades(20.0, 100.0)
    end = d.between(0.2, 0.85) * d.duration
    phase = 2.0 * np.pi * cycles * np.minimum(d.time, end) / d.duration
    return d.made("cycles that stop", np.sin(phase), DYING)


def white_noise(d: Draw) -> Made:
    return d.made("white noise", np.zeros(SAMPLES), NONE)


def coloured_noise(d: Draw) -> Made:
    keep = float(np.exp(-1.0 / d.decades(3.0, 300.0)))
    noise = lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], d.rng.standard_normal(SAMPLES))
    return d.made("coloured noise", noise * d.between(0.2, 1.0) * d.band / 3.0 / d.height - d.noise / d.height, NONE)


def toggling(d: Draw) -> Made:
    """The converter's last step, to and fro."""
    drift = d.between(0.5, 3.0) * np.sin(np.pi * d.time / d.duration * d.between(0.1, 0.5))
    steps = np.rint(drift + 0.3 * d.rng.standard_normal(SAMPLES))
    return Made("last bit toggles", d.time, 0.5 * d.band * (steps - drift), d.band, NONE)


def drifting(d: Draw) -> Made:
    return d.made("drift", d.between(-5.0, 5.0) * d.time / d.duration, NONE)


def settling(d: Draw) -> Made:
    return d.made("settles", d.decades(1.0, 30.0) * np.exp(-d.time / (d.duration * d.decades(0.01, 2.0))), NONE)


def overshooting(d: Draw) -> Made:
    slow_part = np.exp(-d.time / (d.duration * d.between(0.05, 0.4)))
    fast_part = np.exp(-d.time / (d.duration * d.between(0.005, 0.02)))
    return d.made("overshoots and creeps back", d.decades(3.0, 30.0) * (fast_part - 0.2 * slow_part), NONE)


def creeping(d: Draw) -> Made:
    """Coulomb friction: along a line, until it stops."""
    left = np.clip(1.0 - d.time / (d.duration * d.between(0.1, 1.5)), 0.0, None)
    return d.made("creeps and stops", d.decades(1.0, 30.0) * left, NONE)


def dead(d: Draw) -> Made:
    return Made("dead", d.time, np.full(SAMPLES, d.height * d.rng.integers(0, 2)), d.band, NONE)


HUNTING: dict[Callable[[Draw], Made], int] = {
    sine: 8, quantised_sine: 4, stick_slip: 6, sawtooth: 5, long_holds: 6, two_tones: 7, beats: 7, jittering: 6,
    uneven: 5, on_creep: 7, on_drift: 4, slow: 7, slow_after_a_step: 6, slow_stick_slip: 6, growing: 4,
    settling_to_a_cycle: 4,
}  # fmt: skip
"""How many of each kind."""

QUIET: dict[Callable[[Draw], Made], int] = {
    decay: 8, coulomb_decay: 6, ringing: 6, stops: 5, white_noise: 4, coloured_noise: 5, toggling: 4, drifting: 4,
    settling: 6, overshooting: 5, creeping: 4, dead: 3,
}  # fmt: skip


def battery(seed: int) -> list[Made]:
    """All of them, drawn anew for every seed."""
    rng = np.random.default_rng(seed)
    return [make(Draw(rng)) for make, count in (HUNTING | QUIET).items() for _ in range(count)]
