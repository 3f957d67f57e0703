"""Deciding: intervals and tests against published values, the order of candidates, choices that are measured again."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from workbench.decide.batches import SampleRun, runs_frame
from workbench.decide.candidate import CandidateResult, Kind, candidate_results
from workbench.decide.order import non_dominated, ordered
from workbench.decide.report.rows import results
from workbench.decide.result import Cell
from workbench.decide.run import sureness
from workbench.decide.schema import DecideTable
from workbench.metrics.statistics import (
    deciding_counts,
    least_draws,
    quantile,
    quantile_interval,
    settling_draws,
    share_interval,
    sign_test,
)

TABLE = DecideTable.model_validate(
    {"accuracy": 1e-5, "speed": 8e-3, "amplitude": 5e-3, "power": 80.0, "rpm": [0, 25], "plain": ["feed"]}
)


def judged(controller: str, rpm: float, error: float, power: float, met: int = 0, draws: int = 64) -> CandidateResult:
    """A candidate with this error quantile and power, which `met` of its draws keep to."""
    passed = (True,) * met + (False,) * (draws - met)
    kind: Kind = "rotation" if rpm else "plain"
    failures = {"accuracy": draws - met} if met < draws else {}
    return CandidateResult(
        *(controller, rpm, 8e-3, 1.0, kind, "search", "completed", passed, failures, 0),
        *(0.95, *share_interval(met, draws), 0.5, 1.0, error, 0.9 * error, 1.1 * error, power, power, power, 0.0, rpm),
    )


@pytest.mark.parametrize(
    ("successes", "trials", "low", "high"),
    [(81, 263, 0.2527, 0.3676), (15, 148, 0.0578, 0.1617), (0, 20, 0.0, 0.1684), (1, 29, 0.0009, 0.1776)],
)
def test_interval_of_a_share_is_as_published(successes: int, trials: int, low: float, high: float) -> None:
    """Newcombe 1998, Statistics in Medicine 17, 857, table I, method 5 (Clopper and Pearson's)."""
    assert share_interval(successes, trials) == pytest.approx((low, high), abs=5e-5)


def test_how_many_draws_settle() -> None:
    """0.9^n is below 0.025 from n = 36 on; of 100, textbook tables give 84 to 96 as the counts that leave 0.9 open."""
    assert least_draws(0.9) == math.ceil(math.log(0.025) / math.log(0.9)) == 36
    assert deciding_counts(0.9, 35) == (None, 27)
    assert deciding_counts(0.9, 36)[0] == 36
    met, missed = deciding_counts(0.9, 100)
    assert met is not None
    assert missed is not None
    assert share_interval(met, 100)[0] > 0.9 >= share_interval(met - 1, 100)[0]
    assert share_interval(missed, 100)[1] < 0.9 <= share_interval(missed + 1, 100)[1]


def test_draws_that_would_tell() -> None:
    """n = z^2 p (1 - p) / d^2 = 1.96^2 0.93 0.07 / 0.03^2 = 278, and somewhat more since the interval is exact."""
    draws = settling_draws(0.93, 0.9)
    assert draws is not None
    assert 278 <= draws <= 1.35 * 278
    assert share_interval(round(0.93 * draws), draws)[0] > 0.9
    assert settling_draws(0.9, 0.9) is None


@pytest.mark.parametrize(("share", "count", "rank"), [(0.07, 100, 7), (0.35, 20, 7), (0.9, 10, 9), (0.91, 10, 10)])
def test_a_quantile_is_the_draw_of_its_rank_whatever_the_rounding(share: float, count: int, rank: int) -> None:
    """In floating point 0.07 times 100 is above 7: the draw of the next rank is not the one that is meant."""
    assert quantile([float(k) for k in range(count, 0, -1)], share) == rank
    assert quantile([*range(1, count), math.inf], share) == (rank if rank < count else math.inf)


def test_interval_of_a_quantile_is_between_the_textbook_ranks() -> None:
    """The median of ten: the second to the ninth (97.9 %; Conover, Practical Nonparametric Statistics, section 3.2)."""
    values = [float(value) for value in range(10, 0, -1)]
    assert (quantile(values, 0.5), quantile_interval(values, 0.5)) == (5.0, (2.0, 9.0))
    assert quantile_interval(values, 0.9)[1] == math.inf  # 0.9^10 = 0.35: the largest may well be below it
    assert quantile(values, 0.9) == 9.0


def test_sign_test_counts_what_differs() -> None:
    """Six of six: 2 / 2^6; five of six: 2 (1 + 6) / 2^6."""
    first, second = [True] * 6 + [True, False], [False] * 6 + [True, False]
    assert sign_test(first, second) == (6, 0, pytest.approx(0.03125))
    assert sign_test([*first[:5], False], [*second[:5], True]) == (5, 1, pytest.approx(0.21875))
    assert sign_test(first, first) == (0, 0, 1.0)


def test_non_dominated_set_of_points() -> None:
    """The best of about one power, then each that is better than all that need less."""
    points = [(3.0, 9.0), (3.1, 8.0), (26.0, 7.0), (26.5, 7.5), (100.0, 7.0), (240.0, 5.0), (250.0, 6.0)]
    rows = [judged("feed", 0.0, error, power) for power, error in points]
    front = [(row.mean_power, row.error) for row in non_dominated([*rows, judged("feed", 0.0, math.inf, 1.0)])]
    assert front == [(3.1, 8.0), (26.0, 7.0), (240.0, 5.0)]


def test_candidates_that_meet_come_first_by_power_then_error() -> None:
    rows = [
        judged("nearer", 25.0, 1.1e-5, 20.0, 50),
        judged("dear", 25.0, 1e-6, 25.0, 64),
        judged("cheap", 0.0, 9e-6, 3.0, 60),
        judged("cheap and better", 0.0, 5e-6, 3.1, 60),
        judged("far", 0.0, 1e-4, 3.0, 0),
        judged("very far", 0.0, 1e-3, 3.0, 0),
    ]
    assert [row.controller for row in ordered(rows, TABLE)] == [
        "cheap and better", "cheap", "dear", "nearer", "far", "very far"]  # fmt: skip


def test_intervals_of_all_that_are_measured_hold_together() -> None:
    """1/2 + 1/6 + 1/12 + ...: what they may miss together is 5 %, however many there are."""
    assert sum(1.0 - sureness(i) for i in range(1, 10001)) == pytest.approx(0.05, abs=1e-5)
    assert sureness(1) == 0.975


def drawn(
    row: CandidateResult, probability: float, draws: int, sure: float, generator: np.random.Generator
) -> CandidateResult:
    """The same candidate on draws that it meets with a probability that is known."""
    passed = tuple(bool(each) for each in generator.random(draws) < probability)
    low, high = share_interval(sum(passed), draws, sure)
    return replace(row, passed=passed, low=low, high=high, sure=sure)


def test_having_been_picked_flatters_none() -> None:
    """Thirty candidates of known probability: the choice's interval holds it, the winner's on the search does not."""
    generator, table = np.random.default_rng(5), TABLE
    held = picked = chosen = 0
    for _ in range(300):
        truth = {f"c{i}": float(p) for i, p in enumerate(generator.uniform(0.75, 0.95, 30))}
        rows = [drawn(judged(name, 0.0, 1e-6, 3.0), p, 24, 0.95, generator) for name, p in truth.items()]
        cell = Cell(8e-3, 1.0, table, rows)
        while (row := cell.next()) is not None:
            sure = sureness(len(cell.measured) + 1)
            cell = cell.with_measured([replace(drawn(row, truth[row.controller], 200, sure, generator), stage="fresh")])
        named = cell.answer().best
        if named.stage == "fresh":
            chosen += 1
            held += named.low <= truth[named.controller] <= named.high
        winner = max(rows, key=lambda row: row.probability)
        picked += winner.probability > truth[winner.controller]
    assert chosen > 250
    assert held >= 0.95 * chosen
    assert picked > 0.95 * 300  # the share on the draws of which it is the best is nearly always too high


def test_the_walk_goes_on_where_the_fresh_draws_rule_out() -> None:
    """The cheapest looks best on the search, and is not; the next is; a costly one is never measured."""
    rows = [judged("cheap", 0.0, 1e-6, 3.0, 64), judged("next", 0.0, 1e-6, 5.0, 64), judged("dear", 0.0, 1e-6, 9.0, 64)]
    cell = Cell(8e-3, 1.0, TABLE, rows)
    for met in (150, 200):
        row = cell.next()
        assert row is not None
        fresh = judged(row.controller, 0.0, row.error, row.mean_power, met, 200)
        cell = cell.with_measured([replace(fresh, stage="fresh")])
    assert cell.next() is None
    assert [(row.controller, row.standing(TABLE)) for row in cell.measured] == [("cheap", "fails"), ("next", "meets")]
    given = cell.answer()
    assert (given.kind, given.best.controller, given.settled, given.open) == ("plain", "next", True, ())


def test_what_cannot_be_told_is_said() -> None:
    """A plain controller whose interval holds 0.9 leaves the kind open, though rotation is sure to do."""
    rows = [judged("feed", 0.0, 1e-6, 3.0, 64), judged("feed", 25.0, 1e-6, 30.0, 64)]
    cell = Cell(8e-3, 1.0, TABLE, rows)
    cell = cell.with_measured([replace(judged("feed", 0.0, 1e-6, 3.0, 182, 200), stage="fresh")])
    cell = cell.with_measured([replace(judged("feed", 25.0, 1e-6, 30.0, 200, 200), stage="fresh")])
    given = cell.answer()
    assert (given.kind, given.settled, [row.rpm for row in given.open]) == ("rotation", False, [0.0])
    assert given.doubtful == ("plain",)


def test_what_hunts_never_wins() -> None:
    """It meets all else on every draw, and hunts on one of them."""
    hunting = replace(judged("feed", 0.0, 1e-6, 3.0, 64), hunting=1)
    cell = Cell(8e-3, 1.0, TABLE, [hunting, judged("other", 0.0, 2e-6, 3.0, 64)])
    row = cell.next()
    assert row is not None
    assert row.controller == "other"
    assert (hunting.standing(TABLE), hunting.main_failure) == ("fails", "hunting")
    alone = Cell(8e-3, 1.0, TABLE, [hunting])
    assert alone.next() is None
    assert alone.answer().kind is None


def test_what_fails_is_told_by_draw() -> None:
    """Three of five complete; one of these is too inexact, one takes too much power, one hunts at rest."""
    draws = [
        ("completed", True, True, False),
        ("stuck", False, False, False),
        ("torque-limited", False, False, False),
        ("completed", False, True, False),
        ("completed", True, False, False),
        ("completed", True, True, True),
        ("completed", False, True, False),
    ]
    rows = [
        SampleRun(
            *("search", "feed", 0.0, 8e-3, 1.0, i, outcome, 1e-6, 3.0 + i, 3.0, None, None),
            accurate=accurate,
            within_power=within,
            hunts=hunts,
        )
        for i, (outcome, accurate, within, hunts) in enumerate(draws)
    ]
    (result,) = candidate_results(runs_frame(rows), TABLE)
    assert result.failures == {"stuck": 1, "torque-limited": 1, "accuracy": 2, "power": 1, "hunting": 1}
    assert (result.met, result.hunting, result.main_failure, result.error) == (1, 1, "hunting", math.inf)
    assert result.outcome == "5 completed, 1 stuck, 1 torque-limited"
    assert result.mean_power == pytest.approx((3.0 + 6.0 + 7.0 + 8.0 + 9.0) / 5.0)
    assert pd.isna(results([Cell(8e-3, 1.0, TABLE, [result])])["error_quantile_m"][0])
