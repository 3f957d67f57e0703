"""The binary of an FMU, loaded: from here on foreign code runs."""

import ctypes
import functools
import os
import shutil
from pathlib import Path
from tempfile import mkdtemp

from plants.cache import cache_folder
from workbench.errors import UserError, shortened
from workbench.fmu.archive import sha256_of, unpack
from workbench.fmu.description import Fmu
from workbench.fmu.platforms import binary_place


@functools.cache
def loaded(fmu: Fmu) -> tuple[ctypes.CDLL, Path]:
    """The library of an FMU that has one for this platform, and the folder that it is unpacked in.

    Raises:
        UserError: it cannot be loaded.
    """
    folder = _unpacked(fmu)
    try:
        return ctypes.CDLL(str(folder / binary_place(fmu.fmi, fmu.identifier))), folder
    except OSError as error:
        raise UserError(f"{fmu.path}: its binary cannot be loaded ({shortened(str(error), 150)})") from None


def _unpacked(fmu: Fmu) -> Path:
    """The FMU's binary and resources in the user's cache, by its hash: unpacked once, whole or not at all."""
    place = cache_folder() / "fmu" / fmu.sha256
    if place.is_dir():
        return place
    place.parent.mkdir(parents=True, exist_ok=True)
    folder = Path(mkdtemp(dir=place.parent))
    try:
        unpack(fmu.path, folder, (str(Path(binary_place(fmu.fmi, fmu.identifier)).parent) + "/", "resources/"))
        if sha256_of(fmu.path) != fmu.sha256:
            raise UserError(f"{fmu.path}: has changed while it was read; run it again")
        (folder / "resources").mkdir(exist_ok=True)
        os.rename(folder, place)
    except OSError:
        if not place.is_dir():  # else another process was faster
            raise
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return place
