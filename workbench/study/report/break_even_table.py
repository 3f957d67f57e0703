"""Where along an axis something costs less than at the axis' first value, by each account of it."""

from pathlib import Path

import pandas as pd

from workbench.errors import UserError
from workbench.publish.tables import Table, shown_number, with_unit, write_frame
from workbench.study.names import in_words, unit_of_column
from workbench.study.report.break_even import BreakEvenTable
from workbench.study.report.select import rows

DIGITS = 4

WORTH = 1e-3
"""Share by which something has to be less to count: beneath it the account does not tell the two apart."""


def write_break_even(spec: BreakEvenTable, frame: pd.DataFrame, folder: Path) -> Path:
    """Write the table to `folder`; returns its Markdown."""
    notes = [*([spec.note] if spec.note else []), f"Less: by at least {100.0 * WORTH:g} %."]
    return write_frame(spec.name, Table(spec.title, break_even_table(spec, frame), notes), folder)[1]


def break_even_table(spec: BreakEvenTable, frame: pd.DataFrame) -> pd.DataFrame:
    """account | at the axis' first value | least beyond it, and where | where it is less; as text.

    Raises:
        UserError: several cases at one value of the axis, or accounts of different units.
    """
    found = rows(frame, spec.where)
    if found[spec.axis].duplicated().any():
        raise UserError(f"break_even {spec.name}: several cases at one {spec.axis} for {in_words(spec.where)}")
    lines = []
    for account in spec.accounts:
        units = {unit_of_column(name) for name in account.columns}
        if len(units) > 1:
            raise UserError(f'break_even {spec.name}: account "{account.label}" adds {" and ".join(sorted(units))}')
        total = found[account.columns].fillna(0.0).sum(axis=1)
        first, *others = zip(found[spec.axis], total, strict=True)
        least = min(others, key=lambda pair: pair[1])
        paying = [f"{value:g}" for value, cost in others if cost < (1.0 - WORTH) * first[1]]
        unit = units.pop()
        lines.append(
            {
                "account": account.label,
                with_unit(f"at {spec.axis} {first[0]:g}", unit): shown_number(first[1], DIGITS),
                with_unit("least beyond", unit): shown_number(least[1], DIGITS),
                f"at {spec.axis}": f"{least[0]:g}",
                "change (%)": f"{100.0 * (least[1] / first[1] - 1.0):+.1f}",
                f"less at {spec.axis}": ", ".join(paying) or "none",
            }
        )
    return pd.DataFrame(lines)
