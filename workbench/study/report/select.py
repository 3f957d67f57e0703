"""Picking rows of the results, and the trajectories that belong to them."""

from collections.abc import Collection, Iterable, Mapping
from itertools import takewhile
from pathlib import Path

import numpy as np
import pandas as pd

from workbench.errors import UserError, few_of, nearest
from workbench.metrics.registry import names_along
from workbench.study.names import comparable, in_words
from workbench.study.store import trajectory_path

OUTCOME = "outcome"
"""The first column of results behind those that tell the cases apart."""


CYCLE = ("limit_cycle", "limit_cycle_amplitude_m", "limit_cycle_period_s")
"""What a cycle is called, and its size and period, as they are named along an axis that goes straight."""


def axes_of(columns: Iterable[object]) -> list[str]:
    """Those columns of results that tell the cases apart."""
    return list(takewhile(lambda name: name != OUTCOME, map(str, columns)))


def with_cycles(frame: pd.DataFrame, axis: str) -> pd.DataFrame:
    """The cases of plants along an axis that hold a limit cycle whose size is known."""
    size = names_along(axis)["limit_cycle_amplitude_m"]
    return frame[frame["limit_cycle"].isin(["sustained", "decaying", "too_short"])].dropna(subset=size)


def rows(frame: pd.DataFrame, where: Mapping[str, object]) -> pd.DataFrame:
    """The rows whose axes have the values in `where`.

    Raises:
        UserError: no such axis.
    """
    return frame[which(frame, where)]


def which(frame: pd.DataFrame, where: Mapping[str, object]) -> np.ndarray:
    """Whether each row is one of them.

    Raises:
        UserError: no such axis.
    """
    for key in where:
        if key not in frame.columns:
            raise UserError(f'the results have no column "{key}"; {nearest(key, map(str, frame.columns))}')
    keep = np.ones(len(frame), dtype=bool)
    for key, value in where.items():
        keep &= _equal(frame[key], comparable(value))
    return keep


def _equal(column: pd.Series, asked: float | str) -> np.ndarray:
    """Which values of a column compare equal with what is asked for; each value is looked at once, however many rows
    have it.
    """
    found = [value for value in column.unique() if comparable(value) == asked]
    return column.isin(found).to_numpy()


def one_row(frame: pd.DataFrame, where: Mapping[str, object], purpose: str) -> pd.Series:
    """The single row that `where` picks.

    Raises:
        UserError: none, or more than one.
    """
    return alike(frame, where, (), purpose).iloc[0]


def alike(frame: pd.DataFrame, where: Mapping[str, object], over: Collection[str], purpose: str) -> pd.DataFrame:
    """The rows that `where` picks, which only the axes in `over` tell apart: without any a single one, else perhaps
    none, where it asks for what is known afterwards.

    Raises:
        UserError: none, or others too.
    """
    found = rows(frame, where)
    apart = [name for name in axes_of(frame.columns) if name not in over and found[name].nunique(dropna=False) > 1]
    known_before = {*where} <= {*axes_of(frame.columns)}
    if apart or (len(found) != 1 and not over) or (found.empty and known_before):
        number = f"{len(found) or 'no'} case{'s' * (len(found) > 1)}"
        wanted = f"expected those of one {', '.join(apart)}" if over and apart else "expected one"
        raise UserError(f"{purpose}: {number} for {in_words(where) or 'no condition'}, {wanted}")
    return found


def _axes(row: pd.Series) -> dict[str, object]:
    """The values of a row's axes."""
    return {name: row[name] for name in axes_of(row.index) if pd.notna(row[name])}


def trajectory(folder: Path, frame: pd.DataFrame, where: Mapping[str, object], purpose: str) -> pd.DataFrame:
    """The trajectory of the single case that `where` picks.

    Raises:
        UserError: not one case, or its trajectory was not kept.
    """
    index = int(str(one_row(frame, where, purpose).name))
    path = trajectory_path(folder, index)
    if not path.exists():
        kept = [in_words(_axes(row)) for i, row in frame.iterrows() if trajectory_path(folder, int(str(i))).exists()]
        raise UserError(
            f"{purpose}: the trajectory of {in_words(where) or 'that case'} was not kept "
            f"(kept: {few_of(kept) or 'none'}); run with --keep-trajectories for all"
        )
    return pd.read_parquet(path)


def columns_of(frame: pd.DataFrame, columns: list[str], where: Mapping[str, object]) -> pd.DataFrame:
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
        raise UserError(f"no case has {in_words(where)}")
    return found[[*axes_of(names), *columns]] if columns else found
