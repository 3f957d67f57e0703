"""Running a study: its cases in parallel, each result kept the moment it is there."""

import json
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future, as_completed
from pathlib import Path

from workbench.errors import MetricError
from workbench.metrics.evaluate import evaluate
from workbench.metrics.registry import SOLVER, names_along
from workbench.parallel import workers
from workbench.publish.run_record import ran_on
from workbench.simulation.run import Run
from workbench.simulation.simulate import finer, largest_distance, simulate
from workbench.study.plan import Plan, needed_trajectories
from workbench.study.probes import probe_values
from workbench.study.resolve import Resolved, resolve
from workbench.study.run_on import evaluated
from workbench.study.sketches import SKETCH, points_for, sketch_of, sketched
from workbench.study.store import (
    Store,
    export,
    record_path,
    trajectory_path,
    write_json,
    write_record,
    write_study,
    write_trajectory,
)
from workbench.study.study import Case, Study

Progress = Callable[[int, int, Case], None]
"""Called with the number of finished cases, of all cases, and the case that has just finished."""


def run_case(
    study: Study,
    case: Case,
    keep: Path | None,
    record: Path | None = None,
    resolved: Resolved | None = None,
    points: int = 0,
) -> dict[str, object]:
    """Run one case and return its row; the trajectory goes to `keep`, what a rig would write down to `record`. With
    `points` the row has a sketch of the trajectory too, of so many.

    `resolved` is what the case runs, where that need not travel to another process. A mistake in the file has been
    found before, by `plan`.

    Raises:
        MetricError: a metric of a plug-in fails.
    """
    resolved = resolved or resolve(study, case)
    run = simulate(resolved.setup)
    try:
        figures = figures_of(resolved, run, solver_error=case.tells_solver_error)
    except MetricError as error:
        raise MetricError(f"{case.label}: {error}") from error.__cause__
    values: dict[str, object] = {**case.columns, **figures}
    values |= probe_values(run, study.file.probes, resolved.transient, case.name)
    if points:
        values[SKETCH] = sketch_of(run, points)
    if keep is not None:
        write_trajectory(run, keep)
    if record is not None:
        write_record(run, study.file.records, case.rpm, record)
    return values


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
    figures = evaluate(other, resolved.signal, resolved.transient, resolved.band, ("rms_error_m",))
    known = figures["rms_error_m"]
    change = abs(known - rms) if isinstance(known, float) and rms is not None else None
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
    if resume:
        store = Store.reopen(folder, planned.columns, planned.identity)
    else:
        store = Store.create(folder, planned.columns, planned.identity, overwrite)
    try:
        write_study(study, folder)
        kept = {case.index for case in planned.cases} if keep_all else needed_trajectories(planned)
        paths = {index: trajectory_path(folder.resolve(), index) for index in kept}
        records = {case.index: record_path(folder.resolve(), case) for case in planned.cases if study.file.records}
        sketches = {case.index for case in sketched(planned.cases)}
        points = points_for(len(sketches))
        missing = {index for files in (paths, records) for index, path in files.items() if not path.exists()}
        done = store.done() - missing
        waiting = [case for case in planned.cases if case.index not in done]
        with workers(jobs, cluster) as executor:
            futures: dict[Future[dict[str, object]], Case] = {
                executor.submit(
                    run_case,
                    study,
                    case,
                    paths.get(case.index),
                    records.get(case.index),
                    planned.resolved[case.index] if cluster is None else None,
                    points if case.index in sketches else 0,
                ): case
                for case in waiting
            }
            for count, future in enumerate(as_completed(futures), start=len(done) + 1):
                case = futures[future]
                store.add(case.index, _storable(future.result()))
                if progress is not None:
                    progress(count, len(planned.cases), case)
        export(store.frame(), folder)
        write_json(folder / "run.json", _record(planned, began, jobs, cluster))
    finally:
        store.close()


def _storable(values: Mapping[str, object]) -> dict[str, object]:
    """Values as SQLite keeps them; lists and tables of a dotted axis as JSON."""
    return {key: json.dumps(value) if isinstance(value, list | dict) else value for key, value in values.items()}


def _record(planned: Plan, began: float, jobs: int | None, cluster: str | None) -> dict[str, object]:
    return {
        "title": planned.study.file.title,
        **planned.identity,
        "cases": len(planned.cases),
        "simulated_seconds": planned.simulated_seconds,
        "seeds": sorted({item.setup.seed for item in planned.resolved}),
        **ran_on(began, cluster or jobs),
    }
