"""workbench index: one page over all results of a folder."""

from pathlib import Path
from typing import Annotated

import typer

from workbench.cli.options import say


def command(
    folder: Annotated[Path, typer.Argument(help="A folder that holds folders of results.", metavar="[DIR]")] = Path(
        "results"
    ),
) -> None:
    """Write a page over all results in a folder."""
    from workbench.publish.page.index import write_index

    path, count = write_index(folder)
    say(f"wrote {path}: {count} result{'s' * (count != 1)}")
