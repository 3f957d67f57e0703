"""Files of records: a table out of CSV or any other text, Parquet or MAT, and its columns in SI."""

import csv
import re
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.io import loadmat

from workbench.errors import UserError, nearest
from workbench.records.experiment import ChannelSpec

LINES_LOOKED_AT = 100
"""Of a CSV file, to see whether its numbers have a decimal comma."""

DECIMAL_COMMA, DECIMAL_POINT = (re.compile(rf"[+-]?\d*{mark}\d+([eE][+-]?\d+)?") for mark in (",", r"\."))


def read_table(path: Path) -> pd.DataFrame:
    """The table in a file, as it stands there.

    Raises:
        UserError: no such file, or no table.
    """
    if not path.exists():
        raise UserError(f"{path}: no such file; make the records first, or correct `file` of [[records]]")
    try:
        if path.suffix == ".parquet":
            return pd.read_parquet(path)
        if path.suffix == ".mat":
            return _mat(path)
        return _text(path)
    except (OSError, EOFError, ValueError, csv.Error, NotImplementedError) as error:
        raise UserError(f"{path}: cannot be read as a table ({' '.join(str(error).split())})") from None


def _text(path: Path) -> pd.DataFrame:
    """A text file of any separator, also compressed (.gz); a first row of numbers alone is no header, but data."""
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


def _mat(path: Path) -> pd.DataFrame:
    """All vectors of a MAT file (to version 7.2) that are as long as its longest."""
    content = {name: np.ravel(value) for name, value in loadmat(path).items() if not name.startswith("__")}
    numeric = {name: value for name, value in content.items() if value.dtype.kind in "iuf" and value.size > 1}
    longest = max((value.size for value in numeric.values()), default=0)
    return pd.DataFrame({name: value for name, value in numeric.items() if value.size == longest})


def read_column(path: Path, table: pd.DataFrame, name: str, channel: ChannelSpec) -> np.ndarray:
    """A channel in SI; text that is no number becomes NaN.

    Raises:
        UserError: no such column, or no numbers in it.
    """
    numbers = pd.to_numeric(table.iloc[:, _place(path, table, name, channel)], errors="coerce").to_numpy(dtype=float)
    if not np.any(np.isfinite(numbers)):
        raise UserError(f'{path}: column "{channel.column}" ({name}) holds no numbers')
    return numbers * channel.factor + channel.offset


def _place(path: Path, table: pd.DataFrame, name: str, channel: ChannelSpec) -> int:
    """The number, from 0, of a channel's column."""
    count = table.shape[1]
    if isinstance(channel.column, int):
        if channel.column >= count:
            raise UserError(
                f"{path}: no column {channel.column} for {name}: it has {count} columns, and they count from 0 to "
                f"{count - 1}"
            )
        return channel.column
    headers = [str(column).strip() for column in table.columns]
    if channel.column in headers:
        return headers.index(channel.column)
    if not any(isinstance(column, str) for column in table.columns):
        raise UserError(
            f'{path}: no column "{channel.column}" for {name}: the file has no header; give the number of the column '
            f"from 0 to {count - 1}, such as column = 0"
        )
    raise UserError(f'{path}: no column "{channel.column}" for {name}; {nearest(channel.column, headers)}')
