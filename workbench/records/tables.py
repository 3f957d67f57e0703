"""Files of records: a table out of a file of any format, and its columns in SI."""

import csv
from pathlib import Path

import numpy as np
import pandas as pd

from workbench.errors import UserError, nearest
from workbench.records.channels import ChannelSpec
from workbench.records.formats.registry import format_of


def read_table(path: Path) -> pd.DataFrame:
    """The table in a file, as it stands there.

    Raises:
        UserError: no such file, or no table.
    """
    if not path.exists():
        raise UserError(f"{path}: no such file; make the records first, or correct `file` of [[records]]")
    if path.stat().st_size == 0:
        raise UserError(f"{path}: the file is empty; was the run that writes it stopped? Make the records again")
    try:
        return format_of(path).read(path)
    except (OSError, EOFError, ValueError, csv.Error, NotImplementedError) as error:
        raise UserError(f"{path}: cannot be read as a table ({' '.join(str(error).split())})") from None


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
