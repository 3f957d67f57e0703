"""workbench export controller: a controller of a study as C."""

from enum import StrEnum
from typing import Annotated

import typer

from workbench.cli.export.options import CaseOf, ControllerOf
from workbench.cli.options import Out, Overwrite, StudyFile, conditions, say
from workbench.cli.planned import study_at
from workbench.cli.progress import ProgressLine, stoppable


class Precision(StrEnum):
    """Of numbers in C."""

    double = "double"
    single = "single"


def command(
    study: StudyFile,
    out: Out,
    controller: ControllerOf = None,
    case: CaseOf = None,
    rotation: Annotated[bool, typer.Option("--rotation", help="The controller of the rod's rotation instead.")] = False,
    precision: Annotated[Precision, typer.Option(help="Of its numbers.")] = Precision.double,
    overwrite: Overwrite = False,
) -> None:
    """A controller with its gains as C99, and its test."""
    from workbench.export.case import chosen_case
    from workbench.export.controller import controller_export
    from workbench.study.fmu_plant import refuse_fmu

    with stoppable(), ProgressLine() as progress:
        content = study_at(study)
        refuse_fmu(content, "export controller")
        chosen, resolved = chosen_case(content, conditions(case, "--case"), controller)
        setup = resolved.setup
        made = controller_export(
            content, chosen, setup, rotation=rotation, precision=precision.value, progress=progress
        )
        files = made.write(out, overwrite)
    exported = made.exported
    say(f"{exported.name}: {exported.title}")
    say(f"  a step takes at most {exported.operations}")
    say(f"  measured: {', '.join(channel for channel, _ in exported.measured) or 'nothing'}")
    say(f"  {len(made.replay.commands)} steps of the study's run to replay: make -C {out} test")
    say(f"wrote {out}: {', '.join(files)}")
