"""Plants and controllers as compiled code: the addresses of their C functions, which the engine calls."""

import functools
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numba import types

from controllers.interface import Controller, Reference
from plants.compiled import POINTER, caller
from plants.interface import Measurement, Plant
from plants.plugins import OURS
from workbench.errors import UserError
from workbench.recording.machine_code import MachineCode, machine_code
from workbench.simulation.arrays import owner_of
from workbench.simulation.integrators.interface import IntegrationMethod
from workbench.simulation.whole_step import filtered_rates, sizes_of, whole_step

FOLDERS = (*(Path(__file__).parents[2] / name for name in OURS), Path(np.__file__).parent)
"""Where code lies that is no author's of a plug-in."""

DERIVATIVES = types.void(types.float64, POINTER, POINTER, POINTER, POINTER)
"""C signature: time, state, inputs, parameters, rates (out)."""

MEASURE = types.void(POINTER, POINTER, POINTER)
"""C signature: state, parameters, measurement (out)."""

call_derivatives, call_measure = caller(DERIVATIVES), caller(MEASURE)

WHOLE_STEP = types.void(types.int64, *(POINTER,) * 8)
"""C signature: `workbench.simulation.whole_step`."""

call_whole_step = caller(WHOLE_STEP)

ADVANCE = types.float64(types.float64, types.float64, POINTER, POINTER)
"""C signature of a machine that solves itself: start, end, inputs, state (out) -> 0, or else it has failed."""

call_advance = caller(ADVANCE)

STEP = types.float64(POINTER, POINTER, POINTER, POINTER, types.float64)
"""C signature: reference, measurement, state (in and out), gains, sample time -> command."""

COMMIT = types.void(types.float64, POINTER, POINTER, types.float64)
"""C signature: realised command, state (in and out), gains, sample time."""

call_step, call_commit = caller(STEP), caller(COMMIT)


@dataclass(frozen=True, eq=False)
class CompiledController(Controller):
    """A controller whose step and commit are C functions already, of the signatures `STEP` and `COMMIT`.

    `held` is what they live in, as long as the controller does.
    """

    addresses: tuple[int, int] = (0, 0)
    held: object = None


COMPILING = threading.Lock()
"""Of two threads that compile the same at once, only one's code would be kept, and the other's freed while it runs."""


def compile_derivatives(plant: Plant) -> MachineCode:
    """The plant's derivatives as a C function of signature `DERIVATIVES`."""
    return machine_code(plant.derivatives, (None, plant.State, plant.Inputs, plant.Parameters), into=4)


def compile_measure(plant: Plant) -> MachineCode:
    """The plant's noise-free readings as a C function of signature `MEASURE`."""
    return machine_code(plant.measure, (plant.State, plant.Parameters), into=2)


def compile_rates(plant: Plant, filtered: bool, lanes: int) -> MachineCode:
    """What a whole step of the plant integrates: of one lane a C function of signature `DERIVATIVES`; of several the
    time, too, is behind a pointer.
    """
    if lanes == 1 and not filtered:
        return compile_derivatives(plant)
    states, _, parameters = sizes_of(plant, filtered)
    own = filtered_rates(plant) if filtered else plant.derivatives
    known = (states, plant.Inputs, parameters) if filtered else (plant.State, plant.Inputs, plant.Parameters)
    if lanes == 1:
        return machine_code(own, (None, *known), into=4)
    return machine_code(lambda time, *given: own(time[0], *given), (1, *known), into=4, lanes=lanes)


def compile_step(controller: Controller) -> MachineCode:
    """The controller's step as a C function of signature `STEP`."""
    given = (Reference, Measurement, controller.State, controller.Gains, None)
    return machine_code(controller.step, given, into=2, gives=True)


def compile_commit(controller: Controller) -> MachineCode:
    """The controller's commit as a C function of signature `COMMIT`."""
    return machine_code(controller.commit, (None, controller.State, controller.Gains, None), into=1)


@functools.cache
def plant_addresses(plant: Plant) -> tuple[int, int]:
    """Addresses of the plant's derivatives and of its readings.

    Raises:
        UserError: it cannot be compiled, and why.
    """
    with COMPILING:
        derivatives, measure = _compiled_rates(plant, filtered=False, lanes=1), _compiled_measure(plant)
    return derivatives.address, measure.address


@functools.cache
def step_addresses(plant: Plant, method: IntegrationMethod, filtered: bool, lanes: int) -> tuple[int, int, int]:
    """Addresses of a whole step by a method, for so many lanes, and of what it integrates: rates of the plant, and of
    filters of its sensors if these are `filtered`; and of the plant's readings.

    Raises:
        UserError: it cannot be compiled, and why.
    """
    states, inputs, _ = sizes_of(plant, filtered)
    with COMPILING:
        step = whole_step(method, states, inputs, lanes)
        rates, measure = _compiled_rates(plant, filtered, lanes), _compiled_measure(plant)
    return step.address, rates.address, measure.address


@functools.cache
def controller_addresses(controller: Controller) -> tuple[int, int]:
    """Addresses of the controller's step and commit.

    Raises:
        UserError: it cannot be compiled, and why.
    """
    if isinstance(controller, CompiledController):
        return controller.addresses
    with COMPILING:
        step, commit = _compiled_controller(controller)
    return step.address, commit.address


@functools.cache
def _compiled_measure(plant: Plant) -> MachineCode:
    """Kept, as all of these, since only their addresses go to the engine."""
    with _told(f'plant "{plant.name}"', plant):
        return compile_measure(plant)


@functools.cache
def _compiled_rates(plant: Plant, filtered: bool, lanes: int) -> MachineCode:
    with _told(f'plant "{plant.name}"', plant):
        return compile_rates(plant, filtered, lanes)


@functools.cache
def _compiled_controller(controller: Controller) -> tuple[MachineCode, MachineCode]:
    with _told(f'controller "{controller.name}"'):
        return compile_step(controller), compile_commit(controller)


@contextmanager
def _told(called: str, plant: Plant | None = None) -> Iterator[None]:
    """What cannot be recorded is its author's mistake: one line for the user, the rest in the traceback.

    Raises:
        UserError: whose law, effect, plant or controller it is, the place in the author's own code, and the reason.
    """
    try:
        yield
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        frames = [frame for frame in traceback.extract_tb(error.__traceback__) if _is_theirs(frame)]
        place = f'"{frames[-1].name}" ({Path(frames[-1].filename).name}, line {frames[-1].lineno}) ' if frames else ""
        owner = owner_of(plant, error.__traceback__) if plant is not None else ""
        raise UserError(f"{owner or called} cannot be compiled: {place}{reason} (--debug shows all of it)") from error


def _is_theirs(frame: traceback.FrameSummary) -> bool:
    return not any(map(Path(frame.filename).is_relative_to, FOLDERS))
