"""The binary of an FMU for the platform at hand, by gcc."""

import platform
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from workbench.errors import UserError

FLAGS = ("-std=c99", "-Wall", "-pedantic", "-O2", "-ffp-contract=off", "-fPIC", "-fvisibility=hidden", "-shared")

PLATFORMS = {
    ("Linux", "x86_64"): {2: "linux64", 3: "x86_64-linux"},
    ("Linux", "aarch64"): {2: "aarch64-linux", 3: "aarch64-linux"},
    ("Darwin", "x86_64"): {2: "darwin64", 3: "x86_64-darwin"},
    ("Darwin", "arm64"): {2: "aarch64-darwin", 3: "aarch64-darwin"},
}
"""FMI's names of platforms, by version, for those where gcc makes what is loaded there."""

SUFFIX = {"Linux": ".so", "Darwin": ".dylib"}


def why_not() -> str:
    """Why no binary can be made here, "" where one can."""
    if (platform.system(), platform.machine()) not in PLATFORMS:
        return f"no binary is made on {platform.system()} {platform.machine()}"
    return "" if shutil.which("gcc") else "gcc is not on the PATH"


def place_of(fmi: int, identifier: str) -> str:
    """Where the binary of this platform lies in an FMU."""
    folder = PLATFORMS[platform.system(), platform.machine()][fmi]
    return f"binaries/{folder}/{identifier}{SUFFIX[platform.system()]}"


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
