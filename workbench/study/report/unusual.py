"""Which cases did not simply complete, in words: their figures are not what the axes say."""

import pandas as pd

from plants.axis import AXES
from workbench.metrics.registry import SOLVER
from workbench.simulation.run import COMPLETED
from workbench.study.names import in_words
from workbench.study.report.select import axes_of

SOLVER_ERRORS = tuple(SOLVER[0].along(axis).name for axis in AXES)
"""The column of the solver's error, of axes that go straight and of those that turn."""

NAMED = 3
"""Cases of one outcome that are named, at most."""


def unusual(frame: pd.DataFrame, whole: pd.DataFrame) -> list[str]:
    """A line for each outcome of cases of `frame` other than "completed", with those cases.

    A case is named by the axes along which the cases of `whole`, all results, differ.
    """
    names = axes_of(whole.columns)
    axes = [name for name in names if whole[name].nunique(dropna=False) > 1]
    lines = []
    for outcome, rows in frame[frame["outcome"] != COMPLETED].groupby("outcome", sort=False):
        cases = rows[axes].head(NAMED).to_dict("records")
        named = [in_words({str(name): _shown(case[name]) for name in axes if pd.notna(case[name])}) for case in cases]
        more = [f"{len(rows) - NAMED} more"] if len(rows) > NAMED else []
        which = f" ({'; '.join([*named, *more])})" if len(rows) < len(frame) else ""
        lines.append(f"{len(rows)} of {len(frame)} case{'s' * (len(frame) > 1)}: {outcome}{which}")
    solver = next((name for name in SOLVER_ERRORS if name in frame), None)
    unchecked = (frame["outcome"] == COMPLETED) & frame[solver].isna() if solver is not None else None
    if unchecked is not None and "draw" in frame:
        unchecked &= frame["draw"] == frame["draw"].min()  # on the others nobody looks
    if unchecked is not None and (number := int(unchecked.sum())):
        lines.append(
            f"{number} of {len(frame)} case{'s' * (len(frame) > 1)}: no solver error, a finer integration ends early"
        )
    return lines


def _shown(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
