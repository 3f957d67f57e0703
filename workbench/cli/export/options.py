"""What the commands that export have in common."""

from typing import Annotated

import typer

CaseOf = Annotated[
    list[str] | None,
    typer.Option(help="The case with this value of an axis: rpm=460. May be repeated.", metavar="AXIS=VALUE"),
]

ControllerOf = Annotated[
    str | None, typer.Option(help="One of the study's controllers, where it has several.", metavar="NAME")
]
