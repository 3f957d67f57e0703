"""workbench agree: two comparisons of the same, held against each other."""

from pathlib import Path
from typing import Annotated

import typer

from workbench.cli.options import Folder, say
from workbench.errors import UserError


def command(
    one: Folder,
    other: Annotated[Path, typer.Argument(help="Another folder of results of the same.", metavar="DIR")],
) -> None:
    """Say how many verdicts another comparison moves."""
    from workbench.compare.agreement import agreement, agreement_words
    from workbench.compare.comparison import comparison_in

    held = agreement(comparison_in(one).verdicts, comparison_in(other).verdicts)
    if not held.cells:
        raise UserError(f"{one} and {other} have no field in common: expected two comparisons of the same")
    say("\n".join(agreement_words(held)))
