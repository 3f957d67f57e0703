"""workbench list: what a study may name."""

from typing import Annotated

import typer

from workbench.cli.options import say
from workbench.errors import UserError, nearest


def command(
    kind: Annotated[
        str | None,
        typer.Argument(
            help="plants, friction_laws, controllers, parameters, machines, scenarios, references, effects, "
            "integrators or columns."
        ),
    ] = None,
) -> None:
    """List what a study may name, and effects that a diagnosis knows."""
    from workbench.catalogue import CATALOGUE

    if kind is not None and kind not in CATALOGUE:
        raise UserError(f'nothing called "{kind}" to list; {nearest(kind, CATALOGUE)}')
    for name in CATALOGUE if kind is None else (kind,):
        say(name)
        say("\n".join(f"  {line}" for line in CATALOGUE[name]()))
