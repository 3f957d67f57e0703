"""The plant of a study as an FMU: which case's it is, and the file."""

from collections.abc import Mapping
from pathlib import Path

from workbench.errors import UserError
from workbench.export.case import chosen_case
from workbench.export.fmi.fmu import Exported
from workbench.publish.folders import faults_told, write_whole
from workbench.simulation.setup import Setup
from workbench.study.study import Study
from workbench.study.unfold import unfold

SUFFIX = ".fmu"

BESIDE = ("controller", "reference")
"""Axes that do not change the plant: the first value of each will do."""


def chosen_plant(study: Study, where: Mapping[str, object]) -> Setup:
    """What the case runs that has these values of axes.

    Raises:
        UserError: none or several such cases, or a mistake in it.
    """
    axes = unfold(study).axes
    firsts = {axis: axes[axis][0] for axis in BESIDE if axis in axes}
    return chosen_case(study, {**firsts, **where})[1].setup


def check_ending(path: Path) -> None:
    """Raise UserError where a file is not to be called an FMU."""
    if path.suffix != SUFFIX:
        raise UserError(f"{path}: expected a name that ends in {SUFFIX}")


def write_fmu(made: Exported, path: Path, overwrite: bool = False) -> None:
    """Write an FMU, whole or not at all.

    Raises:
        UserError: another ending, or it is there already or cannot be written.
    """
    check_ending(path)
    if path.exists() and not overwrite:
        raise UserError(f"{path}: is there already; replace it with --overwrite")
    with faults_told(path.parent, "nothing is written: mend that and run it again"):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, lambda temporary: temporary.write_bytes(made.archive))
