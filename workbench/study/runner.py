"""Running a study: its cases in chunks, each chunk's results kept the moment they are there."""

import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

from workbench.errors import MetricError, UserError
from workbench.metrics.evaluate import rms_error
from workbench.metrics.registry import SOLVER, names_along
from workbench.parallel.chunks import KilledError, in_chunks
from workbench.publish.run_record import ran_on
from workbench.simulation.run import Run
from workbench.simulation.simulate import finer, largest_distance, ready, simulate
from workbench.study.plan import Plan, needed_trajectories
from workbench.study.probes import probe_values
from workbench.study.resolve import Resolved
from workbench.study.run_on import evaluated
from workbench.study.sketches import is_sketched, points_for, sketch_of, sketched
from workbench.study.store import (
    EXPORTS,
    RECORDS,
    Row,
    Store,
    export_frames,
    record_path,
    trajectory_path,
    write_json,
    write_record,
    write_study,
    write_trajectory,
)
from workbench.study.study import Case, Study, in_full
from workbench.study.unfold import Cases

Progress = Callable[[int, int, str], None]
"""Called with the number of finished cases, of all cases, and one that has just finished, in words."""


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

    def __call__(self, index: int) -> Row:
        """Run a case: its row of results. Its trajectory, and what a rig would write down, go to files of their own.

        Raises:
            MetricError: a metric of a plug-in fails.
            UserError: a mistake in a case that was not among those checked before.
        """
        case, resolved = self.cases[index], self.resolved[index]
        run = simulate(resolved.setup)
        try:
            figures = figures_of(resolved, run, solver_error=case.tells_solver_error)
        except MetricError as error:
            raise MetricError(f"{case.label}: {error}") from error.__cause__
        values: dict[str, object] = {**case.columns, **figures}
        values |= probe_values(run, self.study.file.probes, resolved.transient, case.name)
        sketch = sketch_of(run, self.points) if is_sketched(self.cases, index) else None
        for path in self.files(case):
            if path.parent.name == RECORDS:
                write_record(run, self.study.file.records, case.rpm, path)
            else:
                write_trajectory(run, path)
        return Row(index, [_storable(values.get(column)) for column in self.columns], sketch)

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


def figures_of(resolved: Resolved, run: Run, *, solver_error: bool = True) -> dict[str, float | str | None]:
    """All of the `columns` of a case's run, in their order; None where a figure does not apply.

    `solver_error`: whether those of `SOLVER` are found too, which takes a second, finer run.
    """
    figures = evaluated(resolved, run)
    rms = figures["rms_error_m"]
    errors = _solver_errors(resolved, run, rms if isinstance(rms, float) else None) if solver_error else {}
    whole = {**figures, **dict.fromkeys(column.name for column in SOLVER), **errors}
    called = names_along(run.plant.axis)
    return {called[name]: value for name, value in whole.items()}


def _solver_errors(resolved: Resolved, run: Run, rms: float | None) -> dict[str, float | None]:
    """What a finer integration changes: positions at most, and the rms error where there is one."""
    other = finer(resolved.setup)
    known = rms_error(other, resolved.signal, resolved.transient)
    change = abs(known - rms) if known is not None and rms is not None else None
    return dict(zip((column.name for column in SOLVER), (largest_distance(run, other), change), strict=True))


def run_study(
    planned: Plan,
    folder: Path,
    *,
    jobs: int | None = None,
    cluster: str | None = None,
    resume: bool = False,
    overwrite: bool = False,
    keep_all: bool = False,
    progress: Progress | None = None,
) -> None:
    """Run all cases of a study into `folder`.

    Args:
        planned: the study, checked.
        folder: where results go.
        jobs: parallel cases on this machine; default one a core.
        cluster: address of a dask scheduler to run on instead.
        resume: go on with the results in `folder`.
        overwrite: replace them.
        keep_all: keep every trajectory, not only those that figures need.
        progress: told of each finished case.

    Raises:
        UserError: the folder, or the cluster, does not serve.
    """
    study, began = planned.study, time.time()
    columns, identity = planned.columns, planned.identity
    opened = Store.resume(folder, columns, identity) if resume else Store.create(folder, columns, identity, overwrite)
    with closing(opened) as store:
        write_study(study, folder)
        work = case_runs(planned, folder, keep_all=keep_all)
        done = store.done()
        done -= work.unwritten()
        waiting = [index for index in range(len(planned.cases)) if index not in done]
        if waiting and cluster is None:
            compiled(planned)
        count = len(done)
        with closing(in_chunks(work, waiting, jobs=jobs, cluster=cluster)) as chunks, _killed_told(planned):
            for chunk in chunks:
                store.add(chunk.results)
                count += len(chunk.results)
                if progress is not None:
                    progress(count, len(planned.cases), in_full(planned.cases.columns(chunk.places[-1])))
        if waiting or not all((folder / name).exists() for name in EXPORTS):
            export_frames(store.frames, folder)
    write_json(folder / "run.json", _record(planned, began, jobs, cluster))


@contextmanager
def _killed_told(planned: Plan) -> Iterator[None]:
    try:
        yield
    except KilledError as error:
        label = planned.cases[error.place].label
        raise UserError(
            f"{label}: its process was killed whenever it ran, as a system does that is out of memory; finished "
            "cases are kept: go on with --resume --jobs 1"
        ) from None


def _storable(value: object) -> object:
    """A value as SQLite keeps it; a list or a table of a dotted axis as JSON."""
    return json.dumps(value) if isinstance(value, list | dict) else value


def _record(planned: Plan, began: float, jobs: int | None, cluster: str | None) -> dict[str, object]:
    return {
        "title": planned.study.file.title,
        **planned.identity,
        "cases": len(planned.cases),
        "simulated_seconds": planned.simulated_seconds,
        "seeds": planned.seeds,
        **ran_on(began, cluster or jobs),
    }
