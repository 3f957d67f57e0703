"""workbench agree: two comparisons of the same, held against each other."""

from pathlib import Path
from typing import Annotated

import typer

from workbench.cli.options import Folder
from workbench.errors import UserError


def command(
    one: Folder,
    other: Annotated[Path, typer.Argument(help="Another folder of results of the same.", metavar="DIR")],
) -> None:
    """Say how many verdicts another comparison moves."""
    from workbench.compare.agreement import agreement
    from workbench.compare.results import verdicts_of

    found = agreement(verdicts_of(one), verdicts_of(other))
    if not found.cells:
        raise UserError(f"{one} and {other} have no field in common: expected two comparisons of the same")
    print("\n".join(found.words))
