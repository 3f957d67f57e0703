"""workbench list: what a study may name."""

from typing import Annotated

import typer

from workbench.errors import UserError, nearest


def command(
    kind: Annotated[
        str | None,
        typer.Argument(
            help="plants, controllers, parameters, machines, scenarios, references, effects, integrators or columns."
        ),
    ] = None,
) -> None:
    """List what a study may name, and effects that a diagnosis knows."""
    from workbench.catalogue import catalogue

    sections = catalogue()
    if kind is not None and kind not in sections:
        raise UserError(f'nothing called "{kind}" to list; {nearest(kind, sections)}')
    for name, lines in sections.items():
        if kind in (None, name):
            print(name)
            print("\n".join(f"  {line}" for line in lines))
