"""Exceptions in the code of plug-ins, in one line."""

import traceback
from pathlib import Path

from plants.plugins import OURS, owner_of


def of_plugin(error: Exception) -> str:
    """Which package's code failed, how, and where; "" where the code is this program's own."""
    for frame, line in reversed(list(traceback.walk_tb(error.__traceback__))):
        module = str(frame.f_globals.get("__name__", ""))
        if module.partition(".")[0] in OURS:
            return ""
        if owner := owner_of(module):
            reason = " ".join(f"{type(error).__name__}: {error}".split())
            return (
                f'{owner}: {reason}, in "{frame.f_code.co_name}" ({Path(frame.f_code.co_filename).name}, line {line})'
            )
    return ""
