"""What a rival's refit leaves of a difference, held against least squares; and which pairs may be told at all."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.design.contrast import Contrast, pairs_of
from workbench.design.hypotheses import NOTHING, Hypothesis, truths_of
from workbench.diagnose.residuals.unknowns import Unknown

DRAW = np.random.default_rng(4)


def hypothesis(effects: tuple[str, ...] = (), known: float = 1e-12, room: float = np.inf) -> Hypothesis:
    """Two unknowns at 1, known that precisely, with so much room."""
    unknowns = [Unknown(name, 1.0, 1.0, False, 1.0 - room, 1.0 + room) for name in ("a", "b")]
    return Hypothesis(effects, {"a": 1.0, "b": 1.0}, unknowns, known * np.eye(2))


def test_t_is_what_least_squares_leaves() -> None:
    columns, difference = DRAW.standard_normal((50, 2)), DRAW.standard_normal(50)
    left, moved = Contrast.of(difference, columns).refitted(hypothesis())
    expected, (squares,) = np.linalg.lstsq(columns, difference, rcond=None)[:2]
    assert left == pytest.approx(squares, rel=1e-9)
    assert moved == pytest.approx(expected, rel=1e-6)


def test_what_is_known_of_a_rival_holds_it_back() -> None:
    columns, difference = DRAW.standard_normal((50, 2)), DRAW.standard_normal(50)
    contrast = Contrast.of(difference, columns)
    whole = np.vstack([columns, 3.0 * np.eye(2)])
    expected = np.linalg.lstsq(whole, np.append(difference, [0.0, 0.0]), rcond=None)[1][0]
    assert contrast.refitted(hypothesis(known=9.0))[0] == pytest.approx(expected, rel=1e-9)
    assert contrast.refitted(hypothesis(known=1e12))[0] == pytest.approx(difference @ difference, rel=1e-6)


def test_a_rival_stays_within_its_bounds() -> None:
    columns = np.eye(2)
    left, moved = Contrast.of(np.array([3.0, 0.0]), columns).refitted(hypothesis(room=1.0))
    assert moved == pytest.approx([1.0, 0.0])
    assert left == pytest.approx(4.0)


def test_contrasts_of_pieces_add_up() -> None:
    columns, difference = DRAW.standard_normal((60, 2)), DRAW.standard_normal(60)
    parts = [Contrast.of(difference[part], columns[part]) for part in (slice(0, 25), slice(25, 60))]
    whole, of = Contrast.of(difference, columns), hypothesis()
    assert (parts[0] + parts[1]).refitted(of)[0] == pytest.approx(whole.refitted(of)[0], rel=1e-9)


def test_pieces_have_where_the_motion_starts_in_common() -> None:
    """A column that no precision holds stands behind the unknowns: what it makes up for tells nothing, in both."""
    columns, place = DRAW.standard_normal((60, 2)), np.ones((60, 1))
    difference = 3.0 + 0.1 * DRAW.standard_normal(60)
    whole = np.column_stack([columns, place])
    parts = [Contrast.of(difference[part], whole[part]) for part in (slice(0, 25), slice(25, 60))]
    left, moved = (parts[0] + parts[1]).refitted(hypothesis(room=1e3))
    assert left == pytest.approx(np.linalg.lstsq(whole, difference, rcond=None)[1][0], rel=1e-6)
    assert moved.size == 3
    assert left < 1e-2 * Contrast.of(difference, columns).refitted(hypothesis())[0]


def test_a_plant_without_an_effect_is_never_told_from_one_that_may_have_it() -> None:
    none, backlash, other = hypothesis(), hypothesis(("backlash",)), hypothesis(("cogging",))
    assert pairs_of([none, backlash, other]) == [(1, 0), (1, 2), (2, 0), (2, 1)]
    assert none.name == NOTHING
    assert backlash.name == "backlash"


def test_every_shape_of_an_effect_may_be_true_and_no_shape_is_told_from_another() -> None:
    none, other = hypothesis(), hypothesis(("backlash",))
    cogging = replace(hypothesis(("cogging",)), others=(hypothesis(("cogging",)), hypothesis(("cogging",))))
    hypotheses = [none, cogging, other]
    assert truths_of(hypotheses) == [*hypotheses, *cogging.others]
    assert pairs_of(hypotheses) == [(1, 0), (1, 2), (2, 0), (2, 1), (3, 0), (3, 2), (4, 0), (4, 2)]


def test_values_move_as_a_search_sees_them_and_no_farther_than_there_is_room() -> None:
    assert hypothesis().moved(np.array([0.5, -2.0])) == {"a": 1.5, "b": -1.0}
    assert hypothesis(room=1.0).moved(np.array([5.0, -5.0])) == {"a": 2.0, "b": 0.0}
