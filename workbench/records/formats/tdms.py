"""TDMS files of LabVIEW."""

from pathlib import Path
from typing import TYPE_CHECKING

from workbench.records.formats.interface import RecordFormat, joined, library

if TYPE_CHECKING:
    import pandas as pd


def read(path: Path) -> "pd.DataFrame":
    """All channels of numbers, by group and name where there are several groups.

    A waveform has stamps of its own; channels without share the rows of their group, over a time that is the row.
    """
    import numpy as np
    import pandas as pd

    with library("nptdms", path).TdmsFile.read(path) as file:
        groups = [group for group in file.groups() if group.channels()]
        every = [(group, channel) for group in groups for channel in group.channels()]
        stamped = any("wf_increment" in channel.properties for _, channel in every)
        columns, units = {}, {}
        for group, channel in every:
            values = channel[:]
            if values.dtype.kind == "M":
                values = (values - values[0]) / np.timedelta64(1, "s")
            if values.dtype.kind not in "iufb" or not values.size:
                continue
            name = f"{group.name}.{channel.name}" if len(groups) > 1 else channel.name
            clock = channel.time_track() if "wf_increment" in channel.properties else np.arange(values.size)
            columns[name] = pd.Series(values, index=np.asarray(clock, dtype=float))
            units[name] = str(channel.properties.get("unit_string", ""))
    if stamped:
        return joined(columns, units)
    table = joined(columns, units, "row").drop(columns="row")
    table.attrs["units"].pop("row")
    return table


TDMS = RecordFormat("tdms", "LabVIEW's TDMS (needs the extra formats)", (".tdms",), read)
