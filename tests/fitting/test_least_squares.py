"""Least squares within bounds: minima that are known, or that another solver or a search of all corners finds."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.optimize import least_squares as by_scipy

import workbench.fitting.least_squares as least_squares_module
from workbench.fitting.least_squares import Search, Solution, bounded_minimum, differences, least_squares, one_by_one

EXACT = Search(flat=1e-14, step=1e-6)
TIMES = np.linspace(0.0, 4.0, 60)
FREE = np.full(2, np.inf)

Residual = Callable[[np.ndarray], np.ndarray]


def rosenbrock(x: np.ndarray) -> np.ndarray:
    """Least, 0, at (1, 1); for a given first unknown at its square."""
    return np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])


def decay(x: np.ndarray) -> np.ndarray:
    """Noise about 3 exp(-0.7 t) + 0.5, by its level, rate and rest."""
    noise = 0.05 * np.random.default_rng(3).standard_normal(TIMES.size)
    return np.asarray(x[0] * np.exp(-x[1] * TIMES) + x[2] - (3.0 * np.exp(-0.7 * TIMES) + 0.5 + noise))


def counted(residual: Residual) -> tuple[Residual, list[int]]:
    calls = [0]

    def called(x: np.ndarray) -> np.ndarray:
        calls[0] += 1
        return residual(x)

    return called, calls


def solved(residual: Residual, start: list[float], low: float = -np.inf, search: Search = EXACT) -> Solution:
    size = len(start)
    return least_squares(one_by_one(residual), np.array(start), np.full(size, low), np.full(size, np.inf), search)


def test_a_valley_is_followed_to_its_end() -> None:
    solution = solved(rosenbrock, [-1.2, 1.0])
    assert solution.x == pytest.approx([1.0, 1.0], abs=1e-6)
    assert solution.residual @ solution.residual < 1e-12
    assert np.all(solution.free)


def test_along_a_valley_that_curves_steps_are_bent(monkeypatch: pytest.MonkeyPatch) -> None:
    """A canyon a thousand times as narrow as it is long, where straight steps are short ones, and noise."""

    def canyon(x: np.ndarray) -> np.ndarray:
        return np.array([1000.0 * (x[1] - x[0] ** 2), 1.0 - x[0], *np.ones(5_000)])

    calls = []
    for bends in (0, least_squares_module.BENDS):
        monkeypatch.setattr(least_squares_module, "BENDS", bends)
        residual, called = counted(canyon)
        solution = solved(residual, [-1.2, 1.0], search=replace(EXACT, most_steps=1000, flat=1e-18))
        assert solution.x == pytest.approx([1.0, 1.0], abs=1e-6)
        calls.append(called[0])
    assert calls[1] < 0.7 * calls[0]


def test_near_noise_a_search_goes_on_as_long_as_steps_are_worth_it() -> None:
    """However many rows there are, of which a share is more than an unknown's deviation is worth."""
    draw = np.random.default_rng(5)
    times, noise = np.linspace(0.0, 1.0, 20_000), draw.standard_normal(20_000)

    def slow(x: np.ndarray) -> np.ndarray:
        """Two exponentials that hardly differ."""
        return np.asarray(20.0 * (np.exp(-x[0] * times) + np.exp(-x[1] * times) - 2.0 * np.exp(-times)) + noise)

    rough = solved(slow, [0.5, 1.6], search=Search(flat=1e-2))
    exact = solved(slow, [0.5, 1.6], search=EXACT)
    assert rough.residual @ rough.residual - exact.residual @ exact.residual < 1.0


@pytest.mark.parametrize("learns", [False, True])
def test_a_fit_ends_where_another_solver_ends(learns: bool) -> None:
    solution = solved(decay, [1.0, 3.0, 0.0], search=replace(EXACT, learns=learns))
    assert solution.x == pytest.approx(by_scipy(decay, [1.0, 3.0, 0.0], xtol=1e-14, ftol=1e-14).x, rel=1e-5)


def test_a_jacobian_that_is_learnt_costs_fewer_residuals() -> None:
    """Of as many unknowns as a plant has, of which each difference quotient is a simulation."""
    draw = np.random.default_rng(7)
    rows, truth = draw.standard_normal((200, 12)), draw.uniform(-0.3, 0.3, 12)

    def bent(x: np.ndarray) -> np.ndarray:
        return np.tanh(rows @ x) - np.tanh(rows @ truth) + 0.01 * np.sin(np.arange(200))

    costs, ends = [], []
    for learns in (False, True):
        residual, calls = counted(bent)
        solution = solved(residual, [0.0] * 12, search=Search(flat=1e-7, learns=learns))
        costs.append(calls[0])
        ends.append(solution.residual @ solution.residual)
    assert ends[1] == pytest.approx(ends[0], rel=1e-5)
    assert costs[1] < 0.7 * costs[0]


def test_a_start_is_asked_for_beside_its_first_difference_quotients() -> None:
    asked = list[int]()

    def together(places: Sequence[np.ndarray]) -> list[np.ndarray]:
        asked.append(len(places))
        return list(map(decay, places))

    start, wide = np.array([2.0, 1.0, 0.0]), np.full(3, np.inf)
    found = least_squares(together, start, -wide, wide, EXACT)
    assert asked[0] == 1 + start.size
    np.testing.assert_array_equal(found.x, least_squares(one_by_one(decay), start, -wide, wide, EXACT).x)


def test_an_unknown_at_a_bound_is_not_free_and_the_others_are_best_beside_it() -> None:
    high = np.array([0.5, np.inf])
    solution = least_squares(one_by_one(rosenbrock), np.array([-1.2, 1.0]), -FREE, high, EXACT)
    assert solution.x == pytest.approx([0.5, 0.25], abs=1e-6)
    assert solution.free.tolist() == [False, True]


def test_an_unknown_that_starts_at_a_bound_leaves_it_where_that_is_better() -> None:
    solution = least_squares(one_by_one(rosenbrock), np.array([0.0, 0.0]), np.zeros(2), np.full(2, 2.0), EXACT)
    assert solution.x == pytest.approx([1.0, 1.0], abs=1e-6)
    assert np.all(solution.free)


@pytest.mark.parametrize("seed", range(20))
def test_within_bounds_a_line_is_fitted_as_by_another_solver(seed: int) -> None:
    draw = np.random.default_rng(seed)
    columns, target = draw.standard_normal((30, 4)) + draw.standard_normal((30, 1)), draw.standard_normal(30)
    low, high = -draw.uniform(0.0, 0.1, 4), draw.uniform(0.0, 0.1, 4)

    def residual(x: np.ndarray) -> np.ndarray:
        return columns @ x - target

    solution = least_squares(one_by_one(residual), np.zeros(4), low, high, EXACT)
    other = by_scipy(residual, np.zeros(4), bounds=(low, high), xtol=1e-14, ftol=1e-14, gtol=1e-14)
    assert solution.residual @ solution.residual == pytest.approx(2.0 * other.cost, rel=1e-6)
    assert np.all((low <= solution.x) & (solution.x <= high))


def test_an_unknown_that_changes_nothing_stays_where_it_is() -> None:
    solution = solved(lambda x: np.array([x[0] - 2.0, 1.0]), [0.0, 5.0])
    assert solution.x == pytest.approx([2.0, 5.0])


def test_units_do_not_decide() -> None:
    """The same fit in units of a millionth and of a thousandth."""
    units = np.array([1e-6, 1e-3, 1.0])
    start = np.array([1.0, 3.0, 0.0])
    low, high = np.full(3, -np.inf), np.full(3, np.inf)
    other = least_squares(one_by_one(lambda x: decay(units * x)), start / units, low, high, EXACT)
    assert units * other.x == pytest.approx(solved(decay, [1.0, 3.0, 0.0]).x, rel=1e-5)


def test_without_unknowns_the_residual_is_all_there_is() -> None:
    solution = solved(lambda x: np.arange(3.0), [])
    assert solution.residual.tolist() == [0.0, 1.0, 2.0]
    assert solution.jacobian.shape == (3, 0)


# --- a quadratic within bounds ---


def least_of_all_corners(
    curvature: np.ndarray, slope: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[float, np.ndarray]:
    """The least value of a quadratic, and where it is: each unknown at either bound or free, whatever is possible."""
    best, place = np.inf, np.zeros(slope.size)
    for ends in product((-1, 0, 1), repeat=slope.size):
        at = np.array(ends)
        x, free = np.where(at < 0, low, np.where(at > 0, high, 0.0)), at == 0
        x[free] = np.linalg.solve(curvature[np.ix_(free, free)], -(slope[free] + curvature[free][:, ~free] @ x[~free]))
        if np.all((low - 1e-12 <= x) & (x <= high + 1e-12)) and value(curvature, slope, x) < best:
            best, place = value(curvature, slope, x), x
    return best, place


def value(curvature: np.ndarray, slope: np.ndarray, x: np.ndarray) -> float:
    return float(slope @ x + 0.5 * x @ curvature @ x)


def quadratic(seed: int, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Curvature, slope and bounds, of unknowns of which records tell each well."""
    draw = np.random.default_rng(seed)
    rows = draw.standard_normal((40, size))
    return rows.T @ rows, rows.T @ draw.standard_normal(40), -draw.uniform(0.0, 0.1, size), draw.uniform(0.0, 0.1, size)


@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_a_quadratic_within_bounds_is_least_where_a_search_of_all_corners_says(size: int) -> None:
    for seed in range(25):
        curvature, slope, low, high = quadratic(seed, size)
        least, place = least_of_all_corners(curvature, slope, low, high)
        x = bounded_minimum(curvature, slope, low, high)
        assert value(curvature, slope, x) == pytest.approx(least, rel=1e-6, abs=1e-12), seed
        assert x == pytest.approx(place, abs=1e-6), seed


def test_without_bounds_a_quadratic_is_solved() -> None:
    curvature, slope, _, _ = quadratic(1, 4)
    free = np.full(4, np.inf)
    assert bounded_minimum(curvature, slope, -free, free) == pytest.approx(np.linalg.solve(curvature, -slope))


def test_two_unknowns_that_cannot_be_told_apart_share_what_they_explain() -> None:
    x = bounded_minimum(np.ones((2, 2)), -np.ones(2), np.full(2, -np.inf), np.full(2, np.inf))
    assert x == pytest.approx([0.5, 0.5], rel=1e-3)


def test_an_unknown_that_is_known_to_a_millionth_is_found_as_well_as_it_is_known() -> None:
    """Half a millionth beside the least the residual bends: quotients over the longest step would be those beyond."""
    draw = np.random.default_rng(4)
    noise, slope = draw.standard_normal(400), draw.standard_normal(400)

    def bent(x: np.ndarray) -> np.ndarray:
        off = (x[0] - 0.3) / 1e-6
        return np.asarray(noise + slope * off + 3.0 * np.abs(slope) * max(off - 0.5, 0.0))

    found = least_squares(one_by_one(bent), np.array([0.2999]), -FREE[:1], FREE[:1], Search(flat=1e-9, step=1e-4))
    line = float(-(noise @ slope) / (slope @ slope))
    assert abs(line) < 0.5, "the least is where nothing bends"
    assert (found.x[0] - 0.3) / 1e-6 == pytest.approx(line, abs=1e-3)


@pytest.mark.parametrize("known", [1e-9, 1e-7, 1e-3])
def test_a_first_difference_quotient_is_felt_and_no_more(known: float) -> None:
    """Of an unknown that residuals show to `known`, and that puts jumps into them where it is moved by far."""
    times, draw = np.linspace(0.0, 1.0, 400), np.random.default_rng(1)
    noise = draw.standard_normal(times.size)
    slope = times / known / np.linalg.norm(times)

    def jumping(x: np.ndarray) -> np.ndarray:
        return np.asarray(noise + slope * x[0] + 1e3 * np.clip(np.abs(x[0]) - 100.0 * known, 0.0, 1.0) / known)

    found = solved(jumping, [0.0], search=Search(most_steps=1))
    assert found.jacobian[:, 0] == pytest.approx(slope, abs=1e-6 * np.max(slope))


def test_a_difference_quotient_goes_so_far_that_it_is_felt_where_it_may() -> None:
    """What hardly moves a residual is lost in a solver's error at a ten-thousandth of an unknown."""
    times = np.linspace(0.0, 1.0, 400)
    slope = 0.05 * times
    noise = np.random.default_rng(2).standard_normal(times.size)

    def erring(x: np.ndarray) -> np.ndarray:
        return np.asarray(noise + slope * x[0] + 1e-3 * np.sin(1e6 * (times + x[0])))

    start, bound = np.zeros(1), np.full(1, np.inf)
    off = []
    for longest in (0.0, 100.0):
        found = least_squares(one_by_one(erring), start, -bound, bound, Search(most_steps=1), longest)
        off.append(float(np.linalg.norm(found.jacobian[:, 0] - slope) / np.linalg.norm(slope)))
    assert off[0] > 1.0
    assert off[1] < 0.01


def test_a_difference_quotient_of_what_changes_nothing_goes_as_far_as_it_may() -> None:
    """However much is left: nothing overflows aloud."""
    steps = differences(np.zeros(1), np.full(1, np.inf), 1e-3, np.zeros((10, 1)), 1e30)
    assert steps.tolist() == [1e-3]
