"""The formats of records by name: ours, and those that other packages bring by entry point."""

from pathlib import Path

from plants.plugins import Registry
from workbench.records.formats.interface import RecordFormat
from workbench.records.formats.mat import MAT
from workbench.records.formats.mdf import MDF
from workbench.records.formats.parquet import PARQUET
from workbench.records.formats.rosbag import ROSBAG
from workbench.records.formats.tdms import TDMS
from workbench.records.formats.text import TEXT

_OURS = (TEXT, PARQUET, MAT, TDMS, MDF, ROSBAG)


def _check(one: RecordFormat) -> None:
    taken = [ending for ours in _OURS for ending in ours.endings if ending in one.endings]
    if taken or not all(ending.startswith(".") for ending in one.endings):
        raise ValueError(f"endings {', '.join(one.endings)}: expected such as .jsonl, none of {', '.join(taken)}")


FORMATS = Registry("friction_workbench.formats", RecordFormat, {one.name: one for one in _OURS}, _check)


def format_of(path: Path) -> RecordFormat:
    """The format of a file by the ending of its name; text, where no format has that."""
    return next((one for one in FORMATS.working().values() if path.suffix.lower() in one.endings), TEXT)
