"""Where the program keeps what it can make again: compiled code, factors between units."""

import os
from pathlib import Path


def cache_folder() -> Path:
    """The program's folder in the user's cache."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "friction-workbench"
