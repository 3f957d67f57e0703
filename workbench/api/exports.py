"""What goes on outside the program: a controller as C, a plant as an FMU, linear models, a study with that C in it."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import pandas as pd

from workbench.api.loops import A_LOOP, LoopSetup
from workbench.api.plain import Quantity, expect
from workbench.api.studies import Content, Study, as_study
from workbench.errors import UserError, nearest, spelled

if TYPE_CHECKING:
    from workbench.study.plan import Plan


def export_controller(
    setup: LoopSetup,
    out: str | Path,
    *,
    rotation: bool = False,
    precision: str = "double",
    overwrite: bool = False,
) -> Path:
    """The controller of a loop as C99, with its gains and a test that replays the loop's run (docs/export.md).

    Args:
        setup: the loop.
        out: folder for it: NAME.h, NAME.c, main.c, vector.h, Makefile, README.md.
        rotation: the controller of the rod's rotation instead.
        precision: of its numbers, "double" or "single".
        overwrite: replace what is in `out`.

    Returns:
        the folder.

    Raises:
        UserError: a controller that cannot be written as C or has no feedback, or a folder that does not serve.

    Example:
        >>> loop = wb.setup("non_rotating", "owen2001_simulation", controller=wb.pid(kp=500),
        ...                 reference=wb.sine("5 mm", "2 Hz"), duration="0.5 s")
        >>> sorted(path.name for path in wb.export_controller(loop, folder / "c").glob("*.c"))
        ['main.c', 'pid.c']
    """
    from workbench.export.c_controller import PRECISIONS
    from workbench.export.controller import controller_export

    expect(setup, LoopSetup, "export_controller", A_LOOP)
    if precision not in PRECISIONS:
        raise UserError(f'export_controller: unknown precision "{precision}"; {nearest(precision, PRECISIONS)}')
    made = controller_export(setup.study, setup.case, setup.simulation, rotation=rotation, precision=precision)
    made.write(Path(out), overwrite)
    return Path(out)


def export_linear(setup: LoopSetup, out: str | Path, *, speed: Quantity | None = None, overwrite: bool = False) -> Path:
    """The linear models of a loop's plant, with names and units, for MATLAB or python-control (docs/export.md).

    Args:
        setup: the loop.
        out: a file, written as its ending says: .mat or .json.
        speed: m/s, or rad/s of an axis that turns: of a slide, whose models are written beside those at rest.
        overwrite: replace the file.

    Returns:
        the file.

    Raises:
        UserError: another ending, a plant that does not rest, or a loop that does not slide steadily at the speed.

    Example:
        >>> import json
        >>> loop = wb.setup("rotating", "owen2001_simulation", rpm=120, controller=wb.pid(kp=500))
        >>> file = wb.export_linear(loop, folder / "plant.json", speed="30 mm/s")
        >>> list(json.loads(file.read_text())["models"])
        ['rest', 'sliding', 'slow', 'open_loop']
    """
    from workbench.export.linear import check_ending, linear_export

    expect(setup, LoopSetup, "export_linear", A_LOOP)
    check_ending(Path(out))
    linear_export(setup.study, setup.case, setup.simulation, speed).write(Path(out), overwrite)
    return Path(out)


def export_plant(setup: LoopSetup, out: str | Path, *, fmi: int = 2, overwrite: bool = False) -> Path:
    """The plant of a loop as an FMU, for co-simulation and model exchange in other tools (docs/fmi.md).

    Args:
        setup: the loop.
        out: a file that ends in .fmu.
        fmi: version of the Functional Mock-up Interface, 2 or 3.
        overwrite: replace the file.

    Returns:
        the file.

    Raises:
        UserError: another ending or version, a plant that is an FMU itself, or C that the compiler refuses.

    Example:
        >>> loop = wb.setup("non_rotating", "owen2001_simulation", controller=wb.pid(kp=500))
        >>> wb.export_plant(loop, folder / "plant.fmu", fmi=3).name
        'plant.fmu'
    """
    from workbench.export.fmi.fmu import VERSIONS, exported
    from workbench.export.fmi.plant import check_ending, write_fmu

    expect(setup, LoopSetup, "export_plant", A_LOOP)
    check_ending(Path(out))
    if fmi not in VERSIONS:
        raise UserError(f"export_plant: fmi is {spelled(fmi)}, expected 2 or 3")
    write_fmu(exported(setup.simulation, fmi, setup.study.file.title), Path(out), overwrite)
    return Path(out)


def rehearse(
    study: str | Path | Content | Study,
    out: str | Path | None = None,
    *,
    draws: int | None = None,
    jobs: int | None = None,
    overwrite: bool = False,
) -> pd.DataFrame:
    """Run a study with the exported C of its controllers, compiled, in the loop, beside the study itself.

    Args:
        study: a file, its content, or a `Study`.
        out: folder for the table and the C; without one nothing is kept.
        draws: of machines, in place of what the study says.
        jobs: cases at a time; default one a core.
        overwrite: replace what is in `out`.

    Returns:
        a row a figure of a case: as the study has it, as rehearsed, and the difference, with the digits of results.csv.

    Raises:
        UserError: no C compiler, a controller that cannot be written as C, or a mistake in the study.

    Example:
        >>> rows = wb.rehearse(small_study, jobs=1)
        >>> bool((rows["study"] == rows["rehearsed"]).all())
        True
    """
    from workbench.rehearse.folder import frame_of, write_rehearsal

    planned = _planned(as_study(study), draws)
    if out is not None:
        return frame_of(write_rehearsal(planned, Path(out), overwrite=overwrite, jobs=jobs).figures)
    with TemporaryDirectory() as folder:
        return frame_of(write_rehearsal(planned, Path(folder) / "rehearsal", jobs=jobs).figures)


def _planned(study: Study, draws: int | None) -> "Plan":
    from workbench.study.plan import plan
    from workbench.study.rounds import with_draws

    return study.plan if draws is None else plan(with_draws(study.content, "draws", draws, "uncertainty", "draws"))
