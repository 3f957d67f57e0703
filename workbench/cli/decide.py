"""workbench decide: which controllers meet an accuracy."""

import time
from typing import Annotated

import typer

from workbench.cli.options import Cluster, Out, Overwrite, PageFormat, StudyFile, print_contents, say
from workbench.cli.progress import AGAIN, ProgressLine, stoppable


def command(
    study: StudyFile,
    out: Out,
    jobs: Annotated[int | None, typer.Option(min=1, help="Runs at a time; default: one a core.")] = None,
    cluster: Cluster = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the runs in DIR.")] = False,
    overwrite: Overwrite = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only say what would be run.")] = False,
    machine: Annotated[str | None, typer.Option(help="The machine, in place of the study's.", metavar="NAME")] = None,
    page: PageFormat = None,
) -> None:
    """Say which controllers meet an accuracy, and how probably."""
    from workbench.decide.plan import plan_decision
    from workbench.decide.report.folder import opened_folder, summary, write_decision
    from workbench.decide.run import decide
    from workbench.decide.section import description
    from workbench.parallel.cluster import check_answer
    from workbench.publish.page_format import figures_at
    from workbench.study.reading import read_study

    kept = f"finished runs are kept in {out}: go on with --resume"
    with stoppable(kept if resume else AGAIN):
        began, planned = time.time(), plan_decision(read_study(study), machine)
        if dry_run:
            from workbench.decide.estimate import estimate

            say("\n".join(description(planned)))
            say(f"  {estimate(planned, jobs)}")
            return
        check_answer(cluster)
    with (
        figures_at(page),
        stoppable(kept),
        ProgressLine() as progress,
        opened_folder(out, planned, resume=resume, overwrite=overwrite) as runs,
    ):
        decision = decide(planned, jobs, progress, runs, cluster)
        progress("tables, figures, page", 1.0)
        write_decision(decision, out, began, cluster or jobs)
    say(summary(decision) + "\n")
    print_contents(out)
