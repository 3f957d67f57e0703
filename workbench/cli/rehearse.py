"""workbench rehearse: a study with its controllers as the C that is exported."""

from typing import Annotated

import typer

from workbench.cli.options import Out, Overwrite, StudyFile, print_contents, print_tables, print_warnings, say
from workbench.cli.planned import planned_study, study_at


def command(
    study: StudyFile,
    out: Out,
    jobs: Annotated[int | None, typer.Option(min=1, help="Cases at a time; default: one a core.")] = None,
    draws: Annotated[int | None, typer.Option(min=0, help="Draws of machines, instead of the study's number.")] = None,
    overwrite: Overwrite = False,
) -> None:
    """Run a study with the exported C in the loop."""
    from workbench.cli.progress import ProgressBar, stoppable
    from workbench.export.compiler import compiler
    from workbench.rehearse.folder import FOLDER, write_rehearsal
    from workbench.study.description import description
    from workbench.study.fmu_plant import refuse_fmu

    with stoppable():
        compiler()
        FOLDER.check(out, overwrite)
        refuse_fmu(study_at(study), "rehearse")
        planned = planned_study(study, out, draws)
        say("\n".join(description(planned)))
        print_warnings(planned.warnings)
        with ProgressBar(len(planned.cases)) as progress:
            done = write_rehearsal(planned, out, overwrite=overwrite, jobs=jobs, progress=progress)
    print_tables([done.table])
    print_contents(out)
    say(done.summary)
    if done.different:
        raise typer.Exit(1)
