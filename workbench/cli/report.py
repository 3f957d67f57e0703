"""workbench report: tables, figures and words of results as one LaTeX document."""

from pathlib import Path
from typing import Annotated

import typer

from workbench.cli.options import Out, Overwrite, PageFormat, print_warnings, say


def command(
    folders: Annotated[list[Path], typer.Argument(help="Folders of results.", metavar="DIR...")],
    out: Out,
    page: PageFormat = None,
    pdf: Annotated[bool, typer.Option("--pdf", help="Compile it too, with pdflatex.")] = False,
    overwrite: Overwrite = False,
) -> None:
    """Put tables, figures and words of results into a LaTeX document."""
    from workbench.report.folder import write_report

    report = write_report(folders, out, page, pdf=pdf, overwrite=overwrite)
    print_warnings(report.remarks)
    say("wrote " + " and ".join(str(path) for path in (report.tex, report.pdf) if path is not None))
