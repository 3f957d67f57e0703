"""A controller of a study as C: the files of its folder."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from controllers.open_loop import OPEN_LOOP
from plants.equation import fields
from workbench.errors import UserError
from workbench.export.c_controller import Exported, c_name
from workbench.export.recorded import recorded
from workbench.export.vector import Replay, replay_of, vector_text
from workbench.progress import Progress, silent
from workbench.publish.folders import ResultFolder
from workbench.simulation.setup import Loop, Setup
from workbench.simulation.simulate import simulate
from workbench.study.store import write_json
from workbench.study.study import Case, Study, named

RECORD = "export.json"
"""What is exported, in short; it is there only where all is."""


@dataclass(frozen=True)
class ControllerExport:
    """A controller to be written, its test vector, and the columns of its case."""

    exported: Exported
    replay: Replay
    case: Mapping[str, object]

    @property
    def folder(self) -> ResultFolder:
        """What is written."""
        name = self.exported.name
        return ResultFolder(
            "controller", (RECORD, f"{name}.h", f"{name}.c", "main.c", "vector.h", "Makefile", "README.md")
        )

    def write(self, out: Path, overwrite: bool = False) -> list[str]:
        """Write the folder, whole or not at all; returns the names of its files.

        Raises:
            UserError: it holds such files already, or cannot be written.
        """
        folder = self.folder
        with folder.claimed(out, overwrite):
            folder.write(out, self._fill)
        return [name for name in folder.names if name != RECORD]

    def _fill(self, folder: Path) -> None:
        exported, used = self.exported, self.exported.recorded.used
        sizes = {"state": len(used.state), "settings": len(used.gains) + 3}
        texts = {
            f"{exported.name}.h": exported.text("controller.h"),
            f"{exported.name}.c": exported.text("controller.c"),
            "main.c": exported.text("main.c"),
            "vector.h": vector_text(exported, self.replay),
            "Makefile": exported.text("Makefile"),
            "README.md": exported.text("README.md", sizes=sizes),
        }
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
        write_json(folder / RECORD, self._record())

    def _record(self) -> dict[str, object]:
        exported = self.exported
        return {
            "title": exported.title,
            "case": dict(self.case),
            "controller": exported.recorded.controller.name,
            "name": exported.name,
            "precision": exported.precision,
            "sample_time_s": exported.sample_time,
            "operations": exported.counted,
        }


def controller_export(
    study: Study,
    case: Case,
    setup: Setup,
    *,
    rotation: bool = False,
    precision: str = "double",
    progress: Progress = silent,
) -> ControllerExport:
    """The controller of a case of a study, recorded, and run for its test vector.

    Args:
        study: the study.
        case: one of its cases.
        setup: what the case runs.
        rotation: the controller of the rotation instead.
        precision: "double" or "single".
        progress: told what is done.

    Raises:
        UserError: a controller that cannot be written, or one without feedback.
    """
    loop = setup.rotary if rotation else setup.loop
    if loop is None:
        raise UserError(f"{study.path}: {case.label}: nothing controls the rotation; leave --rotation out")
    if loop.controller is OPEN_LOOP:
        raise UserError(f"{study.path}: {case.label}: open_loop has no feedback; its command is the reference itself")
    name = c_name("rotation" if rotation else named(case, "controller"))
    exported = exported_loop(setup, loop, name, f"{study.file.title} ({case.label})", precision)
    progress("simulating the study's run")
    return ControllerExport(exported, replay_of(setup, simulate(setup), rotation), case.columns)


def exported_loop(setup: Setup, loop: Loop, name: str, title: str, precision: str) -> Exported:
    """A loop of a setup, its position loop or its rotary one, as it is to be written.

    Raises:
        UserError: its controller cannot be written as C.
    """
    plant, turns = setup.plant, loop is setup.rotary
    driven = plant.rotary_command if turns else (loop.drives or plant.command)
    assert driven is not None
    place = plant.input_index(driven)
    limit = np.inf
    if turns:
        limit = float(plant.rotary_limit(setup.parameters))
    elif driven == plant.command:
        limit = float(plant.command_limit(setup.parameters))
    return Exported(
        recorded(loop.controller, plant.channels),
        name,
        loop.gains,
        setup.sample_time,
        limit,
        float(setup.inputs[place]),
        fields(plant.Inputs)[place].unit,
        plant.unit_for,
        turns,
        title,
        precision,
    )
