"""What waits until a condition is known."""

from collections.abc import Callable
from typing import Any

import numpy as np

from plants.equation import select
from workbench.recording.branches import WHOLE, branches_of
from workbench.recording.symbols import Recording, needed


def waiting(equation: Callable[..., Any]) -> list[tuple[str, int]]:
    """The operations that wait, each with how many sides it lies within."""
    recording = Recording()
    result = recording.place(equation(recording.input("x"), recording.input("y")))
    places = needed(recording, [result])
    branches = branches_of(recording.instructions, places, [result])
    found = []
    for place in places:
        depth, side = 0, branches.side[place]
        while side != WHOLE:
            depth, side = depth + 1, branches.side[side[0]]
        if depth and recording.instructions[place].operands:
            found.append((recording.instructions[place].operation, depth))
    return found


def test_a_dear_side_waits_and_a_cheap_one_does_not() -> None:
    assert waiting(lambda x, y: select(x > y, np.exp(x), y)) == [("exp", 1)]
    assert waiting(lambda x, y: select(x > y, x + y, y)) == []


def test_what_is_wanted_elsewhere_too_does_not_wait() -> None:
    assert waiting(lambda x, y: select(x > y, np.exp(x), y) + np.exp(x)) == []
    assert waiting(lambda x, y: select(np.exp(x) > y, np.exp(x), y)) == []


def test_a_side_within_a_side() -> None:
    def equation(x: Any, y: Any) -> Any:
        return select(x > y, select(x > 2.0 * y, np.exp(x), np.sin(y)) + np.cos(x), y)

    assert set(waiting(equation)) >= {("exp", 2), ("sin", 2), ("cos", 1), ("where", 1)}


def test_what_both_sides_of_a_side_want_waits_before_them() -> None:
    def equation(x: Any, y: Any) -> Any:
        root = np.tanh(x)
        return select(x > y, select(x > 2.0 * y, np.exp(root), np.sin(root)), y)

    assert set(waiting(equation)) >= {("exp", 2), ("sin", 2), ("tanh", 1)}
