"""workbench run: every case of a study, then its tables, figures and pages."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from workbench.cli.options import AllowFmu, Cluster, Out, Overwrite, StudyFile, print_tables, print_warnings, say
from workbench.cli.planned import planned_study

if TYPE_CHECKING:
    from workbench.study.plan import Plan
    from workbench.study.standing import Made

MADE = ("results.csv", "tables", "figures", "results.html", "comparison.html")
"""What a folder of results is told to hold, where it does."""


def command(
    study: StudyFile,
    out: Out,
    jobs: Annotated[int | None, typer.Option(min=1, help="Cases at a time; default: one a core.")] = None,
    cluster: Cluster = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the results in DIR.")] = False,
    overwrite: Overwrite = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only say what would be run, and what it takes.")] = False,
    keep_trajectories: Annotated[
        bool, typer.Option("--keep-trajectories", help="Keep every case's signals, not only those of figures.")
    ] = False,
    allow_fmu: AllowFmu = False,
    draws: Annotated[int | None, typer.Option(min=0, help="Draws of machines, instead of the study's number.")] = None,
    fresh_draws: Annotated[
        int | None, typer.Option(min=0, help="Draws on which the best of a comparison are measured again.")
    ] = None,
) -> None:
    """Run a study: every case of it, then its tables and figures."""
    from workbench.cli.progress import AGAIN, ProgressBar, stoppable
    from workbench.publish.folders import faults_told
    from workbench.study.description import description
    from workbench.study.standing import leave_standing, standing

    kept = f"finished cases are kept in {out}: go on with --resume"
    with stoppable(kept if resume else AGAIN):
        planned = planned_study(study, out, draws, fresh_draws, allow_fmu)
        say("\n".join(description(planned)))
        print_warnings(planned.warnings)
        if dry_run:
            _say_estimate(planned, out if resume else None, jobs, keep_trajectories)
            return
        if resume and not overwrite and (made := standing(planned, out, keep_all=keep_trajectories)) is not None:
            print_tables([out / table for table in made.tables])
            _conclude(made, out)
            return

    from workbench.study.rounds import run_rounds
    from workbench.study.runner import run_study

    def run(plan: "Plan", folder: Path, resume: bool, overwrite: bool) -> None:
        with ProgressBar(len(plan.cases)) as progress:
            run_study(
                plan,
                folder,
                jobs=jobs,
                cluster=cluster,
                resume=resume,
                overwrite=overwrite,
                keep_all=keep_trajectories,
                progress=progress,
            )

    with stoppable(kept):
        run_rounds(planned, out, run, resume=resume, overwrite=overwrite, tell=say)
        with faults_told(out, f"all cases are kept in {out}: mend that, then go on with --resume"):
            made = _report(planned, out)
        leave_standing(planned, out, made, keep_all=keep_trajectories)


def _say_estimate(planned: "Plan", out: Path | None, jobs: int | None, keep_all: bool) -> None:
    """Say what running a study would take: of one that goes on in the folder `out`, what is left of it."""
    from workbench.study.estimate import estimate
    from workbench.study.store import finished_in

    count, done = len(planned.cases), 0 if out is None else finished_in(out)
    if done:
        say(f"  {done} of {count} cases are finished in {out}")
    if done < count:
        print(f"  {estimate(planned, jobs, keep_all=keep_all, count=count - done)}")


def _report(planned: "Plan", folder: Path) -> "Made":
    """Make tables, figures and pages of finished results, and say which cases did not simply complete."""
    from workbench.study.report.folder import shown_columns, write_all
    from workbench.study.report.unusual import unusual
    from workbench.study.standing import Made
    from workbench.study.store import read_results

    frame = read_results(folder, shown_columns(planned.study, planned.axis))
    tables, pages = write_all(planned, frame, folder, print_tables)
    for page in pages:
        say(f"wrote {page}")
    made = Made([path.relative_to(folder).as_posix() for path in tables], unusual(frame, frame))
    _conclude(made, folder)
    return made


def _conclude(made: "Made", folder: Path) -> None:
    """Say of finished results which are unusual, and where they all are."""
    for line in made.lines:
        say(line)
    say(f"results in {folder}: {', '.join(name for name in MADE if (folder / name).exists())}")
