"""Running a study: its cases in chunks, each chunk's results kept the moment they are there."""

import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path

from workbench.errors import UserError
from workbench.parallel.chunks import KilledError, in_chunks
from workbench.parallel.cluster import check_answer
from workbench.publish.run_record import ran_on
from workbench.study.case_runs import case_runs, compiled
from workbench.study.plan import Plan
from workbench.study.shipped import Shipped, ShippedRuns, unpacked
from workbench.study.store import Row, is_exported, open_store, ready_to_write, write_json, write_study
from workbench.study.study import in_full

Progress = Callable[[int, int, str], None]
"""Called with the number of finished cases, of all cases, and one that has just finished, in words."""


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
    check_answer(cluster)
    began, identity, count = time.time(), planned.identity, len(planned.cases)
    with open_store(folder, planned.columns, identity, resume=resume, overwrite=overwrite) as store:
        write_study(planned.study, folder)
        work = case_runs(planned, folder, keep_all=keep_all)
        done = store.done()
        done -= work.unwritten()
        waiting = [index for index in range(count) if index not in done]
        if waiting and cluster is None:
            compiled(planned)
            if work.file_count:
                ready_to_write()
        version = identity["version of the program"]
        made: Callable[[Sequence[int]], Sequence[Row | Shipped]] = (
            work if cluster is None else ShippedRuns(work, version)
        )
        with closing(in_chunks(made, waiting, jobs=jobs, cluster=cluster)) as chunks, _killed_told(planned):
            for chunk in chunks:
                store.add(unpacked(chunk.results, folder))
                done.update(chunk.places)
                if progress is not None:
                    progress(len(done), count, in_full(planned.cases.columns(chunk.places[-1])))
        if waiting or not is_exported(folder, count):
            store.export(folder)
        write_json(folder / "run.json", _record(planned, began, jobs, cluster))


@contextmanager
def _killed_told(planned: Plan) -> Iterator[None]:
    try:
        yield
    except KilledError as error:
        label = planned.cases[error.place].label
        if planned.resolved[error.place].setup.machine is not None:
            raise UserError(
                f"{label}: its process was killed whenever it ran: its FMU crashes, or memory runs out; finished cases "
                "are kept: mend that, then go on with --resume"
            ) from None
        raise UserError(
            f"{label}: its process was killed whenever it ran, as a system does that is out of memory; finished "
            "cases are kept: go on with --resume --jobs 1"
        ) from None


def _record(planned: Plan, began: float, jobs: int | None, cluster: str | None) -> dict[str, object]:
    return {
        "title": planned.study.file.title,
        **planned.identity,
        "study": planned.study.fingerprint,
        "draws": json.loads(planned.identity["draws"]),
        "cases": len(planned.cases),
        "simulated_seconds": planned.simulated_seconds,
        "seeds": planned.seeds,
        **ran_on(began, cluster or jobs),
    }
