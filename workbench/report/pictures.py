"""A figure that stands on a page."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Picture:
    """A figure that was written: its PNG, and what it shows in words."""

    path: Path
    caption: str
