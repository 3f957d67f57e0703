"""The plant of a study as an FMU: which case's it is, and the file."""

from collections.abc import Mapping
from pathlib import Path

from workbench.export.case import chosen_case
from workbench.export.fmi.fmu import Exported
from workbench.export.one_file import ends_in, new_file
from workbench.publish.folders import write_whole
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
    ends_in(path, (SUFFIX,))


def write_fmu(made: Exported, path: Path, overwrite: bool = False) -> None:
    """Write an FMU, whole or not at all.

    Raises:
        UserError: another ending, or it is there already or cannot be written.
    """
    with new_file(path, (SUFFIX,), overwrite):
        write_whole(path, lambda temporary: temporary.write_bytes(made.archive))
