"""What other packages bring by entry point."""

import functools
import sys
from collections.abc import Mapping
from importlib.metadata import entry_points
from types import MappingProxyType
from typing import Any


def plugins(group: str) -> Mapping[str, Any]:
    """The objects behind the entry points of a group, by name; looked up once for each search path."""
    return _plugins(group, tuple(sys.path))


@functools.cache
def _plugins(group: str, search_path: tuple[str, ...]) -> Mapping[str, Any]:
    points = sorted(entry_points(group=group), key=lambda point: point.name)
    return MappingProxyType({point.name: point.load() for point in points})
