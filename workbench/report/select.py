"""Picking rows of the results, and the trajectories that belong to them."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from workbench.errors import UserError, nearest
from workbench.study.runner import matches
from workbench.study.store import trajectory_path

BASE_UNITS = {
    "deg": "deg",
    "m": "m",
    "s": "s",
    "W": "W",
    "V": "V",
    "J": "J",
    "N": "N",
    "N_s_per_m": "N s/m",
    "m_per_s": "m/s",
    "m_per_s3": "m/s^3",
    "rpm": "rpm",
}
"""Units of the results by the ending of a column's name."""


def unit_of_column(column: str) -> str:
    """The unit that the name of a result column ends in, "1" if none."""
    for ending in sorted(BASE_UNITS, key=len, reverse=True):
        if column == ending or column.endswith(f"_{ending}"):
            return BASE_UNITS[ending]
    return "1"


def rows(frame: pd.DataFrame, where: Mapping[str, Any]) -> pd.DataFrame:
    """The rows whose axes have the values in `where`.

    Raises:
        UserError: no such axis.
    """
    for key in where:
        if key not in frame.columns:
            raise UserError(f'the results have no column "{key}"; {nearest(key, map(str, frame.columns))}')
    keep = [matches({str(k): v for k, v in row.items()}, where) for row in frame.to_dict("records")]
    return frame[keep]


def one_row(frame: pd.DataFrame, where: Mapping[str, Any], purpose: str) -> pd.Series:
    """The single row that `where` picks.

    Raises:
        UserError: none, or more than one.
    """
    found = rows(frame, where)
    if len(found) != 1:
        raise UserError(f"{purpose}: {len(found)} cases match {dict(where) or 'no condition'}, expected one")
    return found.iloc[0]


def trajectory(folder: Path, frame: pd.DataFrame, where: Mapping[str, Any], purpose: str) -> pd.DataFrame:
    """The trajectory of the single case that `where` picks.

    Raises:
        UserError: not one case, or its trajectory was not kept.
    """
    index = int(str(one_row(frame, where, purpose).name))
    path = trajectory_path(folder, index)
    if not path.exists():
        raise UserError(f"{purpose}: the trajectory of that case was not kept; run with --keep-trajectories")
    return pd.read_parquet(path)


def columns_of(frame: pd.DataFrame, columns: list[str], where: Mapping[str, Any]) -> pd.DataFrame:
    """Axes and the chosen columns (all where none is chosen) of the cases that `where` picks.

    Raises:
        UserError: no such column, or no such case.
    """
    names = [str(name) for name in frame.columns]
    for name in columns:
        if name not in names:
            raise UserError(f'the results have no column "{name}"; {nearest(name, names)}')
    found = rows(frame, where)
    if found.empty:
        raise UserError(f"no case has {', '.join(f'{key} {value}' for key, value in where.items())}")
    axes = names[: names.index("outcome")]
    return found[[*axes, *columns]] if columns else found
