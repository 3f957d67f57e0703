"""What a study would run, in words."""

from collections.abc import Sequence

from workbench.errors import few_of
from workbench.study.plan import Plan

MOST_VALUES, ENDS = 30, 3
"""Values of an axis that are all said, and how many of more are, at either end."""

LONGEST = 2000
"""Characters of the values of an axis that are told."""


def description(planned: Plan) -> list[str]:
    """Title, axes, number of cases and simulated time of a study, line by line."""
    file, count = planned.study.file, len(planned.cases)
    return [
        file.title + (f" ({file.source})" if file.source else ""),
        *(f"  {name}: {_said(values)}" for name, values in planned.cases.axes.items()),
        f"  {count} case{'s' * (count > 1)}, {planned.simulated_seconds:g} s of simulated time",
    ]


def _said(values: Sequence[object]) -> str:
    """The values of an axis, of many the first and the last."""
    words = [str(value) for value in values]
    if len(words) <= MOST_VALUES:
        return few_of(words, LONGEST)
    return f"{few_of(words[:ENDS])}, ... {few_of(words[-ENDS:])} ({len(words)} values)"
