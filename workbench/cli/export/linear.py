"""workbench export linear: the linear models of a study's plant, for MATLAB or python-control."""

from pathlib import Path
from typing import Annotated

import typer

from workbench.cli.export.options import CaseOf, ControllerOf
from workbench.cli.options import Overwrite, StudyFile, conditions, say
from workbench.cli.planned import study_at
from workbench.cli.progress import ProgressLine, stoppable


def command(
    study: StudyFile,
    out: Annotated[Path, typer.Option(help="What to write, by its ending.", metavar="FILE.mat|FILE.json")],
    speed: Annotated[
        str | None, typer.Option(help='Of a slide, such as "30 mm/s": its models too.', metavar="SPEED")
    ] = None,
    controller: ControllerOf = None,
    case: CaseOf = None,
    overwrite: Overwrite = False,
) -> None:
    """Linear models of a study's plant, as .mat or .json."""
    from workbench.export.case import chosen_case
    from workbench.export.linear import check_ending, linear_export
    from workbench.study.fmu_plant import refuse_fmu

    check_ending(out)
    with stoppable(), ProgressLine() as progress:
        content = study_at(study)
        refuse_fmu(content, "export linear")
        chosen, resolved = chosen_case(content, conditions(case, "--case"), controller)
        found = linear_export(content, chosen, resolved.setup, speed, progress)
        found.write(out, overwrite)
    for name, model in found.models.items():
        system = model.system
        say(f"  {name}: {model.said}; {system.nstates} states, {system.ninputs} in, {system.noutputs} out")
    say(f"wrote {out}")
