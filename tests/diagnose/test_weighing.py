"""What a residual weighs: noise of any colour comes out white, what says nothing does not count."""

from collections.abc import Mapping

import numpy as np
import pytest
from made_up_balances import made_balance, made_motion
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from workbench.diagnose.residuals.fit import fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.weighing import Weighing, by_scatter, plain, weighing_of, without

ROWS = 4000


def coloured(numbers: list[float], deviation: float, seed: int, size: int = ROWS) -> np.ndarray:
    """Noise e_t + a_1 e_{t-1} + ... of an autoregression 1, -a_1, ..; `deviation` is that of what drives it."""
    drive = deviation * np.random.default_rng(seed).standard_normal(size + 500)
    return np.asarray(lfilter([1.0], numbers, drive)[500:])


def correlation(values: np.ndarray, lag: int) -> float:
    return float(values[lag:] @ values[:-lag] / (values @ values))


@pytest.mark.parametrize(
    "numbers", [[1.0], [1.0, -0.9], [1.0, 0.6], [1.0, -1.6, 0.9]], ids=["white", "slow", "fast", "ringing"]
)
def test_coloured_noise_is_whitened_to_a_deviation_of_1(numbers: list[float]) -> None:
    residual = coloured(numbers, 0.3, 1)
    series = [[slice(0, ROWS)]]
    white = weighing_of(series, residual)(residual)
    known = white[white != 0.0]
    assert known.size == ROWS
    assert np.std(known) == pytest.approx(1.0, abs=0.02)
    for lag in range(1, 6):
        assert abs(correlation(known, lag)) < 3.0 / np.sqrt(ROWS), lag


def test_every_kind_of_residual_has_a_noise_of_its_own_alike_in_all_records() -> None:
    kinds = [coloured([1.0, -0.9], 5.0, 1), coloured([1.0], 0.1, 2)]
    others = [coloured([1.0, -0.9], 5.0, 3), coloured([1.0], 0.1, 4)]
    residual = np.concatenate([*kinds, *others])
    places = [slice(i * ROWS, (i + 1) * ROWS) for i in range(4)]
    weighing = weighing_of([places[:2], places[2:]], residual)
    white = weighing(residual)
    for place in places:
        assert np.std(white[place]) == pytest.approx(1.0, abs=0.05)
    assert weighing.filters[0].numbers[1] / weighing.filters[0].numbers[0] == pytest.approx(-0.9, abs=0.03)
    assert len(weighing.filters) == 2


def test_what_is_exactly_0_says_nothing_nor_does_what_remembers_it() -> None:
    residual = coloured([1.0, -0.9], 1.0, 1)
    residual[1000:1200] = 0.0
    weighing = weighing_of([[slice(0, ROWS)]], residual)
    order = weighing.filters[0].numbers.size - 1
    assert order >= 1
    assert not np.any(weighing.counts[1000 : 1200 + order])
    assert np.all(weighing.counts[1200 + order :])
    assert np.all(weighing.counts[:1000])
    moved = weighing(residual + 1.0)
    assert not np.any(moved[1000 : 1200 + order]), "a step there must not count either"


def test_the_first_of_a_series_weigh_by_their_covariance() -> None:
    residual = coloured([1.0, -1.6, 0.9], 1.0, 1)
    white = weighing_of([[slice(0, ROWS)]], residual).filters[0]
    size = white.head.shape[0]
    lags = [float(residual[lag:] @ residual[: ROWS - lag]) / ROWS for lag in range(size)]
    assert size >= 2
    assert white.head @ toeplitz(lags) @ white.head.T == pytest.approx(np.eye(size), abs=0.03)


def test_what_a_series_begins_with_counts() -> None:
    residual = coloured([1.0, -0.9], 1.0, 1)
    weighing = weighing_of([[slice(0, ROWS)]], residual)
    begun = residual.copy()
    begun[0] += 30.0
    assert np.sum(weighing(begun) ** 2) > np.sum(weighing(residual) ** 2) + 100.0


def test_columns_weigh_as_residuals_do() -> None:
    residual = coloured([1.0, -0.5], 1.0, 1)
    weighing = weighing_of([[slice(0, ROWS)]], residual)
    columns = np.random.default_rng(2).standard_normal((ROWS, 3))
    weighed = weighing(columns)
    for i in range(3):
        assert weighed[:, i] == pytest.approx(weighing(columns[:, i]))
    assert weighing.times(2.0)(residual) == pytest.approx(2.0 * weighing(residual))


def directions() -> tuple[np.ndarray, list[np.ndarray]]:
    """A decay from the start of each half, of which the second also has one that is all 0."""
    time = np.arange(ROWS) / 300.0
    half = ROWS // 2
    first, second = np.exp(-time), np.exp(-time)
    first[half:] = 0.0
    second[half:], second[:half] = np.exp(-time[:half]), 0.0
    return np.column_stack([first + second, np.where(np.arange(ROWS) < half, time, 0.0)]), [
        np.arange(half),
        np.arange(half, ROWS),
    ]


@pytest.mark.parametrize("colour", [[1.0], [1.0, -0.8]])
def test_directions_are_projected_off_in_each_group_alone(colour: list[float]) -> None:
    residual = coloured(colour, 1.0, 1)
    columns, groups = directions()
    bare = weighing_of([[slice(0, ROWS)]], residual)
    weighing = bare.without(columns, groups)
    for rows, factor in zip(groups, (3.0, -50.0), strict=True):
        moved = np.zeros(ROWS)
        moved[rows] = factor * columns[rows, 0]
        gone = weighing(moved)
        # a filter carries the end of one group a little way into the next
        assert np.linalg.norm(gone[rows]) < 1e-8 * np.linalg.norm(bare(moved)[rows])
    weighed = weighing(residual)
    for rows in groups:
        block = bare(columns)[rows]
        assert np.max(np.abs(block.T @ weighed[rows])) < 1e-6 * np.linalg.norm(block)
    other = np.sin(np.arange(ROWS) / 20.0)
    assert np.linalg.norm(weighing(other)) > 0.95 * np.linalg.norm(bare(other)), "others stay"


def test_directions_count_in_whatever_units_they_are() -> None:
    """Those of a pressure beside those of a position were 1e-10 as large, and none: noise seemed 20 % too small."""
    columns, groups = directions()
    residual = coloured([1.0], 1.0, 1) + 3.0 * columns[:, 0] + 0.5 * columns[:, 1]
    weighing = weighing_of([[slice(0, ROWS)]], without(residual, columns, groups))
    alike, apart = (weighing.without(columns * scale, groups) for scale in ((1.0, 1.0), (1e10, 1e-10)))
    assert apart(residual) == pytest.approx(alike(residual), abs=1e-9)
    assert float(np.mean(apart(residual) ** 2)) == pytest.approx(1.0, abs=1e-3)


def test_no_direction_leaves_a_weighing_as_it_is() -> None:
    weighing = plain([[slice(0, 10)]], 10)
    assert weighing.without(np.zeros((0, 0)), ()) is weighing
    assert weighing.without(np.zeros((10, 2)), [np.arange(10)])(np.arange(10.0)) == pytest.approx(np.arange(10.0))


def test_a_residual_without_directions_is_least_beside_them_where_it_is_known() -> None:
    columns, groups = directions()
    residual = columns @ np.array([2.0, -1.0]) + 1e-3 * np.sin(np.arange(ROWS))
    residual[500:600] = 0.0
    left = without(residual, columns, groups)
    known = residual != 0.0
    assert np.sqrt(np.mean(left[known] ** 2)) < 1e-3
    assert residual[10] != pytest.approx(left[10]), "the residual itself is not changed"


def test_what_is_no_noise_counts_by_its_scatter_and_as_often_as_it_has_independent_values() -> None:
    """Of e_t + 0.9 e_{t-1} + ... one value in (1 + 0.9) / (1 - 0.9) is independent."""
    size = 100_000
    residual = coloured([1.0, -0.9], 2.0, 1, size)
    weighing = by_scatter([[slice(0, size)]], residual)
    assert isinstance(weighing, Weighing)
    weighed = weighing(residual)
    assert weighed @ weighed == pytest.approx(size * (1.0 - 0.9) / (1.0 + 0.9), rel=0.15)
    assert weighed / residual == pytest.approx(np.full(size, weighed[0] / residual[0]))


def test_what_is_below_its_floor_counts_by_the_floor() -> None:
    """The likelihood of a residual of a tenth of the floor is that of noise of the floor: nothing there is certain."""
    residual = 0.1 * np.random.default_rng(4).standard_normal(ROWS)
    weighed = by_scatter([[slice(0, ROWS)]], residual)(residual)
    assert float(np.std(weighed)) < 0.11


def test_a_plant_that_diverges_leaves_much_whatever_no_parameter_decides() -> None:
    """Where a plant starts may be any height and slope; a plant that is nowhere is no such thing."""
    motion = made_motion(20.0)

    def diverging(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
        gone = np.where(values.get("load_force", 0.0) > 1.0, np.nan, 0.0)
        return np.asarray(gone + values.get("load_force", 0.0) * motion.time)

    balance = made_balance([motion], diverging, {})
    first = fit(balance, {"load_force": 0.0}, ["load_force"])
    rows = np.arange(first.residual.size)
    start = np.vander(rows / rows.size, 3)
    weighing = weighing_of(balance.series, first.residual).without(start, [rows])
    assert first.seen_by(weighing) == pytest.approx(rows.size, rel=0.05)
    assert fit(balance, {"load_force": 2.0}, (), {}, weighing=weighing).squares > 1e6 * rows.size
