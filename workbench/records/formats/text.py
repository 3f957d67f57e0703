"""CSV, or any other text with a row a sample."""

import re
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.records.formats.interface import RecordFormat

if TYPE_CHECKING:
    import pandas as pd

LINES_LOOKED_AT = 100
"""Of a CSV file, to see whether its numbers have a decimal comma."""

DECIMAL_COMMA, DECIMAL_POINT = (re.compile(rf"[+-]?\d*{mark}\d+([eE][+-]?\d+)?") for mark in (",", r"\."))


def read(path: Path) -> "pd.DataFrame":
    """A text file of any separator, also compressed (.gz); a first row of numbers alone is no header, but data."""
    import pandas as pd

    if path.suffix != ".gz" and (separator := _european(path)):
        return pd.read_csv(path, sep=separator, decimal=",", skipinitialspace=True)
    first = pd.read_csv(path, sep=None, engine="python", skipinitialspace=True, header=None, nrows=1).iloc[0]
    header = None if pd.to_numeric(first, errors="coerce").notna().all() else 0
    return pd.read_csv(path, sep=None, engine="python", skipinitialspace=True, header=header)


def _european(path: Path) -> str:
    """The separator of a CSV file whose numbers have a decimal comma; empty for any other."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        lines = [line.rstrip("\r\n") for line, _ in zip(file, range(LINES_LOOKED_AT), strict=False) if line.strip()]
    for separator in (";", "\t"):
        rows = [line.split(separator) for line in lines[1:]]
        fields = [field.strip() for row in rows for field in row]
        if not lines or separator not in lines[0] or any(DECIMAL_POINT.fullmatch(field) for field in fields):
            continue
        if any(DECIMAL_COMMA.fullmatch(field) for field in fields):
            return separator
    return ""


TEXT = RecordFormat(
    "text", "CSV or other text of any separator, with a header or without; .gz too", (".csv", ".txt", ".gz"), read
)
