"""[[break_even]]: where along an axis something costs less than at the axis' first value."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import Field

from workbench.study.sections import Checked, Section
from workbench.study.study import Study, check_name
from workbench.toml.file_names import FileName
from workbench.toml.reading import Strict

if TYPE_CHECKING:
    import pandas as pd


class Account(Strict):
    """One way to count: the sum of columns of the results."""

    label: str
    """What this way to count is called."""
    columns: list[str] = Field(min_length=1)
    """Of the results, added up."""


class BreakEvenTable(Strict):
    """[[break_even]]: where along the axis the sum of some columns is less than at its first value, by each account."""

    name: FileName
    """Of its files."""
    title: str
    """Above it."""
    axis: str = "rpm"
    """Along which something is less than at the first value."""
    where: dict[str, Any] = {}
    """Picks its cases."""
    accounts: list[Account] = Field(min_length=1)
    """Ways to count."""
    note: str = ""
    """Below it."""


def _check(even: BreakEvenTable, checked: Checked) -> None:
    study, key = checked.study, checked.key
    check_name(study, (*key, "axis"), "axis", even.axis, checked.axes)
    checked.chosen(key, even.where)
    for i, account in enumerate(even.accounts):
        for j, name in enumerate(account.columns):
            check_name(study, (*key, "accounts", i, "columns", j), "figure", name, checked.figures)


def _tables(even: BreakEvenTable, study: Study, frame: "pd.DataFrame", folder: Path) -> list[Path]:
    from workbench.study.report.break_even_table import write_break_even  # whoever checks does without pandas

    return [write_break_even(even, frame, folder / "tables")]


BREAK_EVEN = Section(name="break_even", table=BreakEvenTable, several=True, check=_check, tables=_tables)
