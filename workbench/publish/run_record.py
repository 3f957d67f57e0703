"""What run.json says of how results came about: time, jobs, versions, machine."""

import platform
import time
from collections.abc import Sequence
from importlib.metadata import version

from plants.equation import EQUATION_FOLDERS, source_hash
from workbench.parallel.workers import job_count

PACKAGES = ("numpy", "numba", "scipy", "pandas", "control", "casadi")
"""Packages on whose version results may depend."""


def ran_on(began: float, jobs: int | str | None, packages: Sequence[str] = PACKAGES) -> dict[str, object]:
    """How long it took since `began` (s since the epoch; 0 by a clock that was set back meanwhile), on what, and with
    which versions of `packages`.

    `jobs` is how many ran at a time (None: one a core), or the address of a cluster.
    """
    return {
        "wall_seconds": round(max(time.time() - began, 0.0), 3),
        "started": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(began)),
        "jobs": jobs if isinstance(jobs, str) else job_count(jobs),
        "versions": versions(packages),
        "machine": {"system": platform.system(), "machine": platform.machine(), "cores": job_count(None)},
    }


def versions(packages: Sequence[str] = PACKAGES) -> dict[str, str]:
    """Of Python and of `packages`."""
    return {"python": platform.python_version(), **{name: version(name) for name in packages}}


def made_by(*folders: str) -> dict[str, object]:
    """The versions of the program, by its equations and the source files in `folders`, and of packages."""
    return {"version of the program": source_hash((*EQUATION_FOLDERS, *folders)), "versions": versions()}
