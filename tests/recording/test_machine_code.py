"""Machine code of equations against NumPy's numbers: every operation, branches, what is stored where."""

import ctypes
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plants.equation import select
from workbench.recording.machine_code import machine_code
from workbench.recording.operations import LOGICAL, OPERATIONS, ORDERING
from workbench.recording.symbols import UnrecordableError


class Pair(NamedTuple):
    first: float
    second: float


TWO = ("minimum", "maximum", "power", "arctan2", "hypot", "copysign", "add", "subtract", "multiply", "divide")
ONE = sorted(OPERATIONS - {*TWO, *ORDERING, *LOGICAL, "where"})
EDGES = (0.0, -0.0, 1.0, -1.0, 0.5, -2.5, 3e-9, 7e11, np.inf, -np.inf, np.nan)


def called(equation: Callable[..., Any]) -> Callable[[float, float], float]:
    """An equation of two numbers in machine code."""
    code = machine_code(lambda first, second, pair: (equation(first, second), pair), (None, None, Pair), 2, gives=True)
    scratch = (ctypes.c_double * 2)()
    return lambda first, second: code.ctypes(first, second, scratch)


def same(found: float, expected: float, ulps: int = 0) -> bool:
    if np.isnan(expected) or np.isinf(expected) or expected == 0.0:
        return bool(np.isnan(found) and np.isnan(expected)) or found == expected
    return abs(found - expected) <= ulps * np.spacing(abs(expected))


@pytest.mark.parametrize("name", ONE)
def test_a_function_of_one_number_is_numpy_s(name: str) -> None:
    function = getattr(np, name)
    run = called(lambda first, second: function(first) + 0.0 * second)
    with np.errstate(all="ignore"):
        for value in EDGES:
            assert same(run(value, 1.0), float(function(value)), ulps=1), (name, value)


@pytest.mark.parametrize("name", TWO)
def test_a_function_of_two_numbers_is_numpy_s(name: str) -> None:
    function = getattr(np, name)
    run = called(function)
    with np.errstate(all="ignore"):
        for first in EDGES:
            for second in EDGES:
                if (name, first, second) == ("power", -np.inf, 0.5):
                    continue  # C says infinity; NumPy takes a square root
                assert same(run(first, second), float(function(first, second)), ulps=1), (name, first, second)


@pytest.mark.parametrize("name", [*ORDERING, "logical_and", "logical_or"])
def test_a_condition_is_numpy_s_and_1_where_it_holds(name: str) -> None:
    function = getattr(np, name)
    conditions = name in LOGICAL
    run = called(lambda a, b: function(a > 0.0, b > 0.0) * 1.0 if conditions else function(a, b) * 1.0)
    for first in EDGES:
        for second in EDGES:
            given = (first > 0.0, second > 0.0) if conditions else (first, second)
            assert run(first, second) == float(function(*given)), (name, first, second)


def nested(x: Any, y: Any) -> Any:
    """Sides that are dear, within one another, and what several of them share."""
    shared = np.exp(-np.abs(x))
    inner = select(y > 0.5, np.tanh(y) * shared, np.sin(x * y))
    dear = select(x > y, inner + np.cos(x), select(y < 0.0, np.log1p(x * x), inner - shared))
    return dear + select(x * y > 0.0, x / y, 2.0)


@given(x=st.floats(-3.0, 3.0), y=st.floats(-3.0, 3.0))
@settings(max_examples=200, deadline=None)
def test_what_waits_on_a_side_changes_no_result(x: float, y: float) -> None:
    with np.errstate(all="ignore"):
        expected = float(nested(np.float64(x), np.float64(y)))  # NumPy's functions round otherwise than C's
        assert NESTED(x, y) == pytest.approx(expected, rel=1e-13, abs=1e-13, nan_ok=True)


NESTED = called(nested)


@pytest.mark.parametrize("lanes", [2, 4])
def test_several_lanes_have_the_bits_of_one(lanes: int) -> None:
    """Every operation of two numbers and of one, conditions, and what a scalar function would branch on."""

    def every(first: Any, second: Any) -> tuple[Any, ...]:
        ones = [getattr(np, name)(first) + 0.0 * second for name in ONE]
        twos = [getattr(np, name)(first, second) for name in TWO]
        conditions = [getattr(np, name)(first, second) for name in ORDERING]
        both = [select(np.logical_not(first > second) & (second > 0.0), first, 3.0), nested(first, second)]
        return (*ones, *twos, *both, *(select(condition, 1.0, 0.0) for condition in conditions))

    size = len(every(np.float64(0.3), np.float64(0.2)))
    one = machine_code(lambda pair: every(*pair), (Pair,), into=1)
    several = machine_code(lambda pair: every(*pair), (2,), into=1, lanes=lanes)
    pairs = [(a, b) for a in EDGES for b in EDGES]
    pairs += [pairs[0]] * (-len(pairs) % lanes)
    for at in range(0, len(pairs), lanes):
        some = np.array(pairs[at : at + lanes])
        numbers, out = (ctypes.c_double * (2 * lanes))(*some.T.ravel()), (ctypes.c_double * (size * lanes))()
        several.ctypes(numbers, out)
        for lane, pair in enumerate(some):
            alone = (ctypes.c_double * size)()
            one.ctypes((ctypes.c_double * 2)(*pair), alone)
            np.testing.assert_array_equal(np.array(out).reshape(size, lanes)[:, lane], np.array(alone))


def test_results_are_stored_behind_their_pointer_whatever_it_shares() -> None:
    """A state that is read and written at one place: nothing is written before all is read."""
    code = machine_code(lambda pair: Pair(pair.second, pair.first + pair.second), (Pair,), into=0)
    numbers = (ctypes.c_double * 2)(1.0, 2.0)
    code.ctypes(numbers)
    assert list(numbers) == [2.0, 3.0]


def test_a_condition_and_a_plain_number_are_stored_as_numbers() -> None:
    code = machine_code(lambda pair: Pair(pair.first > pair.second, 3), (Pair,), into=1)
    numbers, out = (ctypes.c_double * 2)(2.0, 1.0), (ctypes.c_double * 2)()
    code.ctypes(numbers, out)
    assert list(out) == [1.0, 3.0]


@pytest.mark.parametrize(
    ("equation", "reason"),
    [
        (
            lambda a, b: a if a > b else b,
            'branches on a value; in place of a condition ("if", "and", "max") use select(condition, a, b)',
        ),
        (lambda a, b: np.cbrt(a) + b, "uses np.cbrt, which is not among the functions of equations"),
        (lambda a, b: float(a) + b, "turns a value into a float; leave that out"),
    ],
)
def test_what_cannot_be_recorded_is_told(equation: Callable[..., Any], reason: str) -> None:
    with pytest.raises(UnrecordableError) as raised:
        called(equation)
    assert str(raised.value) == reason
