"""Pieces of a motion: within what a rig allows, at rest in the middle at both ends, the same for the same shares."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.design.pieces import KINDS, Condition, Piece, Reach, sampled, samples, shaped

REACH = Reach(-0.01, 0.03, 0.2, 1e-3)
SHARE = st.floats(0.0, 1.0)


def piece(kind: str, *shares: float, duration: float = 6.0) -> Piece:
    return Piece(kind, (shares[0], shares[1], shares[2]), duration, Condition())


@given(st.sampled_from(sorted(KINDS)), SHARE, SHARE, SHARE)
def test_a_piece_stays_in_the_range_and_begins_and_ends_in_its_middle(
    kind: str, size: float, pace: float, place: float
) -> None:
    asked = piece(kind, size, pace, place)
    values = sampled(asked, REACH)
    assert values.size == samples(asked, REACH) == 6000
    assert values[0] == pytest.approx(REACH.middle, abs=1e-12)
    assert values[-1] == pytest.approx(REACH.middle, abs=1e-6)
    assert values.min() >= REACH.low - 1e-9
    assert values.max() <= REACH.high + 1e-9


@given(st.sampled_from(sorted({*KINDS} - {"steps"})), SHARE, SHARE)
def test_what_is_no_step_is_no_faster_than_asked(kind: str, size: float, pace: float) -> None:
    asked = piece(kind, size, pace, 0.5)
    of = shaped(asked, REACH)
    time = np.arange(0.0, 6.0 - 2.0 * of.approach, 1e-3)
    slowest = 2.0 * np.pi * of.numbers["amplitude"] * 8.0 / time[-1]  # one period of all that a piece has room for
    assert np.max(np.abs(of.signal(time)[1])) <= max(REACH.speed, slowest) * 1.01


def test_ramps_have_the_speed_and_the_size_that_are_said() -> None:
    of = shaped(piece("ramps", 1.0, 0.6, 0.5), REACH)
    time = np.arange(0.0, 4.8, 1e-3)
    value, rate, _ = of.signal(time)
    assert np.max(np.abs(value)) == pytest.approx(of.numbers["amplitude"], rel=2e-3) == pytest.approx(0.02, rel=2e-3)
    assert np.abs(rate) == pytest.approx(of.numbers["speed"])


def test_steps_hold_as_long_as_is_said() -> None:
    of = shaped(piece("steps", 0.5, 0.5, 0.5), REACH)
    changes = np.flatnonzero(np.diff(of.signal(np.arange(0.0, 4.8, 1e-3))[0])) * 1e-3
    assert np.diff(changes)[:3] == pytest.approx(of.numbers["hold"], abs=2e-3)
