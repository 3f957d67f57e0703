"""Parquet."""

from pathlib import Path
from typing import TYPE_CHECKING

from workbench.records.formats.interface import RecordFormat

if TYPE_CHECKING:
    import pandas as pd


def read(path: Path) -> "pd.DataFrame":
    """All columns."""
    import pandas as pd

    return pd.read_parquet(path)


PARQUET = RecordFormat("parquet", "Parquet, as studies write records", (".parquet",), read)
