"""Tuning of a study's controllers: search, polish, and what is left of it on machines that the search has not seen."""

import json
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from optuna.trial import FrozenTrial
from scipy.stats import binom

from plants.equation import source_hash
from workbench.errors import UserError, nearest
from workbench.study.document import Study
from workbench.study.runner import PROGRAM_FOLDERS
from workbench.study.tune_schema import TuneTable
from workbench.tune.bench import FRESH, SEARCHED, Bench
from workbench.tune.goal import Goal, Score, quantile, run
from workbench.tune.search import is_candidate, search, trials_in
from workbench.tune.space import Point
from workbench.tune.task import Task, cases_for, task_for, tune_table

SURE = 0.95
"""Of the interval of a quantile."""

Tell = Callable[[str, int, int], None]
"""Is told what is being done, and how many of how many trials are finished."""


@dataclass(frozen=True)
class Quantile:
    """A quantile over draws, with the interval in which that of all machines is; `high` is infinite where so few draws
    do not bound it.
    """

    value: float
    low: float
    high: float
    draws: int


@dataclass(frozen=True, eq=False)
class Tuned:
    """What became of one controller. `best` is None where no trial keeps the constraints.

    `trials` are all of them, in order; `number` is that of the best, `polished` what a local descent from it gained (as
    a share), or why there was none. `on_searched` and `on_fresh` hold the quantiles of `start` (the study's gains) and of
    the best.
    """

    task: Task
    trials: Sequence[FrozenTrial]
    start: Score
    best: Point | None
    score: Score | None
    number: int
    polished: str
    on_searched: Mapping[str, Quantile]
    on_fresh: Mapping[str, Quantile]


def interval(values: Sequence[float], share: float) -> Quantile:
    """A quantile of draws, and its interval by order statistics: free of any assumption of their distribution.

    The number of draws below the true quantile is binomial; the interval's ends are the draws of the ranks between
    which it is with a probability of at least `SURE`.
    """
    ordered, count = sorted(values), len(values)
    low = int(binom.ppf(0.5 * (1.0 - SURE), count, share))
    high = int(binom.ppf(0.5 * (1.0 + SURE), count, share)) + 1
    return Quantile(
        quantile(values, share),
        ordered[low - 1] if low >= 1 else 0.0,
        ordered[high - 1] if high <= count else float("inf"),
        count,
    )


def identity_of(study: Study, table: TuneTable) -> str:
    """What stored trials must agree in: study, [tune] without the number of trials, draws, code."""
    uncertainty = study.file.uncertainty
    return json.dumps(
        {
            "study": study.fingerprint,
            "tune": table.model_dump(mode="json", exclude={"trials", "fresh_draws", "polish"}),
            "uncertainty": None if uncertainty is None else uncertainty.model_dump(mode="json"),
            "program": source_hash((*PROGRAM_FOLDERS, "workbench/tune")),
        },
        sort_keys=True,
    )


def chosen(study: Study, name: str) -> list[str]:
    """The controllers that a name stands for: one, or all.

    Raises:
        UserError: there is none of that name.
    """
    known = list(study.file.controllers)
    if name == "all":
        return known
    if name not in known:
        raise UserError(f'--controller "{name}": {nearest(name, ["all", *known])}')
    return [name]


def goal_of(study: Study, executor: Executor) -> Goal:
    """The goal of a study, in units of its yardstick.

    Raises:
        UserError: no such yardstick, or a figure that it does not have.
    """
    table = tune_table(study)
    name = table.yardstick or next(iter(study.file.controllers))
    if name not in study.file.controllers:
        raise study.error(("tune", "yardstick"), f'unknown controller "{name}"; {nearest(name, study.file.controllers)}')
    from workbench.study.resolve import resolve

    cases = [resolve(study, case) for case in cases_for(study, table, name)]
    columns = tuple(table.objective.used)
    return Goal(table, list(executor.map(lambda case: run(case, columns), cases)))
