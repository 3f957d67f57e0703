"""Plants and controllers as compiled code: the addresses of their C functions, which the engine calls."""

import functools
import itertools
import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numba import types

from controllers.interface import Controller, Reference
from plants.compiled import POINTER, CFunction, caller, compiled, pack, unpack
from plants.equation import fingerprint
from plants.interface import Measurement, Plant
from plants.plugins import OURS
from workbench.errors import UserError

NUMBA_FAILED = "Failed in nopython mode pipeline"
"""What numba says in the line before a reason; the last of several reasons is the one in the author's own code."""

PLACE = re.compile(r'File "([^"]+)", line (\d+)')
"""How it names a place."""

FOLDERS = tuple(Path(__file__).parents[2] / name for name in OURS)
"""Where this program's own code lies."""

DERIVATIVES = types.void(types.float64, POINTER, POINTER, POINTER, POINTER)
"""C signature: time, state, inputs, parameters, rates (out)."""

MEASURE = types.void(POINTER, POINTER, POINTER)
"""C signature: state, parameters, measurement (out)."""

call_derivatives, call_measure = caller(DERIVATIVES), caller(MEASURE)

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


def compile_derivatives(plant: Plant) -> CFunction:
    """The plant's derivatives as a C function of signature `DERIVATIVES`."""
    derivatives, state_class = plant.derivatives, plant.State
    inputs_class, parameters_class = plant.Inputs, plant.Parameters
    source = fingerprint(derivatives)

    @compiled(DERIVATIVES)
    def entry(time: float, state: Any, inputs: Any, parameters: Any, rates: Any) -> None:
        _ = source  # part of the key of the compiled code's cache
        s, u = unpack(state_class, state), unpack(inputs_class, inputs)
        pack(derivatives(time, s, u, unpack(parameters_class, parameters)), rates)

    return entry


def compile_measure(plant: Plant) -> CFunction:
    """The plant's noise-free readings as a C function of signature `MEASURE`.

    A channel that its `measure` leaves to the default is absent from the compiled tuple: it is NaN.
    """
    measure, state_class, parameters_class = plant.measure, plant.State, plant.Parameters
    channels = len(Measurement._fields)
    source = fingerprint(measure)

    @compiled(MEASURE)
    def entry(state: Any, parameters: Any, measurement: Any) -> None:
        _ = source  # part of the key of the compiled code's cache
        readings = measure(unpack(state_class, state), unpack(parameters_class, parameters))
        for i in range(len(readings), channels):
            measurement[i] = np.nan
        pack(readings, measurement)

    return entry


def compile_step(controller: Controller) -> CFunction:
    """The controller's step as a C function of signature `STEP`."""
    step, state_class, gains_class = controller.step, controller.State, controller.Gains
    reference_class, measurement_class = Reference, Measurement
    source = fingerprint(step)

    @compiled(STEP)
    def entry(reference: Any, measurement: Any, state: Any, gains: Any, sample_time: float) -> float:
        _ = source  # part of the key of the compiled code's cache
        r, y = unpack(reference_class, reference), unpack(measurement_class, measurement)
        command, following = step(r, y, unpack(state_class, state), unpack(gains_class, gains), sample_time)
        pack(following, state)
        return command

    return entry


def compile_commit(controller: Controller) -> CFunction:
    """The controller's commit as a C function of signature `COMMIT`."""
    commit, state_class, gains_class = controller.commit, controller.State, controller.Gains
    source = fingerprint(commit)

    @compiled(COMMIT)
    def entry(realised: float, state: Any, gains: Any, sample_time: float) -> None:
        _ = source  # part of the key of the compiled code's cache
        s = unpack(state_class, state)
        pack(commit(realised, s, unpack(gains_class, gains), sample_time), state)

    return entry


def plant_addresses(plant: Plant) -> tuple[int, int]:
    """Addresses of the plant's derivatives and of its readings.

    Raises:
        UserError: it cannot be compiled, and why.
    """
    with COMPILING:
        derivatives, measure = _compiled_plant(plant)
    return derivatives.address, measure.address


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
def _compiled_plant(plant: Plant) -> tuple[CFunction, CFunction]:
    """The plant's C functions; kept, since only their addresses go to the engine."""
    with _told("plant", plant.name):
        return compile_derivatives(plant), compile_measure(plant)


@functools.cache
def _compiled_controller(controller: Controller) -> tuple[CFunction, CFunction]:
    with _told("controller", controller.name):
        return compile_step(controller), compile_commit(controller)


@contextmanager
def _told(kind: str, name: str) -> Iterator[None]:
    """What numba cannot compile is its author's mistake: one line for the user, the rest in the traceback.

    Raises:
        UserError: the innermost reason that numba gives.
    """
    try:
        yield
    except Exception as error:
        lines = [line.strip() for line in str(error).splitlines() if line.strip()]
        causes = [later for line, later in itertools.pairwise(lines) if NUMBA_FAILED in line]
        reason = " ".join((causes or lines or [type(error).__name__])[-1].split())
        places = [(Path(file).resolve(), line) for file, line in PLACE.findall(str(error))]
        theirs = [(file.name, line) for file, line in places if not any(map(file.is_relative_to, FOLDERS))]
        where = f", in {theirs[-1][0]}, line {theirs[-1][1]}" if theirs else ""
        raise UserError(f'{kind} "{name}" cannot be compiled: {reason}{where} (--debug shows all of it)') from error
