"""workbench export controller: a controller of a study as C."""

from typing import Annotated

import typer

from workbench.cli.options import Out, StudyFile


def command(
    study: StudyFile,
    out: Out,
    controller: Annotated[
        str | None, typer.Option(help="Which of the study's controllers; needed where it has several.", metavar="NAME")
    ] = None,
) -> None:
    """A controller with its gains as C99, and its test."""
