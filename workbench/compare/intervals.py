"""What paired plant samples say of a ratio and of a difference: intervals, and whether one candidate beats another.

Both candidates meet the same plant samples, so what these share cancels. Two errors a and b count as different if they
differ by more than 5 % of the larger and `negligible` together; this one comparison is made on

    log((b + c) / (a + c)),    c = negligible / 5 %,

which is the logarithm of the ratio where errors are large, on which errors that vary by factors from plant to plant
differ nearly normally, and their difference in metres where they are small. Its interval is Student's for paired
observations,

    mean +- t_{1 - e/2, n-1} s / sqrt(n),    e = (1 - probability) / comparisons,

with the share of error divided by the number of comparisons that a verdict rests on (Bonferroni), so that all of them
hold together. "Beats": the whole interval lies beyond 5 %; "level": it lies within, the test of equivalence by two
one-sided tests. The ratio and the difference that are told have intervals of the same kind.

Source: Student 1908 (Biometrika 6, 1); Dunn 1961 (J. Am. Stat. Assoc. 56, 52); Schuirmann 1987 (J. Pharmacokinet.
Biopharm. 15, 657).
"""

import functools
import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

CLOSE = 0.05
"""Errors and powers that differ by less than this share of the larger count as the same."""

LEAST = 1e-7
"""The least error (m) that is told; ratios take smaller ones for it."""

MOST_PROPOSED = 1000
"""More plant samples than these are not proposed."""

Word = Literal["beats", "loses to", "is level with", "cannot be told from"]

OPPOSITE: dict[Word, Word] = {"beats": "loses to", "loses to": "beats"}


@dataclass(frozen=True)
class Interval:
    """Where a mean is: that of the samples, and between what it lies. Without spread known, both ends are the mean."""

    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class Relation:
    """One candidate against another on common plant samples.

    `ratio`: the other's error over this one's (geometric mean); `difference`: the other's error less this one's (m);
    `needed`: about how many samples would tell what these do not, None where `MOST_PROPOSED` would not.
    """

    word: Word
    ratio: Interval
    difference: Interval
    samples: int
    needed: int | None = None

    @property
    def reversed(self) -> "Relation":
        """The same, seen from the other candidate."""
        ratio, difference = self.ratio, self.difference
        return Relation(
            OPPOSITE.get(self.word, self.word),
            Interval(1.0 / ratio.mean, 1.0 / ratio.high, 1.0 / ratio.low),
            Interval(-difference.mean, -difference.high, -difference.low),
            self.samples,
            self.needed,
        )


def interval_of_mean(values: NDArray[np.float64], probability: float, comparisons: int = 1) -> Interval:
    """Student's interval of the mean of `values`, one of so many that shall hold together."""
    mean = float(np.mean(values))
    spread = float(np.std(values, ddof=1)) if values.size > 1 else 0.0
    return _student(mean, spread, values.size, probability, comparisons)


def _student(mean: float, spread: float, count: int, probability: float, comparisons: int) -> Interval:
    if count < 2:
        return Interval(mean, mean, mean)
    reach = _quantile(0.5 * (1.0 - probability) / comparisons, count - 1) * spread / math.sqrt(count)
    return Interval(mean, mean - reach, mean + reach)


@functools.cache
def _quantile(above: float, freedom: int) -> float:
    """What Student's t exceeds with the probability `above`."""
    return float(student.isf(above, freedom))


def paired(
    first: NDArray[np.float64],
    second: NDArray[np.float64],
    *,
    negligible: float,
    solver_error: float,
    probability: float,
    comparisons: int,
) -> Relation:
    """How the errors `first` compare with the errors `second` of the same plant samples.

    Args:
        first, second: errors (m), a value a sample, in the same order.
        negligible: difference (m) that does not count.
        solver_error: what the integration may add to the difference (m).
        probability: that all `comparisons` intervals hold together.
        comparisons: how many are made for the same verdict.
    """
    floor = max(negligible, solver_error) / CLOSE
    counted = np.log((second + floor) / (first + floor))
    logs = np.log(np.maximum(second, LEAST) / np.maximum(first, LEAST))
    mean, spread = float(np.mean(counted)), float(np.std(counted, ddof=1)) if counted.size > 1 else 0.0

    def word_with(samples: int) -> Word:
        return _word(_student(mean, spread, samples, probability, comparisons))

    word, needed = word_with(counted.size), None
    if word == "cannot be told from":
        needed = next((samples for samples in _more_than(counted.size) if word_with(samples) != word), None)
    log = interval_of_mean(logs, probability, comparisons)
    ratio = Interval(*(math.exp(value) for value in (log.mean, log.low, log.high)))
    difference = interval_of_mean(second - first, probability, comparisons)
    return Relation(word, ratio, difference, counted.size, needed)


def _word(counted: Interval) -> Word:
    """What the interval of the logarithm says."""
    share = -math.log(1.0 - CLOSE)
    if counted.low > share:
        return "beats"
    if counted.high < -share:
        return "loses to"
    if -share <= counted.low and counted.high <= share:
        return "is level with"
    return "cannot be told from"


def _more_than(samples: int) -> list[int]:
    """Numbers of plant samples that may be proposed: two digits, each about 5 % above the one before."""
    numbers, value = [], float(samples)
    while value < MOST_PROPOSED:
        value = max(value + 1.0, 1.05 * value)
        digits = 10 ** max(0, math.floor(math.log10(value)) - 1)
        numbers.append(math.ceil(value / digits) * digits)
    return sorted(number for number in set(numbers) if number <= MOST_PROPOSED)
