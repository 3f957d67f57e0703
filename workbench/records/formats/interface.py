"""What a format of records is: the endings of its files, and how to read a table out of one."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class RecordFormat:
    """Files of one kind. `read` gives the table in a file as it stands there, or raises OSError or ValueError.

    Attributes:
        name: of the format.
        summary: what it is, in words.
        endings: of its files' names, such as ".parquet"; a file of no known ending is text.
        read: imports what it needs when it is called: a list of formats does without.
    """

    name: str
    summary: str
    endings: tuple[str, ...]
    read: "Callable[[Path], pd.DataFrame]"
