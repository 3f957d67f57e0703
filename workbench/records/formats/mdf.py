"""MDF files (ASAM), as measurement tools of vehicles write them."""

from pathlib import Path
from typing import TYPE_CHECKING

from workbench.records.formats.interface import RecordFormat, joined, library

if TYPE_CHECKING:
    import pandas as pd


def read(path: Path) -> "pd.DataFrame":
    """All channels of numbers over the stamps of all: NaN where a slower one has no value."""
    import pandas as pd

    columns: dict[str, pd.Series[float]] = {}
    units: dict[str, str] = {}
    asammdf, known = library("asammdf", path), library("asammdf.blocks.utils", path)
    try:
        file = asammdf.MDF(path)
    except known.MdfException as error:
        raise ValueError(str(error)) from None
    with file:
        for signal in file.iter_channels(skip_master=True):
            if signal.samples.dtype.kind not in "iufb" or signal.samples.ndim != 1 or signal.samples.size < 2:
                continue
            name = signal.name if signal.name not in columns else f"{signal.name}.{len(columns)}"
            columns[name] = pd.Series(signal.samples, index=signal.timestamps)
            units[name] = signal.unit
    return joined(columns, units)


MDF = RecordFormat("mdf", "ASAM's MDF 3 and 4 (needs the extra formats)", (".mf4", ".mdf"), read)
