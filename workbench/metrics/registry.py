"""The metrics by name, in the order of their columns: ours, and those that other packages bring by entry point."""

import functools
from collections.abc import Collection, Mapping, Sequence
from typing import get_args

from plants.axis import LINEAR, ROTARY
from plants.plugins import Registry
from workbench.metrics.groups import COST, ERRORS, FRICTION, LAG, LIMIT_CYCLE, SETTLING, STEADY_STATE
from workbench.metrics.interface import Column, Metric, ending
from workbench.metrics.verdicts import Verdict
from workbench.simulation.run import OUTCOMES

_OURS = (LAG, STEADY_STATE, ERRORS, SETTLING, LIMIT_CYCLE, COST, FRICTION)

OUTCOME = Column("outcome", "1", "the run in words; one that diverged has no other figure")

WORDS: Mapping[str, Sequence[str]] = {OUTCOME.name: OUTCOMES, "limit_cycle": get_args(Verdict)}
"""Columns of ours that hold words, and which they are."""

SOLVER = (
    Column(
        "solver_error_m", "m", "largest distance of the positions from a finer integration; the study runner adds it"
    ),
    Column(
        "solver_rms_error_m",
        "m",
        "by how much the finer integration changes rms_error_m; the study runner adds it. Where a "
        "loop sticks and slips irregularly the positions part, and the figure hardly does",
    ),
)
"""Those that take a second run, which the study runner makes."""

_TAKEN = {column.name for column in (OUTCOME, *(column for metric in _OURS for column in metric.columns), *SOLVER)}


def _check(metric: Metric) -> None:
    for column in metric.columns:
        if column.unit != "1" and not column.name.endswith(f"_{ending(column.unit)}"):
            raise TypeError(f'column "{column.name}": expected a name that ends in its unit, _{ending(column.unit)}')
        if column.name in _TAKEN:
            raise TypeError(f'column "{column.name}": there is one of this name; expected another')


METRICS = Registry("friction_workbench.metrics", Metric, {metric.name: metric for metric in _OURS}, _check)


def columns(axis: str = LINEAR) -> dict[str, Column]:
    """The columns of results.csv behind the study's axes, by name, in their order, of plants along that axis.

    Metrics find them under the names that they have on a straight one.
    """
    return dict(_columns(tuple(METRICS.working().values()), axis))


@functools.cache
def _columns(metrics: tuple[Metric, ...], axis: str) -> Mapping[str, Column]:
    found = [column for metric in metrics for column in metric.columns]
    return {column.name: column for column in (item.along(axis) for item in (OUTCOME, *found, *SOLVER))}


def names_along(axis: str) -> dict[str, str]:
    """What columns are called along an axis, by their names on a straight one."""
    return dict(zip(columns(), columns(axis), strict=True))


def axis_of(found: Collection[str]) -> str:
    """The axis of results that have these columns."""
    return ROTARY if SOLVER[0].along(ROTARY).name in found else LINEAR
