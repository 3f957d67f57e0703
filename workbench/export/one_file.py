"""What is written as one file."""

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from workbench.errors import UserError
from workbench.publish.folders import faults_told


def ends_in(path: Path, endings: Collection[str]) -> None:
    """Raise UserError where a name has none of these endings."""
    if path.suffix not in endings:
        raise UserError(f"{path}: expected a name that ends in {' or '.join(endings)}")


@contextmanager
def new_file(path: Path, endings: Collection[str], overwrite: bool) -> Iterator[None]:
    """Around the writing of a file, whose folder is made.

    Raises:
        UserError: another ending, or it is there already or cannot be written.
    """
    ends_in(path, endings)
    if path.exists() and not overwrite:
        raise UserError(f"{path}: is there already; replace it with --overwrite")
    with faults_told(path.parent, "nothing is written: mend that and run it again"):
        path.parent.mkdir(parents=True, exist_ok=True)
        yield
