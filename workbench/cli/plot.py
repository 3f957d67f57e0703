"""workbench plot: a study's figures again, or any stored signal or column."""

from pathlib import Path
from typing import Annotated

import typer

from workbench.cli.options import Folder, PageFormat, Where, conditions, say
from workbench.errors import UserError


def command(
    folder: Folder,
    y: Annotated[list[str] | None, typer.Option(help="A signal or a column of the results. May be repeated.")] = None,
    x: Annotated[str, typer.Option(help="What it is drawn against: time, a signal, or an axis of the study.")] = "time",
    where: Where = None,
    out: Annotated[Path | None, typer.Option(help="The picture: a .pdf, .svg or .png file.")] = None,
    page: PageFormat = None,
) -> None:
    """Draw a study's figures again, or any stored signal or column."""
    from workbench.publish.page_format import figures_at
    from workbench.study.reading import read_study
    from workbench.study.report.folder import write_answers, write_figures
    from workbench.study.report.quick_plot import quick_plot
    from workbench.study.store import STUDY_COPY, read_results

    frame = read_results(folder)
    if y:
        with figures_at(page):
            path, left_out = quick_plot(folder, frame, x, y, conditions(where), out)
        if left_out:
            say(f"left out: {'; '.join(left_out)}")
        say(f"wrote {path}")
        return
    study = read_study(folder / STUDY_COPY)
    with figures_at(page):
        figures, pages = write_figures(study, frame, folder), write_answers(study, frame, folder)
    if not figures and not pages:
        raise UserError(f"{folder}: its study asks for no figures; say what to draw with --y")
    for paths in [*figures, *([page] for page in pages)]:
        say("wrote " + ", ".join(str(path) for path in paths))
