"""Exceptions in the code of plug-ins, in one line."""

import traceback
from pathlib import Path

from plants.plugins import OURS, owner_of, reason_of


def of_plugin(error: Exception) -> str:
    """Which package's code failed, how, and where; "" where the code is this program's own."""
    for frame, line in reversed(list(traceback.walk_tb(error.__traceback__))):
        module = str(frame.f_globals.get("__name__", ""))
        if module.partition(".")[0] in OURS:
            return ""
        if owner := owner_of(module):
            code = frame.f_code
            return f'{owner}: {reason_of(error)}, in "{code.co_name}" ({Path(code.co_filename).name}, line {line})'
    return ""
