"""What a study would take, told from some of its cases that are run: time on this machine, and room on the disk."""

import itertools
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import nnls

from workbench.parallel.workers import job_count
from workbench.publish.tables import shown_number
from workbench.study.case_runs import case_runs, compiled
from workbench.study.plan import Plan
from workbench.study.sketches import sketched
from workbench.study.store import Row

DIGITS = 2
"""Of an estimate."""

SAMPLED = 24
"""Cases that are run, at most."""

LONGEST = 3.0
"""s after which no further one is begun."""

COPIES = 30.0
"""Bytes that a number takes, in SQLite, CSV and Parquet together; a text has its length in each of them."""


@dataclass(frozen=True)
class Estimate:
    """Time (s) and disk (bytes) that a study takes, told from so many of its cases."""

    seconds: float
    disk: float
    sampled: int

    def __str__(self) -> str:
        cases = "one case" if self.sampled == 1 else f"{self.sampled} cases"
        return f"about {in_words(self.seconds)} on this machine and {_size(self.disk)} on the disk, told from {cases}"


def estimate(planned: Plan, jobs: int | None = None, *, keep_all: bool = False, count: int | None = None) -> Estimate:
    """What running so many cases of a study (`count`; default all) takes with so many `jobs`: some, evenly among all,
    are run, and stand for all.

    What they leave is removed. Compiling is not counted: it is done once.
    """
    compiled(planned)
    count = count or len(planned.cases)
    with tempfile.TemporaryDirectory() as name:
        work = case_runs(planned, Path(name), keep_all=keep_all)
        took, rows, files, simulated = list[float](), list[Row](), list[int](), list[float]()
        for seconds, place in _sample(planned):
            simulated.append(seconds)
            began = time.perf_counter()
            rows += work([place])
            took.append(time.perf_counter() - began)
            if sum(took) > LONGEST:
                break
        for row in rows:
            files += [path.stat().st_size for path in work.files(planned.cases[row.case])]
        sketches = [len(row.sketch) for row in rows if row.sketch is not None]
    later, durations = took[1:] or took, simulated[1:] or simulated  # the first finds nothing in any cache
    each = _per_case(durations, later, planned.simulated_seconds / len(planned.cases))
    disk = count * sum(map(_bytes, rows)) / len(rows)
    share = count / len(planned.cases)
    disk += share * sketched(planned.cases) * sum(sketches) / max(len(sketches), 1)
    disk += share * work.file_count * sum(files) / max(len(files), 1)
    return Estimate(count * each / min(job_count(jobs), count), disk, len(rows))


def _sample(planned: Plan) -> list[tuple[float, int]]:
    """Duration (s) and place of some of the cases checked, the shortest first: with each duration, if these are few."""
    checked = {case.index: item.setup.duration for case, item in zip(planned.checked, planned.declared, strict=True)}
    first = {duration: place for place, duration in reversed(checked.items())}
    chosen = {*itertools.islice(first.values(), SAMPLED // 2)}
    chosen |= {*planned.cases.telling(SAMPLED - len(chosen))} & checked.keys()
    return sorted((checked[place], place) for place in chosen)


def _per_case(durations: Sequence[float], took: Sequence[float], mean: float) -> float:
    """What a case takes (s) on average whose mean duration is `mean` (s): a time of its own and one a simulated second,
    neither negative, by least squares over cases of these durations.
    """
    design = np.column_stack([np.ones(len(took)), durations])
    own, per_second = nnls(design, np.asarray(took))[0]
    return float(own + per_second * mean)


def _bytes(row: Row) -> float:
    """What a row takes, its sketch not counted."""
    found = [value for value in row.values if value is not None]
    return sum(3.0 * len(value) if isinstance(value, str) else COPIES for value in found)


def in_words(seconds: float) -> str:
    """A duration with two digits."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size:
            return f"{shown_number(seconds / size, DIGITS)} {unit}"
    return f"{shown_number(seconds, DIGITS)} s"


def _size(count: float) -> str:
    for unit, size in (("GB", 1e9), ("MB", 1e6)):
        if count >= size:
            return f"{shown_number(count / size, DIGITS)} {unit}"
    return f"{max(count / 1e3, 1.0):.0f} kB"
