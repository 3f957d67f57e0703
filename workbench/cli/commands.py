"""The commands. What a command does not need it does not import: help appears at once."""

import io
import os
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from workbench.errors import UserError, nearest

app = typer.Typer(
    help="Friction Workbench: an actuator sticks. Compensate the friction, or avoid it?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)

LONGEST = 150
"""Lines of a table that is printed."""

StudyFile = Annotated[Path, typer.Argument(help="A study: a TOML file.", metavar="STUDY.toml")]
Folder = Annotated[Path, typer.Argument(help="A folder of results.", metavar="DIR")]
Where = Annotated[
    list[str] | None, typer.Option(help="Only cases with this value of an axis: rpm=460. May be repeated.")
]


@app.callback()
def _options(
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    """Options of every command; `main` reads --debug itself."""


@app.command()
def run(
    study: StudyFile,
    out: Annotated[Path, typer.Option(help="Folder for the results.", metavar="DIR")],
    jobs: Annotated[int | None, typer.Option(min=1, help="Cases at a time; default: one a core.")] = None,
    cluster: Annotated[str | None, typer.Option(help="Address of a dask scheduler to run on.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the results in DIR.")] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the results in DIR.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only say what would be run.")] = False,
    keep_trajectories: Annotated[
        bool, typer.Option("--keep-trajectories", help="Keep every case's signals, not only those of figures.")
    ] = False,
    draws: Annotated[int | None, typer.Option(min=0, help="Draws of machines, instead of the study's number.")] = None,
    fresh_draws: Annotated[
        int | None, typer.Option(min=0, help="Draws on which the best of a comparison are measured again.")
    ] = None,
) -> None:
    """Run a study: every case of it, then its tables and figures."""
    from workbench.cli.plan import say_plan
    from workbench.cli.run import Options, planned_study, run_all

    if resume and overwrite:
        raise UserError("--resume and --overwrite: choose one")
    planned = planned_study(study, out, draws, fresh_draws)
    say_plan(planned)
    if dry_run:
        return
    run_all(planned, out, Options(jobs, cluster, resume, overwrite, keep_trajectories))
    _report(out, planned)


@app.command()
def check(
    file: Annotated[Path, typer.Argument(help="A study, machine, scenario, experiment or parameters.", metavar="FILE")],
) -> None:
    """Check a file to the last key and say what it would do. Nothing is run or written."""
    from workbench.cli.check import check_file

    check_file(file)


@app.command("list")
def list_(
    kind: Annotated[
        str | None,
        typer.Argument(
            help="plants, controllers, parameters, machines, scenarios, references, effects, integrators or columns."
        ),
    ] = None,
) -> None:
    """List what a study may name, and effects that a diagnosis knows."""
    from workbench.catalogue import catalogue

    sections = catalogue()
    if kind is not None and kind not in sections:
        raise UserError(f'nothing called "{kind}" to list; {nearest(kind, sections)}')
    for name, lines in sections.items():
        if kind in (None, name):
            print(name)
            print("\n".join(f"  {line}" for line in lines))


@app.command()
def table(
    folder: Folder,
    column: Annotated[
        list[str] | None, typer.Option(help="Show this column of the results instead. May be repeated.")
    ] = None,
    where: Where = None,
) -> None:
    """Write a study's tables again, or show columns of its results."""
    from workbench.compare.page import write_comparison
    from workbench.report.select import columns_of
    from workbench.report.study_report import write_tables
    from workbench.study.document import read_study
    from workbench.study.store import STUDY_COPY, read_results

    frame = read_results(folder)
    if column or where:
        print(columns_of(frame, column or [], _conditions(where)).to_markdown(index=False, floatfmt=".6g"))
        return
    study = read_study(folder / STUDY_COPY)
    tables, pages = write_tables(study, frame, folder), write_comparison(study, frame, folder)
    if not tables and not pages:
        raise UserError(f"{folder}: its study asks for no tables; choose columns with --column")
    _print_tables(tables)
    for page in pages:
        print(f"wrote {page}")


@app.command()
def plot(
    folder: Folder,
    y: Annotated[list[str] | None, typer.Option(help="A signal or a column of the results. May be repeated.")] = None,
    x: Annotated[str, typer.Option(help="What it is drawn against: time, a signal, or an axis of the study.")] = "time",
    where: Where = None,
    out: Annotated[Path | None, typer.Option(help="The picture: a .pdf, .svg or .png file.")] = None,
) -> None:
    """Draw a study's figures again, or any stored signal or column."""
    from workbench.compare.page import write_comparison
    from workbench.report.quick_plot import quick_plot
    from workbench.report.study_report import write_figures
    from workbench.study.document import read_study
    from workbench.study.store import STUDY_COPY, read_results

    frame = read_results(folder)
    if y:
        path, left_out = quick_plot(folder, frame, x, y, _conditions(where), out)
        if left_out:
            print(f"left out: {'; '.join(left_out)}")
        print(f"wrote {path}")
        return
    study = read_study(folder / STUDY_COPY)
    figures, pages = write_figures(study, frame, folder), write_comparison(study, frame, folder)
    if not figures and not pages:
        raise UserError(f"{folder}: its study asks for no figures; say what to draw with --y")
    for paths in [*figures, *([page] for page in pages)]:
        print("wrote " + ", ".join(str(path) for path in paths))


@app.command()
def agree(
    one: Folder,
    other: Annotated[Path, typer.Argument(help="Another folder of results of the same.", metavar="DIR")],
) -> None:
    """Say how many verdicts another comparison moves."""
    from workbench.compare.agreement import agreement
    from workbench.compare.results import verdicts_of

    found = agreement(verdicts_of(one), verdicts_of(other))
    if not found.cells:
        raise UserError(f"{one} and {other} have no field in common: expected two comparisons of the same")
    print("\n".join(found.words))


def _conditions(where: list[str] | None) -> dict[str, str]:
    conditions = {}
    for item in where or []:
        name, equals, value = item.partition("=")
        if not equals:
            raise UserError(f'--where "{item}": expected AXIS=VALUE, such as rpm=460')
        conditions[name.strip()] = value.strip()
    return conditions


def _report(folder: Path, planned: Any) -> None:
    """Tables, figures and pages of finished results, and which cases did not simply complete."""
    from workbench.compare.page import write_comparison
    from workbench.report.study_report import write_cycles, write_figures, write_tables
    from workbench.study.store import read_results

    frame, study = read_results(folder), planned.study
    _print_tables(write_tables(study, frame, folder) + write_cycles(planned, frame, folder))
    write_figures(study, frame, folder)
    for page in write_comparison(study, frame, folder):
        print(f"wrote {page}")
    unusual = frame[frame["outcome"] != "completed"]
    for outcome, count in unusual["outcome"].value_counts().items():
        print(f"{count} of {len(frame)} cases: {outcome}")
    made = ("results.csv", "tables", "figures", "comparison.html")
    print(f"results in {folder}: {', '.join(name for name in made if (folder / name).exists())}")


def _print_tables(paths: list[Path]) -> None:
    """Print tables; of one that nobody would read on a terminal only where it lies."""
    for path in paths:
        text = path.read_text(encoding="utf-8")
        print(f"\n{text}" if text.count("\n") <= LONGEST else f"wrote {path} ({text.count(chr(10))} lines)")


def main() -> None:
    """Run the command line. A user's mistake, or a file system's, is one or two lines and exit code 2."""
    # Threads of the linear algebra wait for each other on a busy machine: 4 s for a product that one makes in 15 ms.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)  # a pipe gets each line when it is written
    try:
        app()
    except (UserError, OSError) as error:
        if "--debug" in sys.argv:
            raise
        place = f"{error.filename}: {error.strerror}" if isinstance(error, OSError) and error.filename else str(error)
        print(f"error: {place}", file=sys.stderr)
        sys.exit(2)
