"""The program's own commands, run as a user runs them, and what each of them took."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

WORKBENCH = (sys.executable, "-c", "from workbench.cli import main; main()")
NUMPY = (sys.executable, "-c", "import numpy")
"""What every start of a program with arrays pays: starts are told in multiples of it."""


@dataclass(frozen=True)
class Usage:
    """Of a command and all processes that it started: wall time and processor time (s), and the largest resident memory
    (bytes) of any one of them.
    """

    wall: float
    processor: float
    memory: int


def usage(command: Sequence[str | Path], folder: Path) -> Usage:
    """Run a command in `folder` to its end. Python may keep its bytecode, as it does for a user.

    Raises:
        RuntimeError: it fails; with what it said.
    """
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    with tempfile.TemporaryFile("w+") as said:
        begin = time.perf_counter()
        process = subprocess.Popen(command, cwd=folder, env=environment, stdout=said, stderr=subprocess.STDOUT)
        _, status, used = os.wait4(process.pid, 0)
        wall = time.perf_counter() - begin
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            said.seek(0)
            raise RuntimeError(f"{' '.join(map(str, command))}: exit code {process.returncode}: {said.read()[-2000:]}")
    unit = 1 if sys.platform == "darwin" else 1024
    return Usage(wall, used.ru_utime + used.ru_stime, used.ru_maxrss * unit)


def workbench(*arguments: str | Path, folder: Path) -> Usage:
    """What `workbench ARGUMENTS` takes in `folder`."""
    return usage((*WORKBENCH, *arguments), folder)
