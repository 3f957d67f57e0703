"""workbench index: one page over all results of a folder."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    folder: Annotated[Path, typer.Argument(help="A folder that holds folders of results.", metavar="[DIR]")] = Path(
        "results"
    ),
) -> None:
    """Write a page over all results in a folder."""
    from workbench.publish.page.index import write_index

    path, count = write_index(folder)
    print(f"wrote {path}: {count} result{'s' * (count != 1)}")
