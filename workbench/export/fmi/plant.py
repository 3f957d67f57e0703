"""The plant of a study as an FMU."""

from collections.abc import Mapping
from pathlib import Path

from workbench.errors import UserError
from workbench.export.case import chosen_case
from workbench.export.fmi.fmu import Exported, exported
from workbench.publish.folders import unwritable, write_whole
from workbench.study.study import Study
from workbench.study.unfold import unfold

SUFFIX = ".fmu"

BESIDE = ("controller", "reference")
"""Axes that do not change the plant: the first value of each will do."""


def plant_export(study: Study, where: Mapping[str, object], fmi: int) -> Exported:
    """The plant of the case that has these values of axes, as an FMU of version `fmi`.

    Raises:
        UserError: none or several such cases, a mistake in it, or gcc cannot compile it.
    """
    axes = unfold(study).axes
    firsts = {axis: axes[axis][0] for axis in BESIDE if axis in axes}
    _, resolved = chosen_case(study, {**firsts, **where})
    return exported(resolved.setup, fmi, study.file.title)


def check_place(out: Path, overwrite: bool) -> None:
    """Raise UserError where no FMU is written to `out`."""
    if out.suffix != SUFFIX:
        raise UserError(f"--out {out}: expected the name of a file that ends in {SUFFIX}")
    if out.is_dir():
        raise UserError(f"{out}: is a folder; expected the name of a file")
    if out.exists() and not overwrite:
        raise UserError(f"{out}: is there already; replace it with --overwrite")


def write_fmu(made: Exported, out: Path) -> None:
    """Write an FMU, whole or not at all.

    Raises:
        UserError: it cannot be written there.
    """
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        write_whole(out, lambda path: path.write_bytes(made.archive))
    except OSError as error:
        raise unwritable(out, error) from None
