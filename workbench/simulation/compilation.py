"""Plants and controllers as compiled code: the addresses of their C functions, which the engine calls."""

import functools
import itertools
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from controllers.interface import Controller, compile_commit, compile_step
from plants.interface import Plant, compile_derivatives, compile_measure
from workbench.errors import UserError

NUMBA_FAILED = "Failed in nopython mode pipeline"
"""What numba says in the line before a reason; the last of several reasons is the one in the author's own code."""

COMPILING = threading.Lock()
"""Of two threads that compile the same at once, only one's code would be kept, and the other's freed while it runs."""


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
    with COMPILING:
        step, commit = _compiled_controller(controller)
    return step.address, commit.address


@functools.cache
def _compiled_plant(plant: Plant) -> tuple[Any, Any]:
    """The plant's C functions; kept, since only their addresses go to the engine."""
    with _told("plant", plant.name):
        return compile_derivatives(plant), compile_measure(plant)


@functools.cache
def _compiled_controller(controller: Controller) -> tuple[Any, Any]:
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
        raise UserError(f'{kind} "{name}" cannot be compiled: {reason} (--debug shows all of it)') from error
