"""Intervals of paired draws: they hold as often as they say, and the words keep to them."""

import math

import numpy as np
import pytest
from scipy.stats import ttest_rel

from workbench.compare.intervals import CLOSE, Relation, interval_of_mean, paired

NEGLIGIBLE = 1e-6


def related(first: np.ndarray, second: np.ndarray, comparisons: int = 1, negligible: float = NEGLIGIBLE) -> Relation:
    return paired(first, second, negligible=negligible, solver_error=0.0, probability=0.95, comparisons=comparisons)


def samples(random: np.random.Generator, count: int, ratio: float, own: float) -> tuple[np.ndarray, np.ndarray]:
    """Errors of two candidates on `count` plant samples: what these share varies by 60 %, their own part by `own`."""
    shared = 1e-4 * np.exp(0.6 * random.standard_normal(count))
    first, second = (np.exp(own * random.standard_normal(count)) for _ in range(2))
    return shared * first, ratio * shared * second


def test_the_interval_is_that_of_the_paired_t_test() -> None:
    first, second = samples(np.random.default_rng(1), 12, 1.4, 0.2)
    expected = ttest_rel(np.log(second), np.log(first)).confidence_interval(0.95)
    ratio = related(first, second).ratio
    assert (math.log(ratio.low), math.log(ratio.high)) == pytest.approx((expected.low, expected.high), rel=1e-12)
    wider = ttest_rel(np.log(second), np.log(first)).confidence_interval(1.0 - 0.05 / 6)
    assert math.log(related(first, second, comparisons=6).ratio.high) == pytest.approx(wider.high, rel=1e-12)


@pytest.mark.parametrize("draws", [5, 10, 20])
def test_intervals_hold_the_truth_as_often_as_they_say(draws: int) -> None:
    """2000 repetitions: a standard error of 0.5 %. Errors are skewed, so the differences in mm hold a little less."""
    random, true_difference = np.random.default_rng(draws), 1e-4 * 0.3 * math.exp(0.5 * (0.6**2 + 0.2**2))
    ratio = difference = 0
    for _ in range(2000):
        relation = related(*samples(random, draws, 1.3, 0.2))
        ratio += relation.ratio.low <= 1.3 <= relation.ratio.high
        difference += relation.difference.low <= true_difference <= relation.difference.high
    assert 0.935 <= ratio / 2000 <= 0.965
    assert 0.90 <= difference / 2000 <= 0.97


def test_all_intervals_of_a_cell_hold_together() -> None:
    """Four candidates, six pairs: with six comparisons the family errs in at most 5 %, with one in more."""
    random = np.random.default_rng(7)
    misses = {1: 0, 6: 0}
    for _ in range(600):
        shared = np.exp(0.5 * random.standard_normal(10))
        errors = [1e-4 * shared * np.exp(0.15 * random.standard_normal(10)) for _ in range(4)]
        for comparisons in misses:
            pairs = [(i, j) for i in range(4) for j in range(i)]
            ratios = [related(errors[i], errors[j], comparisons).ratio for i, j in pairs]
            misses[comparisons] += any(not ratio.low <= 1.0 <= ratio.high for ratio in ratios)
    assert misses[6] / 600 <= 0.05
    assert misses[1] / 600 > 0.1


def test_at_the_edge_of_what_counts_beats_is_rare_and_level_too() -> None:
    """Exactly 5 % apart, neither "beats" nor "level" is right more often than their interval errs."""
    random = np.random.default_rng(3)
    words = [related(*samples(random, 10, 1.0 / (1.0 - CLOSE), 0.05), negligible=1e-10).word for _ in range(2000)]
    assert words.count("beats") / 2000 <= 0.035
    assert words.count("is level with") / 2000 <= 0.035
    assert words.count("loses to") == 0


def test_the_words() -> None:
    noise = 1.0 + 0.01 * np.sin(np.arange(10.0))
    errors = 1e-4 * np.linspace(1.0, 2.0, 10)
    assert related(errors, 2.0 * errors * noise).word == "beats"
    assert related(2.0 * errors * noise, errors).word == "loses to"
    assert related(errors, 1.02 * errors * noise).word == "is level with"
    assert related(errors, errors * np.exp(0.5 * np.cos(3.0 * np.arange(10.0)))).word == "cannot be told from"
    assert related(errors, 2.0 * errors * noise, negligible=1e-3).word == "is level with", (
        "within what may be neglected"
    )
    assert related(errors, errors + 1.5e-5, negligible=0.4e-5).word == "beats", "5 % and 0.4e-5 m are less together"
    assert related(errors, errors + 1.5e-5, negligible=1.0e-5).word == "is level with", "5 % and 1e-5 m are more"
    assert related(errors * 1e-6, errors * 1e-4, negligible=1e-6).word == "is level with"
    assert related(errors, 2.0 * errors).reversed.word == "loses to"
    assert related(errors, 2.0 * errors).reversed.ratio.mean == pytest.approx(0.5)


def test_the_old_example_is_no_level() -> None:
    """0.0138 mm against 0.00081 mm: level where 0.013 mm may be neglected, and never "no better" where less may."""
    small, large = np.full(10, 0.00081e-3), np.full(10, 0.0138e-3)
    assert related(small, large, negligible=0.013e-3).word == "is level with"
    assert related(small, large, negligible=0.001e-3).word == "beats"
    assert related(large, small, negligible=0.001e-3).word == "loses to"


def test_the_draws_that_are_said_to_be_needed_do_tell() -> None:
    random = np.random.default_rng(5)
    relation = related(*samples(random, 6, 1.8, 0.5))
    assert relation.word == "cannot be told from"
    assert relation.needed is not None
    assert 6 < relation.needed < 100
    spread = (
        math.log(relation.ratio.high / relation.ratio.mean) * math.sqrt(6) / 2.571 / math.sqrt(2)
    )  # t(0.975, 5) = 2.571
    told = [related(*samples(random, relation.needed, relation.ratio.mean, spread)).word for _ in range(200)]
    assert told.count("beats") > 60, "about every second time"
    fewer = [related(*samples(random, 6, relation.ratio.mean, spread)).word for _ in range(200)]
    assert fewer.count("beats") < told.count("beats")
    edge = related(*samples(random, 5, 1.0 / (1.0 - CLOSE), 0.5))
    assert edge.needed is None or edge.needed > 50


def test_one_draw_has_no_interval() -> None:
    only = interval_of_mean(np.array([3.0]), 0.95)
    assert (only.mean, only.low, only.high) == (3.0, 3.0, 3.0)
    assert related(np.array([1e-4]), np.array([2e-4])).word == "beats"
