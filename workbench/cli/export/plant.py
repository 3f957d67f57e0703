"""workbench export plant: the plant of a study as an FMU."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from workbench.cli.export.options import CaseOf
from workbench.cli.options import Overwrite, StudyFile, conditions, say
from workbench.cli.planned import study_at
from workbench.cli.progress import stoppable


class Fmi(StrEnum):
    """Version of the standard."""

    two = "2"
    three = "3"


def command(
    study: StudyFile,
    out: Annotated[Path, typer.Option(help="The FMU: a file that ends in .fmu.", metavar="FILE.fmu")],
    fmi: Annotated[Fmi, typer.Option(help="Version of the Functional Mock-up Interface.")] = Fmi.two,
    case: CaseOf = None,
    overwrite: Overwrite = False,
) -> None:
    """A study's plant as an FMU, for Simulink, OpenModelica, Dymola."""
    from workbench.export.fmi.fmu import exported
    from workbench.export.fmi.plant import check_ending, chosen_plant, write_fmu

    check_ending(out)
    with stoppable():
        content = study_at(study)
        made = exported(chosen_plant(content, conditions(case, "--case")), int(fmi.value), content.file.title)
        write_fmu(made, out, overwrite)
    for kind, names in (("inputs", made.inputs), ("states", made.states), ("outputs", made.outputs)):
        say(f"  {kind}: {', '.join(names)}")
    say(f"  parameters: {made.parameters}, each tunable, in SI")
    if made.lacking:
        say(f"  sources alone, no binary: {made.lacking}; an importer that compiles them can run it, no other")
    say(f"wrote {out}: FMI {fmi.value}.0, co-simulation and model exchange")
