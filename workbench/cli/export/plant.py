"""workbench export plant: the plant of a study as an FMU."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from workbench.cli.export.options import CaseOf
from workbench.cli.options import Overwrite, StudyFile, conditions, say


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
    from workbench.export.fmi.plant import check_place, plant_export, write_fmu
    from workbench.study.reading import read_study

    check_place(out, overwrite)
    made = plant_export(read_study(study), conditions(case, "--case"), int(fmi.value))
    write_fmu(made, out)
    say(f"wrote {out}: FMI {fmi.value}.0, co-simulation and model exchange")
    for kind, names in (("inputs", made.inputs), ("states", made.states), ("outputs", made.outputs)):
        say(f"  {kind}: {', '.join(names)}")
    say(f"  parameters: {made.parameters}, each tunable, in SI")
    if made.lacking:
        say(f"  sources alone, since {made.lacking}: an importer that compiles them can run it, no other")
