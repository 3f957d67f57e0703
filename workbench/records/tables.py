"""Files of records: a table out of a file of any format, and its columns in SI."""

import math
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from plants.plugins import reason_of
from workbench.errors import UserError, nearest
from workbench.records.channels import ChannelSpec
from workbench.records.formats.registry import format_of
from workbench.toml.reading import check_regular

LARGEST = 1e30
"""What no channel measures, in whatever unit."""


LONGEST_DATE = 80
"""Characters of a date or a time of day; what looks for one in more takes very long."""


def read_table(path: Path) -> pd.DataFrame:
    """The table in a file, as it stands there.

    Raises:
        UserError: no such file, or no table.
    """
    if not path.exists():
        raise UserError(f"{path}: no such file; make the records first, or correct `file` of [[records]]")
    check_regular(path)
    if path.stat().st_size == 0:
        raise UserError(f"{path}: the file is empty; was the run that writes it stopped? Make the records again")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of libraries, about what of a file they leave out: the columns tell
            return format_of(path).read(path)
    except UserError:
        raise
    except Exception as error:  # noqa: BLE001 - of a damaged file the libraries raise anything
        raise UserError(f"{path}: cannot be read as a table ({reason_of(error)})") from None


def numbers_of(column: "pd.Series[Any]") -> np.ndarray:
    """The numbers in a column; NaN in the place of what is none, infinity of a whole number that no float can hold."""
    try:
        return pd.to_numeric(column, errors="coerce").to_numpy(dtype=float)
    except OverflowError:
        return np.array([_number(value) for value in column])


def _number(value: Any) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf
    except (TypeError, ValueError):
        return math.nan


def read_column(path: Path, table: pd.DataFrame, name: str, channel: ChannelSpec) -> np.ndarray:
    """A channel in SI; text that is no number becomes NaN.

    Raises:
        UserError: no such column, or no numbers in it.
    """
    column = table.iloc[:, _place(path, table, name, channel)]
    numbers = numbers_of(column)
    if name == "time" and (column.dtype.kind in "mM" or not np.any(np.isfinite(numbers))):
        channel, numbers = replace(channel, factor=1.0), seconds(column)
    if not np.any(np.isfinite(numbers)):
        raise UserError(f'{path}: column "{channel.column}" ({name}) holds no numbers')
    if (largest := float(np.max(np.abs(numbers[np.isfinite(numbers)])))) > LARGEST:
        raise UserError(
            f'{path}: column "{channel.column}" ({name}) reaches {largest:.3g}, expected at most {LARGEST:g}'
        )
    return numbers * channel.factor + channel.offset


def seconds(column: "pd.Series[Any]") -> np.ndarray:
    """Seconds from the first of a column's dates or times of day; NaN where there is none."""
    if column.dtype.kind not in "mM":
        column = column.where(column.astype(str).str.len() <= LONGEST_DATE)
    with warnings.catch_warnings(), np.errstate(invalid="ignore"):
        warnings.simplefilter("ignore", UserWarning)  # of dates whose order of day and month is a guess
        stamps = (
            column if column.dtype.kind in "mM" else pd.to_datetime(column, errors="coerce", format="mixed", utc=True)
        )
    if isinstance(stamps.dtype, pd.DatetimeTZDtype):
        stamps = stamps.dt.tz_convert(None)
    if not stamps.notna().any():
        stamps = pd.to_timedelta(column.astype(str), errors="coerce")
    values = stamps.to_numpy()
    ticks = values.astype(f"{values.dtype.kind}8[ns]").astype(np.int64)
    known = stamps.notna().to_numpy()
    first = int(ticks[known][0]) if known.any() else 0
    return np.where(known, 1e-9 * (ticks - first), np.nan)


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
    hint = nearest(channel.column, headers, with_others=True)  # the nearest may be another channel's
    raise UserError(f'{path}: no column "{channel.column}" for {name}; {hint}')
