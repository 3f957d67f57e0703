"""Exported controllers in the program's own loop: their C, compiled, in place of the compiled equations."""

import ctypes
from collections.abc import Collection
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from controllers.interface import Controller, Reference
from controllers.open_loop import OPEN_LOOP
from plants.equation import from_array, to_array
from plants.interface import Measurement
from workbench.export.c_controller import Exported, c_name
from workbench.export.compiler import compiled_library
from workbench.export.controller import exported_loop
from workbench.export.recorded import in_c
from workbench.export.walk import Path as NumberPath
from workbench.export.walk import number_paths
from workbench.simulation.compilation import CompiledController
from workbench.simulation.setup import Loop, Setup

PLACES = ctypes.POINTER(ctypes.c_double)


class Lockstep:
    """The controllers of a study as C, each written and compiled when it is first met, in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._compiled: dict[tuple[Controller, tuple[str, ...]], CompiledController] = {}

    def rehearsed(self, setup: Setup) -> Setup:
        """The setup with the C of its controllers in its loops.

        Raises:
            UserError: a controller cannot be written as C, or there is no compiler.
        """
        rotary = None if setup.rotary is None else self._loop(setup, setup.rotary, "rotation")
        return replace(setup, loop=self._loop(setup, setup.loop, "position"), rotary=rotary)

    def _loop(self, setup: Setup, loop: Loop, what: str) -> Loop:
        if loop.controller is OPEN_LOOP:
            return loop
        key = (loop.controller, setup.plant.channels)
        if key not in self._compiled:
            name = f"{loop.controller.name}_{what}_{len(self._compiled)}"
            exported = exported_loop(setup, loop, c_name(loop.controller.name), what, "double")
            self._compiled[key] = loaded(exported, self._folder / name)
        return replace(loop, controller=self._compiled[key])


def loaded(exported: Exported, folder: Path) -> CompiledController:
    """A controller whose equations are its exported C, which is written into a folder and compiled there.

    Raises:
        UserError: there is no C compiler.
    """
    folder.mkdir(parents=True)
    name, used, controller = exported.name, exported.recorded.used, exported.recorded.controller
    rows = {
        "gains": _placed(controller.Gains, used.gains),
        "state": _placed(controller.State, used.state),
        "reference": _placed(Reference, used.reference),
        "measurement": _placed(Measurement, used.measurement),
    }
    texts = {
        f"{name}.h": exported.text("controller.h"),
        f"{name}.c": exported.text("controller.c"),
        "lockstep.c": exported.text("lockstep.c", **rows),
    }
    for file, text in texts.items():
        (folder / file).write_text(text, encoding="utf-8")
    library = compiled_library([folder / f"{name}.c", folder / "lockstep.c"], folder / "lockstep.so")
    return _of_library(controller, ctypes.CDLL(str(library)), [place for _, place in rows["state"]])


def _placed(cls: type[NamedTuple], used: Collection[NumberPath]) -> list[tuple[str, int]]:
    """The numbers of a class that count, each with its place among all."""
    return [(in_c(path), place) for place, path in enumerate(number_paths(cls)) if path in used]


def _of_library(controller: Controller, library: ctypes.CDLL, kept: list[int]) -> CompiledController:
    """The controller with the functions of a library; its state that C has no use for stays as it starts."""

    def start(measurement: Measurement, gains: Any) -> Any:
        numbers, reading, own = to_array(controller.start(measurement, gains)), to_array(measurement), to_array(gains)
        numbers[kept] = np.nan  # the library sets them all
        library.lockstep_init(*(array.ctypes.data_as(PLACES) for array in (reading, numbers, own)))
        return from_array(controller.State, numbers.tolist())

    steps = (library.lockstep_command, library.lockstep_commit)
    addresses = tuple(ctypes.cast(function, ctypes.c_void_p).value or 0 for function in steps)
    given = {item.name: getattr(controller, item.name) for item in fields(controller)}
    return CompiledController(**{**given, "start": start}, addresses=(addresses[0], addresses[1]), held=library)
