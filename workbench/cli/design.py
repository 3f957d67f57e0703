"""workbench design: which experiment to make next."""

from pathlib import Path
from typing import Annotated

import typer

from workbench.cli.options import Out, Overwrite, PageFormat, print_contents, say
from workbench.cli.progress import ProgressLine, stoppable


def command(
    source: Annotated[
        Path, typer.Argument(help="An experiment, or a folder of workbench diagnose.", metavar="EXPERIMENT.toml|DIR")
    ],
    out: Out,
    between: Annotated[
        str | None,
        typer.Option(help="Effects to tell apart, or none: none,backlash. Default: what was left open.", metavar="A,B"),
    ] = None,
    identify: Annotated[
        str | None, typer.Option(help="Parameters to show: coulomb,viscous.", metavar="NAME,...")
    ] = None,
    duration: Annotated[
        str | None, typer.Option(help='How long the motion may last, 4 s to 600 s: "60 s".', metavar="TIME")
    ] = None,
    overwrite: Overwrite = False,
    page: PageFormat = None,
) -> None:
    """Find the motion to record next."""
    from workbench.design.design import design
    from workbench.design.report.folder import claimed_folder, summary, write_design
    from workbench.publish.page_format import figures_at

    with figures_at(page), stoppable(), ProgressLine() as progress, claimed_folder(out, overwrite):
        found = design(
            source,
            between=_names(between),
            identify=_names(identify),
            duration=None if duration is None else _seconds(duration),
            progress=progress,
        )
        progress("tables, figures, page", 0.95)
        write_design(found, out)
    say(summary(found) + "\n")
    print_contents(out)


def _names(given: str | None) -> list[str]:
    return [name.strip() for name in (given or "").split(",") if name.strip()]


def _seconds(given: str) -> float:
    """A time (s), with or without a unit."""
    from workbench.errors import UserError
    from workbench.toml.units import QuantityError, said_in

    try:
        return said_in(given, "s")
    except QuantityError as error:
        raise UserError(f"--duration: {error}") from None
