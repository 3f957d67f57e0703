"""Linear models of a study's plant and loop, with names and units, for MATLAB and for python-control."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import control
import numpy as np
from scipy.io import savemat

from plants.equation import fields, to_array
from workbench.errors import UserError
from workbench.export.one_file import ends_in, new_file
from workbench.linear.equilibrium import at_rest, changing
from workbench.linear.linearise import linearise
from workbench.linear.open_loop import open_loop
from workbench.linear.operating_point import slide
from workbench.linear.slow_model import slow_model
from workbench.progress import Progress, silent
from workbench.publish.folders import write_whole
from workbench.simulation.setup import Numbers, Setup
from workbench.study.study import Case, Study
from workbench.toml.units import QuantityError, said_in

HEADER = 116
"""Bytes of a MAT file that are free text, in which SciPy writes the time."""

NOT_MEASURED = "1"
"""The unit of states that are in units of their own magnitude."""


@dataclass(frozen=True)
class LinearModel:
    """dx/dt = A x + B u, y = C x + D u, or with a sample time x+ = A x + B u; deviations from the point `at`.

    `units` are those of states, inputs and outputs; `at` holds states and inputs of the point, empty where the model
    has none of its own.
    """

    system: control.StateSpace
    units: tuple[Sequence[str], Sequence[str], Sequence[str]]
    at: tuple[np.ndarray, np.ndarray]
    said: str

    @property
    def content(self) -> dict[str, Any]:
        """What is written of it: matrices as arrays, names and units as lists of text."""
        system, (states, inputs, outputs) = self.system, self.units
        return {
            "A": system.A,
            "B": system.B,
            "C": system.C,
            "D": system.D,
            "dt": float(system.dt or 0.0),
            "states": list(system.state_labels),
            "inputs": list(system.input_labels),
            "outputs": list(system.output_labels),
            "state_units": list(states),
            "input_units": list(inputs),
            "output_units": list(outputs),
            "at_states": self.at[0],
            "at_inputs": self.at[1],
            "said": self.said,
        }


@dataclass(frozen=True)
class LinearExport:
    """Linear models by name, of one case of a study."""

    title: str
    case: Mapping[str, object]
    models: Mapping[str, LinearModel]

    def write(self, path: Path, overwrite: bool = False) -> None:
        """Write all models to a file, as its ending says: .mat or .json.

        Raises:
            UserError: another ending, or it is there already or cannot be written.
        """
        with new_file(path, WRITERS, overwrite):
            write_whole(path, lambda temporary: WRITERS[path.suffix](self, temporary))


def check_ending(path: Path) -> None:
    """Raise UserError where a file is to be of no kind that is written."""
    ends_in(path, WRITERS)


def linear_export(
    study: Study, case: Case, setup: Setup, speed: float | str | None = None, progress: Progress = silent
) -> LinearExport:
    """The linear models of a case of a study, which runs `setup`.

    rest         the plant at rest, turning as the study says, from all its inputs to all its signals
    and at a `speed` (m/s, or rad/s of an axis that turns; or text with its unit):
    sliding      the same while the rod slides at it, in the study's loop
    slow         two poles, from the command to the position: right at low frequency
    open_loop    L(z), sampled, broken behind the amplifier: plant, sensors and controller; closed it is 1/(1+L)

    Raises:
        UserError: no equilibrium at rest, or a loop that does not slide steadily at the speed.
    """
    state, inputs = at_rest(setup)
    if rates := changing(setup.plant, setup.parameters, state, inputs):
        raise UserError(f"{study.path}: {case.label}: the plant does not rest: {', '.join(rates)} would change")
    models = {"rest": _plant_model(setup, state, inputs, "the plant at rest; bristles are springs there")}
    if speed is not None:
        progress("sliding")
        models |= _sliding(setup, _si_speed(speed, setup), f"{study.path}: {case.label}")
    return LinearExport(study.file.title, case.columns, models)


def _si_speed(speed: float | str, setup: Setup) -> float:
    try:
        return said_in(str(speed), f"{setup.plant.axis}/s")
    except QuantityError as error:
        raise UserError(f"speed: {error}") from None


def _sliding(setup: Setup, speed: float, place: str) -> dict[str, LinearModel]:
    """The models of a slide; `place` is where a user finds the case.

    Raises:
        UserError: the loop does not slide steadily at that speed.
    """
    at = f"{speed:g} {setup.plant.axis}/s"
    point = slide(setup, speed)
    if point.trouble:
        raise UserError(f"{place}: the rod does not slide steadily at {at}: {point.trouble}; take another --speed")
    return {
        "sliding": _plant_model(setup, point.state, point.inputs, f"the plant sliding at {at}"),
        "slow": _slow(setup, speed, f"two poles of the plant sliding at {at}, right at low frequency"),
        "open_loop": _open_loop(setup, speed, f"L(z) at {at}, broken behind the amplifier; closed 1/(1+L)"),
    }


def _plant_model(setup: Setup, state: Numbers, inputs: Numbers, said: str) -> LinearModel:
    plant = setup.plant
    signals = [item.name for item in fields(plant.Signals)]
    units = tuple([item.unit for item in fields(cls)] for cls in (plant.State, plant.Inputs, plant.Signals))
    system = linearise(plant, setup.parameters, state, inputs, signals)
    return LinearModel(system, (units[0], units[1], units[2]), (to_array(state), to_array(inputs)), said)


def _slow(setup: Setup, speed: float, said: str) -> LinearModel:
    a, b = slow_model(setup, speed).matrices()
    axis, plant = setup.plant.axis, setup.plant
    names = {"states": ["position", "velocity"], "inputs": [plant.command], "outputs": ["position"]}
    system = control.ss(a, b, [[1.0, 0.0]], [[0.0]], **names)
    return LinearModel(system, ([axis, f"{axis}/s"], [plant.command_unit], [axis]), NOWHERE, said)


def _open_loop(setup: Setup, speed: float, said: str) -> LinearModel:
    found, command = open_loop(setup, speed), setup.plant.command
    system = control.ss(found, inputs=[command], outputs=[f"{command}_returned"])
    unit = setup.plant.command_unit
    return LinearModel(system, ([NOT_MEASURED] * system.nstates, [unit], [unit]), NOWHERE, said)


NOWHERE = (np.empty(0), np.empty(0))
"""The point of a model that has none of its own."""


def _write_json(export: LinearExport, path: Path) -> None:
    models = {
        name: {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in model.content.items()}
        for name, model in export.models.items()
    }
    content = {"title": export.title, "case": dict(export.case), "models": models}
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def _write_mat(export: LinearExport, path: Path) -> None:
    content: dict[str, Any] = {
        name: {key: _cells(value) if isinstance(value, list) else value for key, value in model.content.items()}
        for name, model in export.models.items()
    }
    with path.open("wb") as file:  # savemat would put an ending behind the name
        case = ", ".join(f"{axis} = {value}" for axis, value in export.case.items())
        savemat(file, {"title": export.title, "case": case, **content})
    with path.open("r+b") as file:
        file.write(b"MATLAB 5.0 MAT-file, written by Friction Workbench".ljust(HEADER))


def _cells(texts: Sequence[str]) -> np.ndarray:
    """Text as a column of cells."""
    cells = np.empty((len(texts), 1), dtype=object)
    cells[:, 0] = texts
    return cells


WRITERS: dict[str, Callable[[LinearExport, Path], None]] = {".mat": _write_mat, ".json": _write_json}
"""What writes a file, by its ending."""
