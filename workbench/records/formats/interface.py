"""What a format of records is: the endings of its files, and how to read a table out of one."""

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.errors import UserError

if TYPE_CHECKING:
    import pandas as pd

UNITS = "units"
"""Of a table's attributes: the units that the file gives to its columns, by their names."""


@dataclass(frozen=True, eq=False)
class RecordFormat:
    """Files of one kind. `read` gives the table in a file as it stands there, or raises OSError or ValueError.

    Where the file knows the units of its columns they are in the table's `attrs`, by the columns' names.

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


def library(module: str, path: Path) -> Any:
    """A module that reads files of a format, of the extra `formats`.

    Raises:
        UserError: it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise UserError(
            f'{path}: {error.name} is needed to read it and is not installed: pip install "friction-workbench[formats]"'
        ) from None


def joined(columns: "Mapping[str, pd.Series[float]]", units: Mapping[str, str], clock: str = "time") -> "pd.DataFrame":
    """Series over their own stamps (s) as one table: a row for each stamp, NaN where a series has none there.

    Raises:
        ValueError: there is none.
    """
    import pandas as pd

    if not columns:
        raise ValueError("it holds no series of numbers")
    alone = {name: values[~values.index.duplicated()] for name, values in columns.items()}
    table = pd.DataFrame(alone).sort_index().rename_axis(clock).reset_index()
    table.attrs[UNITS] = {clock: "s", **{name: unit for name, unit in units.items() if unit}}
    return table
