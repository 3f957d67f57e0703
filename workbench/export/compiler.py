"""The C compiler of this machine."""

import os
import shlex
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from workbench.errors import UserError

FLAGS = ("-O2", "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off")
"""No warning is let through, and no product and sum are fused, which would round otherwise than the program."""


def compiler() -> list[str]:
    """The command by which C is compiled: what CC says, or cc.

    Raises:
        UserError: there is none.
    """
    wanted = shlex.split(os.environ.get("CC", "")) or ["cc"]
    if shutil.which(wanted[0]) is None:
        raise UserError(f'no C compiler: "{wanted[0]}" is not found on PATH; install one, or name it in CC')
    return wanted


def compiled_library(sources: Sequence[Path], library: Path, flags: Sequence[str] = FLAGS) -> Path:
    """Compile C files into a library that can be loaded.

    Raises:
        UserError: there is no compiler, or it refuses them.
    """
    command = [*compiler(), *flags, "-fPIC", "-shared", "-o", str(library), *map(str, sources), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines()
        raise UserError(f"{command[0]} refuses {sources[0].name}: {' '.join(lines[:1])}")
    return library
