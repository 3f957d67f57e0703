"""The commands that answer questions: identify and diagnose from records, tune and decide from a study."""

import sys
import time
from pathlib import Path
from typing import Annotated

import typer

from workbench.cli.commands import StudyFile, app
from workbench.cli.progress import ProgressLine
from workbench.errors import UserError, nearest


@app.command()
def decide(
    study: StudyFile,
    out: Annotated[Path, typer.Option(help="Folder for the results.", metavar="DIR")],
    jobs: Annotated[int | None, typer.Option(min=1, help="Runs at a time; default: one a core.")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the results in DIR.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only say what would be run.")] = False,
    machine: Annotated[str | None, typer.Option(help="The machine, in place of the study's.", metavar="NAME")] = None,
) -> None:
    """Say which controllers meet an accuracy, and how probably."""
    from workbench.cli.plan import say_decision
    from workbench.decide.decision import decide as decided
    from workbench.decide.plan import plan_decision
    from workbench.report.decision import check_folder, summary, write_decision
    from workbench.study.document import deciding_on, read_study

    content = read_study(study)
    began, planned = time.time(), plan_decision(content if machine is None else deciding_on(content, machine))
    if dry_run:
        say_decision(planned)
        return
    check_folder(out, overwrite)
    try:
        with ProgressLine() as tell:
            found = decided(planned, jobs, tell)
            tell("tables, figures, page", 1.0)
            write_decision(found, out, began, jobs)
    except KeyboardInterrupt:
        print("stopped; nothing is written", file=sys.stderr)
        raise typer.Exit(130) from None
    print(summary(found))
    print(f"\nresults in {out}: {', '.join(sorted(item.name for item in out.iterdir()))}")


@app.command()
def identify(
    experiment: Annotated[Path, typer.Argument(help="An experiment: a TOML file.", metavar="EXPERIMENT.toml")],
    out: Annotated[Path, typer.Option(help="Folder for the results.", metavar="DIR")],
    method: Annotated[str | None, typer.Option(help="thesis, simulation or both.")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the results in DIR.")] = False,
) -> None:
    """Find friction and other parameters of a plant in records."""
    from workbench.files import read_toml
    from workbench.identify.experiment import is_experiment, read_experiment
    from workbench.identify.identification import identify as identified
    from workbench.identify.schema import METHODS
    from workbench.report.identification import check_folder, write_identification

    if method is not None and method not in METHODS:
        raise UserError(f'--method "{method}": {nearest(method, METHODS)}')
    data, _ = read_toml(experiment)
    if not is_experiment(data) and "controllers" in data:
        raise UserError(f"{experiment}: this is a study; use workbench run {experiment} --out {out}")
    content = read_experiment(experiment)
    check_folder(out, overwrite)
    try:
        with ProgressLine() as said:
            paths = write_identification(identified(content, method, said), out)
    except KeyboardInterrupt:
        print("stopped; nothing is written", file=sys.stderr)
        raise typer.Exit(130) from None
    for path in paths:
        print(path.read_text(encoding="utf-8"))
    print(f"results in {out}: {', '.join(sorted(item.name for item in out.iterdir()))}")


@app.command()
def diagnose(
    experiment: Annotated[Path, typer.Argument(help="An experiment: a TOML file.", metavar="EXPERIMENT.toml")],
    out: Annotated[Path, typer.Option(help="Folder for the results.", metavar="DIR")],
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the results in DIR.")] = False,
) -> None:
    """Say what the plant of an experiment lacks, and how sure that is."""
    from workbench.diagnose.diagnose import diagnose as diagnosed
    from workbench.report.diagnosis import check_folder, summary, write_diagnosis

    check_folder(out, overwrite)
    with ProgressLine() as tell:
        found = diagnosed(experiment, tell)
        tell("tables, figures, page", 0.93)
        write_diagnosis(found, out)
    print(summary(found))
    print(f"\nresults in {out}: {', '.join(sorted(item.name for item in out.iterdir()))}")


@app.command()
def tune(
    study: StudyFile,
    out: Annotated[Path, typer.Option(help="Folder for the results.", metavar="DIR")],
    controller: Annotated[
        list[str] | None,
        typer.Option(help="A controller of the study; several: once each. Default: all.", metavar="NAME"),
    ] = None,
    trials: Annotated[int | None, typer.Option(min=1, help="Trials of each seed; default: what [tune] says.")] = None,
    jobs: Annotated[int | None, typer.Option(min=1, help="Searches at a time; default: one a core.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the trials in DIR.")] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace what is in DIR.")] = False,
) -> None:
    """Find gains, with the same budget and objective for all."""
    from workbench.report.tuning import open_folder, say_tuning, write_tuning
    from workbench.study.document import read_study
    from workbench.tune.study import prepared, tune_all

    ready, names = prepared(read_study(study), controller or ["all"], trials)
    database, began = open_folder(out, resume=resume, overwrite=overwrite), time.time()
    try:
        with ProgressLine() as tell:
            found = tune_all(ready, names, database, jobs, tell)
            written = write_tuning(found, out, began=began, jobs=jobs, tell=tell)
    except KeyboardInterrupt:
        print(f"stopped; finished trials are kept in {out}: go on with --resume", file=sys.stderr)
        raise typer.Exit(130) from None
    say_tuning(written)
    if not any(one.best for one in found.found):
        raise typer.Exit(1)
