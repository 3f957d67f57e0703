"""First order finds motions; which of them is taken is told by the whole of each."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from workbench.design import design
from workbench.design.contrast import Contrast, Tried
from workbench.design.hypotheses import Hypothesis
from workbench.design.pieces import Condition, Piece
from workbench.design.search import LEAST, MOST, Wanted
from workbench.progress import silent

RIG: Any = None

NONE, OTHER = (Hypothesis(effects, {}, (), np.zeros((0, 0))) for effects in ((), ("backlash",)))


def tried(kind: str, squares: float = 1e9) -> Tried:
    """A piece of that kind, which leaves so much of the one pair to first order."""
    contrast = Contrast(squares, np.zeros(0), np.zeros((0, 0)))
    return Tried(Piece(kind, (0.5, 0.5, 0.5), 2.0, Condition(0.0, 0.0)), "", {(1, 0): contrast}, np.zeros((0, 0)), 1)


def taken(pieces: Sequence[Tried], left: Sequence[float], monkeypatch: pytest.MonkeyPatch) -> str:
    """The kind of the motion that is taken of some, of which so much is left as a whole."""
    answers: Iterator[float] = iter(left)
    monkeypatch.setattr(design, "_simulated", lambda rig, wanted, _: design.Simulated(rig, wanted.hypotheses, [], []))
    monkeypatch.setattr(design, "distances", lambda *_: ({(1, 0): next(answers)}, 0))
    return design._best(RIG, Wanted([NONE, OTHER]), [[piece] for piece in pieces], silent).chosen[0].piece.kind


def test_the_motion_that_does_most_as_a_whole_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    steps, sweep, ramps = tried("steps"), tried("sweep"), tried("ramps")
    assert taken([steps, sweep, ramps], [3.0, 30.0, 10.0], monkeypatch) == "sweep"
    assert taken([steps, sweep], [5.0, 0.0], monkeypatch) == "steps"


def test_no_fit_counts_that_leaves_more_than_first_order(monkeypatch: pytest.MonkeyPatch) -> None:
    assert taken([tried("steps", 8.0), tried("sweep", 12.0)], [1e5, 11.0], monkeypatch) == "sweep"


def test_a_rival_that_runs_away_is_told_most_surely(monkeypatch: pytest.MonkeyPatch) -> None:
    assert taken([tried("steps"), tried("sweep")], [100.0, np.inf], monkeypatch) == "sweep"

    def score(left: float) -> float:
        return Wanted([NONE, OTHER]).score_of({(1, 0): left}, [])

    assert score(np.inf) == score(MOST)
    assert score(0.0) < score(LEAST) < score(10.0)


def test_the_power_for_an_effect_is_the_mean_over_its_shapes() -> None:
    """What tells every shape hardly is worth more than what tells none but one surely, once that is one of three."""
    shaped = replace(OTHER, others=(OTHER, OTHER))
    wanted = Wanted([NONE, shaped])

    def power(*left: float) -> float:
        return float(np.exp(wanted.score_of(dict(zip([(1, 0), (2, 0), (3, 0)], left, strict=True)), [])))

    assert power(1e3, LEAST, LEAST) == pytest.approx(1.0 / 3.0, rel=0.01)
    assert power(6.0, 6.0, 6.0) == pytest.approx(0.5, rel=0.01)
    assert power(6.0, 6.0, 6.0) == pytest.approx(np.exp(Wanted([NONE, OTHER]).score_of({(1, 0): 6.0}, [])))
