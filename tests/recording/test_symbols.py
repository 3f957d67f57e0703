"""What is recorded of an equation: its operations in their order, and what it calls them."""

import numpy as np
import pytest

from plants.equation import select
from workbench.export.statements import DOUBLE, SINGLE, counts, statements
from workbench.recording.symbols import Recording, Symbol, UnrecordableError


def inputs(*names: str) -> tuple[Recording, list[Symbol]]:
    recording = Recording()
    return recording, [recording.input(name) for name in names]


def written(recording: Recording, result: Symbol) -> list[str]:
    return [line.strip() for line in statements(recording, {"": result.place}, DOUBLE)]


def test_operations_keep_the_order_of_the_equation() -> None:
    recording, (a, b, c) = inputs("a", "b", "c")
    assert written(recording, a - (b - c)) == ["return a - (b - c);"]
    assert written(recording, (a - b) - c) == ["return a - b - c;"]
    assert written(recording, a * (b + c) / -b) == ["return a * (b + c) / -b;"]
    assert written(recording, a / (b * c)) == ["return a / (b * c);"]
    assert written(recording, -(a + b) * c) == ["return -(a + b) * c;"]
    assert written(recording, np.exp(-np.maximum(a, 2.0))) == ["return exp(-maximum(a, 2.0));"]
    chosen = select(np.logical_and(a > b, b >= c), a, select(a == c, b, c))
    assert written(recording, 2.0 * chosen) == ["return 2.0 * (a > b && b >= c ? a : (a == c ? b : c));"]


def test_whole_powers_are_products_as_compiled_code_makes_them() -> None:
    recording, (a,) = inputs("a")
    assert written(recording, a**2) == ["return a * a;"]
    assert written(recording, a**3) == ["return a * (a * a);"]
    assert written(recording, a**-1) == ["return 1.0 / a;"]
    assert written(recording, a**0.5) == ["return pow(a, 0.5);"]


def test_what_changes_nothing_is_left_out_and_numbers_are_computed() -> None:
    recording, (a,) = inputs("a")
    assert (1.0 * a + 0.0).place == a.place == (a / 1.0 - 0.0).place
    assert recording.number((0.0 * a).place) == 0.0
    assert recording.number(np.exp(a * 0.0).place) == 1.0
    assert np.where(np.abs(0.0 * a) < 1.0, a, 2.0).place == a.place


def test_what_is_computed_twice_is_a_constant_under_its_own_name() -> None:
    recording, (a, b) = inputs("a", "b")

    def inner(x: Symbol) -> Symbol:
        """Sum of both."""
        total = x + b
        return total

    def outer(x: Symbol) -> Symbol:
        """Twice the sum, squared."""
        return inner(x) * inner(x)

    with recording.sources():
        result = outer(a)
    assert written(recording, result) == [
        "/* inner: Sum of both. */",
        "const double total = a + b;",
        "return total * total;",
    ]
    assert dict(counts(recording, {"": result.place})) == {"additions": 1, "multiplications": 1}


def test_a_guard_against_division_by_zero_stays_one_in_single_precision() -> None:
    recording, (a,) = inputs("a")
    (line,) = statements(recording, {"": (a + 1e-40).place}, SINGLE)
    assert line.strip() == "return a + 1.1754943508222875e-38f;"
    assert [SINGLE.number(value) for value in (np.nan, -np.inf, 0.1)] == ["(float)NAN", "-HUGE_VALF", "0.1f"]


def test_what_cannot_be_written_says_why() -> None:
    _, (a, b) = inputs("a", "b")
    with pytest.raises(UnrecordableError, match="branches on a value"):
        _ = a if a > b else b
    with pytest.raises(UnrecordableError, match=r"uses np\.arccosh, which is not among"):
        np.arccosh(a)
    with pytest.raises(UnrecordableError, match=r"uses np\.sum, which is not among"):
        np.sum(a)
    with pytest.raises(UnrecordableError, match="turns a value into a float"):
        float(a)
    with pytest.raises(UnrecordableError, match="computes with a list"):
        np.add(a, [1.0])
