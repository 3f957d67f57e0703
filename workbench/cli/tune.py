"""workbench tune: gains for the controllers of a study."""

import time
from typing import Annotated

import typer

from workbench.cli.options import Cluster, Out, PageFormat, StudyFile
from workbench.cli.progress import AGAIN, ProgressLine, stoppable


def command(
    study: StudyFile,
    out: Out,
    controller: Annotated[
        list[str] | None,
        typer.Option(help="A controller of the study; several: once each. Default: all.", metavar="NAME"),
    ] = None,
    trials: Annotated[int | None, typer.Option(min=1, help="Trials of each seed; default: what [tune] says.")] = None,
    jobs: Annotated[int | None, typer.Option(min=1, help="Searches at a time; default: one a core.")] = None,
    cluster: Cluster = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the trials in DIR.")] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace what is in DIR.")] = False,
    page: PageFormat = None,
) -> None:
    """Find gains, with the same budget and objective for all."""
    from workbench.parallel.cluster import check_answer
    from workbench.publish.page_format import figures_at
    from workbench.study.reading import read_study
    from workbench.tune.prepare import prepared
    from workbench.tune.report.folder import opened_folder, say_tuning, write_tuning
    from workbench.tune.run import tune_all

    kept = f"finished trials are kept in {out}: go on with --resume"
    with stoppable(kept if resume else AGAIN):
        ready, names = prepared(read_study(study), controller or ["all"], trials)
        check_answer(cluster)
    began = time.time()
    with (
        figures_at(page),
        stoppable(kept),
        ProgressLine() as progress,
        opened_folder(out, resume=resume, overwrite=overwrite) as database,
    ):
        tuning = tune_all(ready, names, database, jobs, progress, cluster)
        written = write_tuning(tuning, out, began=began, jobs=jobs, cluster=cluster, progress=progress)
    say_tuning(written)
    if not any(tuned.best for tuned in tuning.tuned):
        raise typer.Exit(1)
