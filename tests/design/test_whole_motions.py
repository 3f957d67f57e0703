"""First order finds motions; which of them is taken is told by the whole of each."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest

from workbench.design import design
from workbench.design.contrast import Tried
from workbench.design.pieces import Condition, Piece
from workbench.design.search import LEAST, MOST, Wanted
from workbench.progress import silent

RIG: Any = None


def tried(kind: str) -> Tried:
    """A piece of that kind, of which nothing more is asked."""
    return Tried(Piece(kind, (0.5, 0.5, 0.5), 2.0, Condition(0.0, 0.0)), "", {}, np.zeros((0, 0)), 1)


def taken(kinds: Sequence[str], left: Sequence[float], monkeypatch: pytest.MonkeyPatch) -> str:
    """The kind of the motion that is taken of some, of which so much is left."""
    answers: Iterator[float] = iter(left)
    monkeypatch.setattr(design, "_whole", lambda rig, wanted, chosen: design.Whole(chosen, [], []))
    monkeypatch.setattr(design, "distances", lambda *_: [next(answers)])
    return design._best(RIG, Wanted([]), [[tried(kind)] for kind in kinds], silent).chosen[0].piece.kind


def test_the_motion_that_does_most_as_a_whole_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    assert taken(["steps", "sweep", "ramps"], [3.0, 30.0, 10.0], monkeypatch) == "sweep"
    assert taken(["steps", "sweep"], [5.0, 0.0], monkeypatch) == "steps"


def test_a_rival_that_runs_away_is_told_most_surely(monkeypatch: pytest.MonkeyPatch) -> None:
    assert taken(["steps", "sweep"], [100.0, np.inf], monkeypatch) == "sweep"
    wanted = Wanted([])
    assert wanted.score_of([np.inf], []) == wanted.score_of([MOST], [])
    assert wanted.score_of([0.0], []) < wanted.score_of([LEAST], []) < wanted.score_of([10.0], [])
