"""What so many draws say of all machines: shares and quantiles, each with the interval in which it is."""

import functools
import math
from collections.abc import Sequence

import numpy as np
from scipy.stats import binomtest, norm, quantile_test

SURE = 0.95
"""Of every interval."""

ROUNDING = 1e-12
"""Of a share: 0.07 times 100 draws is a little above 7 in floating point, and would count as the eighth."""

MOST_ALIKE = 1e-4
"""Shares that differ by less are not told apart by any number of draws that could be run."""


@functools.lru_cache(4096)
def share_interval(successes: int, trials: int, sure: float = SURE) -> tuple[float, float]:
    """Exact interval of a share: where it is with a probability of at least `sure`, whatever the share.

    low = B(a/2; k, n - k + 1), high = B(1 - a/2; k + 1, n - k), quantiles of the beta distribution with a = 1 - sure,
    k = successes, n = trials; 0 where k = 0, 1 where k = n.

    Source: Clopper and Pearson 1934 (Biometrika 26, 404).
    """
    low, high = binomtest(successes, trials).proportion_ci(sure, method="exact")
    return float(low), float(high)


def least_draws(share: float, sure: float = SURE) -> int:
    """The least number of draws that can show a share to be exceeded: all of them succeed, and the interval is above.

    Of n successes in n the lower end is (a/2)^(1/n), which is above the share from n = ln(a/2) / ln(share) on.
    """
    return math.floor(math.log(0.5 * (1.0 - sure)) / math.log(share)) + 1


def deciding_counts(share: float, draws: int, sure: float = SURE) -> tuple[int | None, int | None]:
    """Of so many draws the least successes that show a share to be exceeded, and the most that show it is not reached.

    None where no number of successes does.
    """
    ends = [share_interval(count, draws, sure) for count in range(draws + 1)]
    above = [count for count, (low, _) in enumerate(ends) if low > share]
    below = [count for count, (_, high) in enumerate(ends) if high < share]
    return min(above, default=None), max(below, default=None)


def settling_draws(observed: float, share: float, sure: float = SURE) -> int | None:
    """About how many draws tell an observed share from another: the interval then no longer holds it.

    None where the two differ by less than `MOST_ALIKE`. The normal approximation, n = z^2 p (1 - p) / d^2 with
    p the observed share and d the distance, begins the search; the exact interval ends it.
    """
    distance = abs(observed - share)
    if distance < MOST_ALIKE:
        return None
    z = float(norm.ppf(0.5 * (1.0 + sure)))
    draws = max(2, round(0.5 * z**2 * observed * (1.0 - observed) / distance**2))
    while _holds(observed, draws, share, sure):
        draws = math.ceil(1.05 * draws)
    return draws


def _holds(observed: float, draws: int, share: float, sure: float) -> bool:
    """Whether the interval of an observed share over so many draws holds another share."""
    low, high = share_interval(round(observed * draws), draws, sure)
    return low <= share <= high


def quantile(values: Sequence[float], share: float) -> float:
    """The smallest of `values` that at least this share of them do not exceed."""
    return float(np.quantile(values, share * (1.0 - ROUNDING), method="inverted_cdf"))


def quantile_interval(values: Sequence[float], share: float) -> tuple[float, float]:
    """Where the quantile of all machines is, with a probability of at least `SURE`, whatever their distribution.

    The number of draws below the true quantile is binomial: the ends are the draws of the ranks that it keeps between.
    The lower end is 0, the upper one infinite, where so few draws do not bound it.
    """
    low, high = quantile_test(values, p=share).confidence_interval(SURE)
    return 0.0 if math.isnan(low) else float(low), math.inf if math.isnan(high) else float(high)


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
