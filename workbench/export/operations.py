"""What an equation may compute, as C99 has it, and how it is counted."""

from typing import NamedTuple


class Operation(NamedTuple):
    """An operation in C: what its `text` is with operands in it, how closely it binds, and as what it is counted.

    Operands in braces: `{0:<}` binds at least as closely as the operation itself, `{0:~}` as it likes, others more
    closely. `helper`: the name of a function of `HELPERS`. An underscore is a space at which no line ends.
    """

    text: str
    binds: int
    counted: str
    helper: str = ""


ATOM, UNARY, PRODUCT, SUM, ORDER, EQUAL, AND, OR, CHOICE, LEAST = range(9, -1, -1)
"""How closely operations bind, closest first."""

ADDED, MULTIPLIED, DIVIDED, COMPARED, CALLED = (
    "additions",
    "multiplications",
    "divisions",
    "comparisons and choices",
    "calls of math.h",
)
"""How operations are counted, in the order in which they are told."""


def _call(function: str, *, helper: bool = False, arguments: int = 1) -> Operation:
    """A function of math.h, or one of `HELPERS`, which compares."""
    operands = ", ".join(f"{{{i}:~}}" for i in range(arguments))
    if helper:
        return Operation(f"{function}({operands})", ATOM, COMPARED, function)
    return Operation(f"{function}$({operands})", ATOM, CALLED)


OPERATIONS = {
    "add": Operation("{0:<} +_{1}", SUM, ADDED),
    "subtract": Operation("{0:<} -_{1}", SUM, ADDED),
    "multiply": Operation("{0:<} *_{1}", PRODUCT, MULTIPLIED),
    "divide": Operation("{0:<} /_{1}", PRODUCT, DIVIDED),
    "negative": Operation("-{0}", UNARY, ADDED),
    "absolute": Operation("fabs$({0:~})", ATOM, ADDED),
    "less": Operation("{0} <_{1}", ORDER, COMPARED),
    "less_equal": Operation("{0} <=_{1}", ORDER, COMPARED),
    "greater": Operation("{0} >_{1}", ORDER, COMPARED),
    "greater_equal": Operation("{0} >=_{1}", ORDER, COMPARED),
    "equal": Operation("{0} ==_{1}", EQUAL, COMPARED),
    "not_equal": Operation("{0} !=_{1}", EQUAL, COMPARED),
    "logical_and": Operation("{0:<} &&_{1}", AND, COMPARED),
    "logical_or": Operation("({0:~}) ||_({1:~})", OR, COMPARED),
    "logical_not": Operation("!({0:~})", UNARY, COMPARED),
    "where": Operation("{0} ?_{1} :_{2}", CHOICE, COMPARED),
    "minimum": _call("minimum", helper=True, arguments=2),
    "maximum": _call("maximum", helper=True, arguments=2),
    "sign": _call("sign", helper=True),
    "power": _call("pow", arguments=2),
    "arctan2": _call("atan2", arguments=2),
    "hypot": _call("hypot", arguments=2),
    "copysign": _call("copysign", arguments=2),
    "arcsin": _call("asin"),
    "arccos": _call("acos"),
    "arctan": _call("atan"),
    **{
        name: _call(name)
        for name in (
            *("sqrt", "exp", "expm1", "log", "log1p", "log10", "sin", "cos", "tan", "sinh", "cosh", "tanh"),
            *("floor", "ceil", "rint", "trunc"),
        )
    },
}
"""By the name of NumPy's function. A $ behind a function of math.h stands for the suffix of single precision."""

HELPERS = {
    "minimum": "static {real} minimum({real} a, {real} b)\n{{\n    return a <= b || a != a ? a : b;\n}}\n",
    "maximum": "static {real} maximum({real} a, {real} b)\n{{\n    return a >= b || a != a ? a : b;\n}}\n",
    "sign": ("static {real} sign({real} a)\n{{\n    return a > {zero} ? {one} : a < {zero} ? -{one} : a;\n}}\n"),
}
"""Functions that math.h has not, or has otherwise: no number in, no number out, as in NumPy."""
