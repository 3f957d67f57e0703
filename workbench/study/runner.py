"""Running a study: its cases in parallel, each result kept the moment it is there."""

import hashlib
import json
import os
import platform
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from controllers.registry import CONTROLLERS
from plants.equation import EQUATION_FOLDERS, source_hash, to_array
from plants.registry import PLANTS
from workbench.errors import UserError
from workbench.metrics import COLUMNS, SOLVER, evaluate
from workbench.simulation.simulate import Run, finer, largest_distance, simulate
from workbench.study.checks.checks import Checks
from workbench.study.names import matches
from workbench.study.probes import probe_values
from workbench.study.resolve import ParsedCase, Resolved, parse_case, resolve
from workbench.study.run_on import evaluated
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
from workbench.study.uncertainty import DRAW, on_plant_samples
from workbench.study.unfold import unfold

PROGRAM_FOLDERS = (*EQUATION_FOLDERS, "workbench/metrics", "workbench/study")
"""Folders of the source files on which a row of results depends."""

PACKAGES = ("numpy", "numba", "scipy", "pandas", "control", "casadi")
"""Packages whose version run.json records."""

Progress = Callable[[int, int, Case], None]
"""Called with the number of finished cases, of all cases, and the case that has just finished."""


@dataclass(frozen=True)
class Plan:
    """A study that has been checked to the last key: its cases, each as `parsed`, and what it is on the machine as
    `declared`, not drawn.
    """

    study: Study
    cases: list[Case]
    parsed: list[ParsedCase]
    declared: list[Resolved]
    warnings: Sequence[str] = ()

    @cached_property
    def resolved(self) -> list[Resolved]:
        """What each case runs."""
        return [
            parsed.resolve(case.overrides) if DRAW in case.axes else declared
            for case, parsed, declared in zip(self.cases, self.parsed, self.declared, strict=True)
        ]

    @property
    def axes(self) -> list[str]:
        """Columns that tell the cases apart."""
        return list(dict.fromkeys(name for case in self.cases for name in case.columns))

    @property
    def columns(self) -> list[str]:
        """Columns of results.csv: the axes, the standard figures, the probes."""
        return [*self.axes, *COLUMNS, *self.study.file.probes]

    @property
    def identity(self) -> dict[str, str]:
        """What results must agree in to be of the same study: the file, the numbers it leads to, all code."""
        numbers = hashlib.sha256()
        for item in self.resolved:
            setup = item.setup
            signals = [setup.reference, *(feed.signal for feed in setup.feeds)]
            turned = (setup.rotary.gains,) if setup.rotary else ()
            for values in (setup.parameters, setup.state, setup.inputs, setup.loop.gains, *turned):
                numbers.update(to_array(values).tobytes())
            for signal in signals:
                if signal is not None:
                    numbers.update(signal(np.linspace(0.0, setup.duration, 1001))[0].tobytes())
        return {
            "study": self.study.fingerprint,
            "parameters": numbers.hexdigest(),
            "version of the program": source_hash(PROGRAM_FOLDERS),
            "version of the plug-ins": self._plugins,
        }

    @property
    def _plugins(self) -> str:
        """The plug-ins that the cases name, each with a hash of its source; "" where there are none."""
        used = {item.setup.plant for item in self.resolved}
        types = {str(table.get("type")) for case in self.cases for table in case.tables["controllers"].values()}
        sources = [(name, PLANTS.source(name)) for name, plant in PLANTS.working().items() if plant in used]
        sources += [(name, CONTROLLERS.source(name)) for name in sorted(types)]
        return ", ".join(f"{name} {source}" for name, source in sources if source)

    @property
    def simulated_seconds(self) -> float:
        """Duration of all cases together (s)."""
        return sum(item.setup.duration for item in self.declared)


def plan(study: Study) -> Plan:
    """Unfold and check a study.

    Raises:
        UserError: the first mistake in any case, table or figure.
    """
    planned = _drawn(study, unfold(study))
    checks = Checks(study, planned.cases, planned.declared, planned.axes, COLUMNS)
    checks.all()
    return replace(planned, warnings=checks.warnings())


def again(planned: Plan, wanted: Sequence[Mapping[str, object]], draws: int) -> Plan:
    """Those cases of a plan that have one of the `wanted` sets of columns, on so many machines not yet drawn."""
    study, table = planned.study, planned.study.file.uncertainty
    chosen = [case for case in unfold(study) if any(matches(case.columns, where) for where in wanted)]
    first = 1 + (table.draws if table is not None else 0)
    return _drawn(study, chosen, range(first, first + draws))


def _drawn(study: Study, cases: list[Case], numbers: range | None = None) -> Plan:
    """The plan of these cases on each plant sample, where the study draws any."""
    parsed = [parse_case(study, case) for case in cases]
    declared = [each.resolve() for each in parsed]
    drawn = on_plant_samples(study, cases, numbers)
    times = range(len(drawn) // len(cases) if cases else 1)
    return Plan(study, drawn, [each for each in parsed for _ in times], [each for each in declared for _ in times])


def needed_trajectories(planned: Plan) -> set[int]:
    """Indices of the cases whose trajectories some figure of the study draws."""
    columns = planned.columns
    wanted = [
        curve.where
        for figure in planned.study.file.figures
        for panel in figure.panels
        if panel.x not in columns
        for curve in panel.curves
    ]
    return {case.index for case in planned.cases if any(matches(case.columns, where) for where in wanted)}


def run_case(
    study: Study, case: Case, keep: Path | None, record: Path | None = None, resolved: Resolved | None = None
) -> dict[str, Any]:
    """Run one case and return its row; the trajectory goes to `keep`, what a rig would write down to `record`.

    `resolved` is what the case runs, where that need not travel to another process. A mistake in the file has been
    found before, by `plan`.
    """
    resolved = resolved or resolve(study, case)
    run = simulate(resolved.setup)
    values: dict[str, Any] = {**case.columns, **figures_of(resolved, run, solver_error=case.tells_solver_error)}
    values |= probe_values(run, study.file.probes, resolved.transient, case.name)
    if keep is not None:
        write_trajectory(run, keep)
    if record is not None:
        write_record(run, study.file.records, case.rpm, record)
    return values


def figures_of(resolved: Resolved, run: Run, *, solver_error: bool = True) -> dict[str, float | str | None]:
    """All of `COLUMNS` of a case's run, in their order; None where a figure does not apply.

    `solver_error`: whether those of `SOLVER` are found too, which takes a second, finer run.
    """
    figures = evaluated(resolved, run)
    rms = figures["rms_error_m"]
    errors = _solver_errors(resolved, run, rms if isinstance(rms, float) else None) if solver_error else {}
    return {**figures, **dict.fromkeys(SOLVER), **errors}


def _solver_errors(resolved: Resolved, run: Run, rms: float | None) -> dict[str, float | None]:
    """What a finer integration changes: positions at most, and the rms error where there is one."""
    other = finer(resolved.setup)
    figures = evaluate(other, resolved.signal, resolved.transient, resolved.band, ("rms_error_m",))
    known = figures["rms_error_m"]
    change = abs(known - rms) if isinstance(known, float) and rms is not None else None
    return dict(zip(SOLVER, (largest_distance(run, other), change), strict=True))


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
        missing = {index for files in (paths, records) for index, path in files.items() if not path.exists()}
        done = store.done() - missing
        waiting = [case for case in planned.cases if case.index not in done]
        with _executor(jobs, cluster) as executor:
            futures: dict[Future[dict[str, Any]], Case] = {
                executor.submit(
                    run_case,
                    study,
                    case,
                    paths.get(case.index),
                    records.get(case.index),
                    planned.resolved[case.index] if cluster is None else None,
                ): case
                for case in waiting
            }
            try:
                for count, future in enumerate(as_completed(futures), start=len(done) + 1):
                    case = futures[future]
                    store.add(case.index, _storable(future.result()))
                    if progress is not None:
                        progress(count, len(planned.cases), case)
            except BaseException:
                executor.shutdown(wait=False, cancel_futures=True)
                raise
        export(store.frame(), folder)
        write_json(folder / "run.json", _record(planned, began, jobs, cluster))
    finally:
        store.close()


def _storable(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values as SQLite keeps them; lists and tables of a dotted axis as JSON."""
    return {key: json.dumps(value) if isinstance(value, list | dict) else value for key, value in values.items()}


@contextmanager
def _executor(jobs: int | None, cluster: str | None) -> Iterator[Executor]:
    if cluster is None:
        with ThreadPoolExecutor(jobs or os.cpu_count() or 1) as threads:
            yield threads
        return
    try:
        from distributed import Client
    except ImportError:
        raise UserError('--cluster needs the extra "cluster": pip install "friction-workbench[cluster]"') from None
    try:
        client = Client(cluster, timeout=10)
    except (OSError, ValueError) as error:
        raise UserError(f"{cluster}: no scheduler answers there ({error})") from None
    with client, client.get_executor() as executor:
        yield executor


def _record(planned: Plan, began: float, jobs: int | None, cluster: str | None) -> dict[str, Any]:
    return {
        "title": planned.study.file.title,
        **planned.identity,
        "cases": len(planned.cases),
        "simulated_seconds": planned.simulated_seconds,
        "seeds": sorted({item.setup.seed for item in planned.resolved}),
        **ran_on(began, cluster or jobs or os.cpu_count(), PACKAGES),
    }


def ran_on(began: float, jobs: int | str | None, packages: Sequence[str]) -> dict[str, Any]:
    """What run.json says of the machine: how long it took since `began` (s since the epoch), jobs, versions, cores."""
    return {
        "wall_seconds": round(time.time() - began, 3),
        "started": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(began)),
        "jobs": jobs,
        "versions": {"python": platform.python_version(), **{name: version(name) for name in packages}},
        "machine": {"system": platform.system(), "machine": platform.machine(), "cores": os.cpu_count()},
    }
