"""The binary of an FMU, loaded: from here on foreign code runs."""

import ctypes
import functools
import os
import shutil
from pathlib import Path
from tempfile import mkdtemp

from plants.cache import cache_folder
from workbench.errors import UserError, few_of, shortened
from workbench.fmu.archive import sha256_of, unpack
from workbench.fmu.description import Fmu
from workbench.fmu.platforms import binary_place, is_known, platform_here


def check_platform(fmu: Fmu) -> None:
    """Raise UserError where an FMU has no binary for this platform."""
    if not is_known() or binary_place(fmu.fmi, fmu.identifier) not in fmu.files:
        others = sorted(
            {name.split("/")[1] for name in fmu.files if name.startswith("binaries/") and name.count("/") > 1}
        )
        raise UserError(f"{fmu.path}: has no binary for {platform_here()}; it has {few_of(others) or 'none'}")


def loaded(fmu: Fmu) -> tuple[ctypes.CDLL, Path]:
    """The library of an FMU, and the folder that it is unpacked in.

    Raises:
        UserError: there is none for this platform, or it cannot be loaded.
    """
    check_platform(fmu)
    return _loaded(fmu)


@functools.cache
def _loaded(fmu: Fmu) -> tuple[ctypes.CDLL, Path]:
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
