"""The binary of an FMU for the platform at hand, by gcc."""

import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from workbench.errors import UserError
from workbench.fmu.platforms import is_known, platform_here

FLAGS = ("-std=c99", "-Wall", "-pedantic", "-O2", "-ffp-contract=off", "-fPIC", "-fvisibility=hidden", "-shared")


def why_not() -> str:
    """Why no binary can be made here, "" where one can."""
    if not is_known():
        return f"no binary is made on {platform_here()}"
    return "" if shutil.which("gcc") else "gcc is not on the PATH"


def compiled(sources: Mapping[str, bytes]) -> bytes:
    """The shared library of these files, by name, of which those that end in .c are compiled.

    Raises:
        UserError: gcc fails, or warns.
    """
    with TemporaryDirectory() as folder:
        for name, content in sources.items():
            Path(folder, name).write_bytes(content)
        files = sorted(name for name in sources if name.endswith(".c"))
        command = ["gcc", *FLAGS, *files, "-o", "library", "-lm"]
        made = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if made.returncode != 0 or made.stderr:
            told = [line for line in made.stderr.splitlines() if "error" in line or "warning" in line]
            raise UserError(f"gcc cannot compile the plant: {(told or [f'it ends with {made.returncode}'])[0]}")
        return Path(folder, "library").read_bytes()
