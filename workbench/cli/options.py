"""What several commands have in common: arguments, conditions, folders of results in words."""

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, TextIO

import typer

from workbench.errors import UserError, in_one_line, visible

LONGEST = 150
"""Lines of a table that is printed."""

StudyFile = Annotated[Path, typer.Argument(help="A study: a TOML file.", metavar="STUDY.toml")]
ExperimentFile = Annotated[Path, typer.Argument(help="An experiment: a TOML file.", metavar="EXPERIMENT.toml")]
Folder = Annotated[Path, typer.Argument(help="A folder of results.", metavar="DIR")]
Out = Annotated[Path, typer.Option(help="Folder for the results.", metavar="DIR")]
Cluster = Annotated[str | None, typer.Option(help="Address of a dask scheduler to run on.", metavar="ADDRESS")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace what is there.")]
AllowFmu = Annotated[
    bool, typer.Option("--allow-fmu", help="Run the FMUs that the study names: foreign code, which you trust.")
]
PageFormat = Annotated[
    str | None,
    typer.Option(
        "--format", help='Figures for a page: ieee, elsevier, ..., "84 mm" or "84 mm, 9 pt".', metavar="FORMAT"
    ),
]
Where = Annotated[
    list[str] | None, typer.Option(help="Only cases with this value of an axis: rpm=460. May be repeated.")
]


def conditions(where: list[str] | None, option: str = "--where") -> dict[str, str]:
    """What --where, or another such `option`, asks for, by column.

    Raises:
        UserError: a condition without "=".
    """
    found = {}
    for item in where or []:
        name, equals, value = item.partition("=")
        if not equals:
            raise UserError(f'{option} "{item}": expected AXIS=VALUE, such as rpm=460')
        found[name.strip()] = value.strip()
    return found


def say(text: object = "", file: TextIO | None = None) -> None:
    """Print text of any origin, titles, names and headers of files, so that nothing in it steers the terminal."""
    print(visible(str(text)), file=file, flush=True)


def print_tables(paths: list[Path]) -> None:
    """Print tables; of one that nobody would read on a terminal only where it lies."""
    for path in paths:
        text = path.read_text(encoding="utf-8")
        say(f"\n{text}" if text.count("\n") <= LONGEST else f"wrote {path} ({text.count(chr(10))} lines)")


def print_warnings(lines: Iterable[str]) -> None:
    """Print warnings to standard error."""
    for line in lines:
        say(f"warning: {in_one_line(line)}", file=sys.stderr)


def print_contents(folder: Path) -> None:
    """Say what a folder of results holds."""
    say(f"results in {folder}: {', '.join(sorted(item.name for item in folder.iterdir()))}")
