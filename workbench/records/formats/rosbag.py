"""Bags of ROS 1 and 2."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.records.formats.interface import RecordFormat, joined, library

if TYPE_CHECKING:
    import pandas as pd

MOST_VALUES = 32
"""Of an array in a message, beyond which it is no set of channels but an image or a cloud."""

NANO = 1e-9


def read(path: Path) -> "pd.DataFrame":
    """All numbers of all messages by topic and field, over the stamps (s) of their headers, or of the bag.

    A bag of ROS 2 is a folder: any file of it will do.
    """
    import pandas as pd

    bags, stores = library("rosbags.highlevel", path), library("rosbags.typesys", path)
    bag = path.parent if path.suffix != ".bag" and (path.parent / "metadata.yaml").exists() else path
    known = stores.get_typestore(stores.Stores.LATEST)
    found: dict[str, dict[int, float]] = {}
    try:
        with bags.AnyReader([bag], default_typestore=known) as reader:
            for connection, stamp, raw in reader.messages():
                message = reader.deserialize(raw, connection.msgtype)
                header = getattr(getattr(message, "header", None), "stamp", None)
                nano = stamp if header is None else header.sec * 10**9 + header.nanosec
                for name, value in _numbers(message):
                    found.setdefault(f"{connection.topic.strip('/')}.{name}", {})[nano] = value
    except bags.AnyReaderError as error:
        raise ValueError(str(error)) from None
    first = min((min(values) for values in found.values()), default=0)
    columns = {name: pd.Series(values) for name, values in found.items()}
    return joined({name: values.set_axis(NANO * (values.index - first)) for name, values in columns.items()}, {})


def _numbers(value: Any, name: str = "") -> Iterator[tuple[str, float]]:
    """The numbers in a message, each by its dotted name."""
    if isinstance(value, bool | int | float):
        yield name, float(value)
    elif hasattr(value, "__dataclass_fields__"):
        for field in value.__dataclass_fields__:
            if field not in ("header", "__msgtype__"):
                yield from _numbers(getattr(value, field), f"{name}.{field}" if name else field)
    elif hasattr(value, "__len__") and not isinstance(value, str) and len(value) <= MOST_VALUES:
        for k, each in enumerate(value):
            yield from _numbers(each.item() if hasattr(each, "item") else each, f"{name}_{k}")


ROSBAG = RecordFormat("rosbag", "bags of ROS 1 and 2 (needs the extra formats)", (".bag", ".db3", ".mcap"), read)
