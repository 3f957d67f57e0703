"""What so many draws say of all machines: shares and quantiles, each with the interval in which it is."""

import math
from collections.abc import Sequence

from scipy.stats import binom, binomtest

SURE = 0.95
"""Of every interval."""


def share_interval(successes: int, trials: int) -> tuple[float, float]:
    """Wilson's score interval of a share: where it is with a probability of about `SURE`.

    (p + z^2/2n +- z sqrt(p (1 - p)/n + z^2/4n^2)) / (1 + z^2/n) with p = successes/n, n = trials and z = 1.96.

    Source: Wilson 1927; recommended for small n by Brown, Cai, DasGupta 2001 (Statistical Science 16, 101).
    """
    found = binomtest(successes, trials).proportion_ci(SURE, method="wilson")
    return float(found.low), float(found.high)


def quantile(values: Sequence[float], share: float) -> float:
    """The smallest of `values` that at least this share of them do not exceed."""
    return sorted(values)[max(math.ceil(share * len(values) - 1e-9), 1) - 1]


def quantile_interval(values: Sequence[float], share: float) -> tuple[float, float]:
    """Where the quantile of all machines is, with a probability of at least `SURE`, whatever their distribution.

    The number of draws below the true quantile is binomial: the ends are the draws of the ranks that it keeps between.
    The lower end is 0, the upper one infinite, where so few draws do not bound it.
    """
    ordered, count = sorted(values), len(values)
    low = int(binom.ppf(0.5 * (1.0 - SURE), count, share))
    high = int(binom.ppf(0.5 * (1.0 + SURE), count, share)) + 1
    return ordered[low - 1] if low >= 1 else 0.0, ordered[high - 1] if high <= count else math.inf


def sign_test(first: Sequence[bool], second: Sequence[bool]) -> tuple[int, int, float]:
    """On how many draws only the first succeeds, on how many only the second, and the probability of such a difference.

    The last is that of one at least as large where both are as good: McNemar's exact test, two-sided; draws that do not
    tell the two apart do not count. 1 where there are no others.

    Source: McNemar 1947 (Psychometrika 12, 153).
    """
    only_first = sum(one and not other for one, other in zip(first, second, strict=True))
    only_second = sum(other and not one for one, other in zip(first, second, strict=True))
    differing = only_first + only_second
    return only_first, only_second, float(binomtest(only_first, differing).pvalue) if differing else 1.0
