"""The binary of an FMU for the platform at hand."""

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from workbench.errors import UserError
from workbench.export.compiler import compiled_library, compiler
from workbench.fmu.platforms import is_known, platform_here

FLAGS = ("-O2", "-std=c99", "-pedantic", "-Wall", "-Werror", "-ffp-contract=off", "-fvisibility=hidden")
"""No warning is let through, no product and sum are fused, and nothing is to be seen but the functions of FMI."""


def why_not() -> str:
    """Why no binary can be made here, "" where one can."""
    if not is_known():
        return f"FMI has no name for {platform_here()}"
    try:
        compiler()
    except UserError as error:
        return str(error)
    return ""


def compiled(sources: Mapping[str, bytes]) -> bytes:
    """The shared library of these files, by name, of which those that end in .c are compiled.

    Raises:
        UserError: the compiler refuses them.
    """
    with TemporaryDirectory() as folder:
        for name, content in sources.items():
            Path(folder, name).write_bytes(content)
        files = [Path(folder, name) for name in sorted(sources) if name.endswith(".c")]
        return compiled_library(files, Path(folder, "library"), FLAGS).read_bytes()
