"""Descent over hollows: a landscape whose slope is known, with hollows in it that hold a search by slopes."""

import numpy as np

from workbench.fitting.least_squares import Search, least_squares, one_by_one
from workbench.fitting.wide_steps import descend

TRUE = np.array([0.4, -0.3])
WIDE = np.full(2, np.inf)
ROWS = np.random.default_rng(5).standard_normal((40, 2))


def rugged(x: np.ndarray) -> np.ndarray:
    """Least, near 0, at `TRUE`; hollows 0.02 apart as steep as the way down."""
    return np.asarray(ROWS @ (x - TRUE) + 0.02 * np.sin(300.0 * (ROWS @ x)) - 0.02 * np.sin(300.0 * (ROWS @ TRUE)))


def test_a_search_by_slopes_ends_in_a_hollow_and_wide_steps_do_not() -> None:
    start = np.array([2.0, 1.5])
    held = least_squares(one_by_one(rugged), start, -WIDE, WIDE, Search())
    assert np.max(np.abs(held.x - TRUE)) > 0.2
    assert np.max(np.abs(descend(one_by_one(rugged), start, -WIDE, WIDE) - TRUE)) < 0.02


def test_it_stays_within_bounds_and_where_nothing_is_less() -> None:
    low, high = np.array([1.0, -1.0]), np.array([3.0, 3.0])
    assert descend(one_by_one(rugged), np.array([2.0, 1.5]), low, high)[0] == 1.0
    np.testing.assert_array_equal(descend(one_by_one(rugged), TRUE, -WIDE, WIDE), TRUE)
    assert descend(one_by_one(lambda x: np.ones(3)), np.zeros(0), np.zeros(0), np.zeros(0)).size == 0


def test_units_do_not_count() -> None:
    """Of an unknown that hardly counts, and of one that does not at all."""
    scales = np.array([1e-6, 1e3])
    found = descend(one_by_one(lambda x: scales[0] * rugged(x)), np.array([2.0, 1.5]), -WIDE, WIDE)
    assert np.max(np.abs(found - TRUE)) < 0.02
    blind = descend(one_by_one(lambda x: rugged(np.array([x[0], TRUE[1]]))), np.array([2.0, 0.0]), -WIDE, WIDE)
    assert abs(blind[0] - TRUE[0]) < 0.02
