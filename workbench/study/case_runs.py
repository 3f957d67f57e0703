"""A case of a study, run: its row of results, and the files that it leaves."""

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from workbench.errors import MetricError
from workbench.metrics.evaluate import rms_error
from workbench.metrics.registry import SOLVER, names_along
from workbench.parallel.chunks import enough
from workbench.simulation.run import Run
from workbench.simulation.simulate import finer, largest_distance, ready, simulate
from workbench.study.cases import Cases
from workbench.study.plan import Plan, needed_trajectories
from workbench.study.probes import probe_values
from workbench.study.resolve import Resolved
from workbench.study.run_on import evaluated
from workbench.study.sketches import is_sketched, points_for, sketch_of, sketched
from workbench.study.store import RECORDS, Row, record_path, trajectory_path, write_record, write_trajectory
from workbench.study.study import Case, Study

TOGETHER = 16
"""Cases that are built, then simulated, then judged: of more the signals no longer stay in a processor's cache."""

SIMULATED, BEGUN = 0.3, 0.5
"""Shares of a chunk's time after which none of those is simulated any more, since its error and its row take as long
again each, and after which no others are begun."""


@dataclass(frozen=True)
class CaseRuns:
    """The work of a study: what a case is run for, and where its files go. It can travel to another process.

    Attributes:
        study: the study.
        cases: all its cases.
        resolved: what they run.
        columns: of its results.
        folder: of its results, absolute.
        trajectories: indices of the cases whose trajectories are kept; None: all.
        points: of the sketch of a trajectory.
    """

    study: Study
    cases: Cases
    resolved: Sequence[Resolved]
    columns: Sequence[str]
    folder: Path
    trajectories: frozenset[int] | None = frozenset()
    points: int = 0

    def __call__(self, indices: Sequence[int]) -> list[Row]:
        """Run cases: a row of results each, as many as take about a chunk's time. Trajectories, and what a rig would
        write down, go to files of their own.

        Some go through each step together: a processor does much alike faster than a little of each.

        Raises:
            MetricError: a metric of a plug-in fails.
            UserError: a mistake in a case that was not among those checked before.
        """
        began, rows = time.perf_counter(), list[Row]()
        while True:
            rows += self._together(indices[len(rows) : len(rows) + TOGETHER], began)
            if len(rows) == len(indices) or enough(began, BEGUN):
                return rows

    def _together(self, indices: Sequence[int], chunk_began: float) -> list[Row]:
        """Rows of as many of these cases as are simulated in a share of a chunk's time, and at least of the first; no
        further ones where the chunk, which began then, has taken its time: a row may take far longer than its run, as
        of a loop that is held until it tells whether it hunts.
        """
        built = [(self.cases[index], self.resolved[index]) for index in indices]
        began, runs = time.perf_counter(), list[Run]()
        while len(runs) < len(built) and not (runs and enough(began, SIMULATED)):
            runs.append(simulate(built[len(runs)][1].setup))
        simulated = built[: len(runs)]
        others = [
            finer(resolved.setup, run) if case.tells_solver_error else None
            for (case, resolved), run in zip(simulated, runs, strict=True)
        ]
        rows = list[Row]()
        for each, run, other in zip(simulated, runs, others, strict=True):
            rows.append(self._row(*each, run, other))
            if enough(chunk_began):
                break
        return rows

    def _row(self, case: Case, resolved: Resolved, run: Run, other: Run | None) -> Row:
        try:
            figures = figures_of(resolved, run, other)
        except MetricError as error:
            raise MetricError(f"{case.label}: {error}") from error.__cause__
        values: dict[str, object] = {**case.columns, **figures}
        values |= probe_values(run, self.study.file.probes, resolved.transient, case.name)
        sketch = sketch_of(run, self.points) if is_sketched(self.cases, case.index) else None
        for path in self.files(case):
            if path.parent.name == RECORDS:
                write_record(run, self.study.file.records, case.rpm, path)
            else:
                write_trajectory(run, path)
        return Row(case.index, [_storable(values.get(column)) for column in self.columns], sketch)

    def files(self, case: Case) -> list[Path]:
        """The files that a case leaves beside its row."""
        kept = self.trajectories is None or case.index in self.trajectories
        trajectory = [trajectory_path(self.folder, case.index)] if kept else []
        return trajectory + ([record_path(self.folder, case)] if self.study.file.records else [])

    @property
    def file_count(self) -> int:
        """How many files all cases leave."""
        kept = len(self.cases) if self.trajectories is None else len(self.trajectories)
        return kept + (len(self.cases) if self.study.file.records else 0)

    def unwritten(self) -> set[int]:
        """Indices of the cases of which a file is missing."""
        some = range(len(self.cases)) if self.trajectories is None or self.study.file.records else self.trajectories
        return {index for index in some if not all(path.exists() for path in self.files(self.cases[index]))}


def case_runs(planned: Plan, folder: Path, *, keep_all: bool = False) -> CaseRuns:
    """The work of a plan, with the trajectories that its figures need, or all."""
    kept = None if keep_all else frozenset(needed_trajectories(planned))
    points = points_for(sketched(planned.cases))
    return CaseRuns(planned.study, planned.cases, planned.resolved, planned.columns, folder.resolve(), kept, points)


def compiled(planned: Plan) -> None:
    """Have all compiled code of a plan at hand, before processes are made that would each compile it."""
    for item in planned.declared:
        ready(item.setup)


def _storable(value: object) -> object:
    """A value as SQLite keeps it; a list or a table of a dotted axis as JSON."""
    return json.dumps(value) if isinstance(value, list | dict) else value


def figures_of(resolved: Resolved, run: Run, other: Run | None = None) -> dict[str, float | str | None]:
    """All of the `columns` of a case's run, in their order; None where a figure does not apply, those of `SOLVER` where
    there is no `other` run of it, a `finer` one.
    """
    figures = evaluated(resolved, run)
    rms = figures["rms_error_m"]
    errors = {} if other is None else _solver_errors(resolved, run, other, rms if isinstance(rms, float) else None)
    whole = {**figures, **dict.fromkeys(column.name for column in SOLVER), **errors}
    called = names_along(run.plant.axis)
    return {called[name]: value for name, value in whole.items()}


def _solver_errors(resolved: Resolved, run: Run, other: Run, rms: float | None) -> dict[str, float | None]:
    """What a finer integration changes: positions at most, and the rms error where there is one."""
    known = rms_error(other, resolved.signal, resolved.transient)
    change = abs(known - rms) if known is not None and rms is not None else None
    return dict(zip((column.name for column in SOLVER), (largest_distance(run, other), change), strict=True))
