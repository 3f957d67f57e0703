"""workbench export notebook: a study as an executed notebook of the Python interface."""

from pathlib import Path
from typing import Annotated

import typer

from workbench.cli.export.options import CaseOf
from workbench.cli.options import Overwrite, StudyFile, conditions, say
from workbench.cli.planned import planned_study
from workbench.cli.progress import ProgressLine, stoppable


def command(
    study: StudyFile,
    out: Annotated[Path, typer.Option(help="The notebook; results lie beside it.", metavar="FILE.ipynb")],
    case: CaseOf = None,
    draws: Annotated[int | None, typer.Option(min=0, help="Draws of machines, instead of the study's number.")] = None,
    overwrite: Overwrite = False,
) -> None:
    """A study as a notebook in Python, executed."""
    from workbench.errors import UserError
    from workbench.export.notebook import write_notebook
    from workbench.study.names import in_words

    with stoppable("the notebook is not written; finished cases are kept beside it"), ProgressLine() as progress:
        planned = planned_study(study, out, draws)
        where = conditions(case, "--case")
        places = planned.cases.where(where)
        if not places.size:
            axes = ", ".join(planned.axes) or "none"
            raise UserError(f"{study}: no case with {in_words(where)}; the axes are {axes}")
        results = write_notebook(planned, out, int(places[0]), draws=draws, overwrite=overwrite, progress=progress)
    say(f"wrote {out}, and the results that it shows into {results}")
