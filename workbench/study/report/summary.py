"""Figures of several cases as one: what a table or a panel shows `over` the draws of a machine, or any other axis."""

from collections.abc import Sequence

import numpy as np

from workbench.study.names import unit_of_column
from workbench.study.report.schema import SHARES, Summary
from workbench.toml.units import si

TAKES = {
    "mean": "mean",
    "median": "median",
    "minimum": "least",
    "maximum": "largest",
    "standard_deviation": "standard deviation",
}
"""What is taken of several values, in words."""


def summary_unit(summary: Summary, column: str) -> str:
    """The unit of what is taken of a column: that of its values, or "1" of a share of them."""
    return "1" if summary.take in SHARES else unit_of_column(column)


def taken(values: Sequence[object], summary: Summary, column: str) -> float | str | None:
    """What `summary` takes of the values that a column has in some cases: of those that there are, but shares of all,
    since a case without a value has none that counts.

    A single value where nothing is to be taken; None where there is none, or of one alone a standard deviation.

    Raises:
        ValueError: words where numbers are needed.
        QuantityError: a level that is no quantity of the column.
    """
    present = [value for value in values if is_there(value)]
    if not present:
        return None
    if summary.take is None:
        value = present[0]
        return value if isinstance(value, str) else float(np.float64(value))  # type: ignore[arg-type]
    if summary.take == "share":
        return sum(str(value) in summary.of for value in present) / len(values)
    if any(isinstance(value, str) for value in present):
        raise ValueError(f'take = "{summary.take}" of {column}, whose values are words: expected "share"')
    numbers = np.array(present, dtype=float)
    match summary.take:
        case "share_below":
            return float(np.sum(np.abs(numbers) < level_of(summary, column))) / len(values)
        case "quantile":
            return float(np.quantile(numbers, si(summary.level, "1")))
        case "standard_deviation":
            return float(np.std(numbers, ddof=1)) if len(numbers) > 1 else None
        case "mean":
            return float(np.mean(numbers))
        case "median":
            return float(np.median(numbers))
        case "minimum":
            return float(np.min(numbers))
        case "maximum":
            return float(np.max(numbers))


def level_of(summary: Summary, column: str) -> float:
    """The level of a share as a column's values are stored: some are in degrees, or in rpm.

    Raises:
        QuantityError: a level that is no quantity of the column.
    """
    unit, level = unit_of_column(column), summary.level
    if unit == "1" or not isinstance(level, str):
        return si(level, unit)
    return si(level, unit) / si(f"1 {unit}", unit)


def in_words(summary: Summary, column: str) -> str:
    """What is taken, as a note says it."""
    if summary.take == "share":
        return f"share of {' or '.join(summary.of)}"
    if summary.take == "quantile":
        return f"{100.0 * si(summary.level, '1'):g} % quantile"
    if summary.take == "share_below":
        unit, level = unit_of_column(column), summary.level
        return f"share of magnitudes below {level if isinstance(level, str) else f'{level:g} {unit}'}"
    return TAKES[str(summary.take)]


def is_there(value: object) -> bool:
    """Whether a case has a value in a column."""
    return value is not None and value == value


def count_of(values: Sequence[object], summary: Summary) -> tuple[int, int]:
    """Of how many of these cases something is taken, and how many they are."""
    own = len(values) if summary.take in SHARES else sum(map(is_there, values))
    return own, len(values)


def counted(counts: Sequence[tuple[int, int]]) -> str:
    """Of how many cases figures are taken, in words: "20 cases", or "5 to 18 of 20 cases" where some have none."""
    own, every = ([count[i] for count in counts] for i in (0, 1))
    all_of_them = f"{_span(every)} case{'' if {*every} == {1} else 's'}"
    return all_of_them if own == every else f"{_span(own)} of {all_of_them}"


def _span(counts: Sequence[int]) -> str:
    return " to ".join(map(str, dict.fromkeys((min(counts, default=0), max(counts, default=0)))))
