"""An FMU that runs: C functions which the engine calls as it calls a plant's, and how that went."""

import ctypes
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from workbench.fmu.calls import FmuError, Instance, Numbers, instance_of, numbers
from workbench.fmu.library import loaded
from workbench.fmu.machine import ABSENT, STILL, FmuMachine, check_runs

Advance = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double, ctypes.c_double, numbers, numbers)
"""Start and end of a step (s), inputs, outputs -> 0, or 1 where the FMU fails."""

Measure = ctypes.CFUNCTYPE(None, numbers, numbers, numbers)
"""Outputs, parameters, measurement (out)."""

FIXED = {ABSENT: np.nan, STILL: 0.0}
"""Readings that no output gives."""


class Running:
    """An instance of an FMU between its start and its end.

    `failure` is what the FMU said when it failed, "" as long as it has not; `stopped` an exception that came up while
    it was called, such as that of Ctrl-C.
    """

    def __init__(self, machine: FmuMachine, inputs: Sequence[float]) -> None:
        self._machine = machine
        self._instance: Instance | None = None
        self._inputs = Numbers([item.reference for item in machine.inputs])
        self._outputs = Numbers([item.reference for item in machine.outputs])
        self._to_fmu = [1.0 / item.factor for item in machine.inputs]
        self._to_si = [item.factor for item in machine.outputs]
        self._channels = [(i, place) for i, place in enumerate(machine.channels) if place >= 0]
        self._fixed = [(i, FIXED[place]) for i, place in enumerate(machine.channels) if place < 0]
        self._advance, self._measure = Advance(self._guarded), Measure(self._measured)
        self.failure = ""
        self.stopped: BaseException | None = None
        self._inputs.values[:] = [value * factor for value, factor in zip(inputs, self._to_fmu, strict=True)]

    @property
    def addresses(self) -> tuple[int, int]:
        """Of the C functions that advance it, and that measure it."""
        advance, measure = (ctypes.cast(one, ctypes.c_void_p).value for one in (self._advance, self._measure))
        return advance or 0, measure or 0

    def begin(self, tolerance: float) -> np.ndarray:
        """Start it at time 0; returns its outputs (SI), NaN where it fails.

        Raises:
            UserError: its binary cannot be loaded.
        """
        library, folder = loaded(self._machine.fmu)
        try:
            self._instance = instance_of(self._machine.fmu, library, folder)
            self._instance.start(tolerance, dict(self._machine.parameters), self._inputs)
            self._instance.read(self._outputs)
        except FmuError as error:
            self.failure = str(error)
            return np.full(len(self._to_si), np.nan)
        return np.array(self._outputs.values[:]) * self._to_si

    def close(self) -> None:
        """End the instance, if there is one."""
        if self._instance is not None:
            self._instance.close()

    def _guarded(self, start: float, end: float, inputs: Any, outputs: Any) -> float:
        """`_advanced`; nothing is raised through compiled code."""
        try:
            self._advanced(start, end, inputs, outputs)
        except FmuError as error:
            self.failure = str(error)
            return 1.0
        except BaseException as error:  # noqa: BLE001  it is raised again behind the loop
            self.stopped = error
            return 1.0
        return 0.0

    def _advanced(self, start: float, end: float, inputs: Any, outputs: Any) -> None:
        assert self._instance is not None  # nothing advances before it begins
        values = self._inputs.values
        for i, factor in enumerate(self._to_fmu):
            values[i] = inputs[i] * factor
        self._instance.write(self._inputs)
        self._instance.step(start, end - start)
        self._instance.read(self._outputs)
        values = self._outputs.values
        for i, factor in enumerate(self._to_si):
            outputs[i] = values[i] * factor

    def _measured(self, outputs: Any, parameters: Any, measurement: Any) -> None:
        for i, place in self._channels:
            measurement[i] = outputs[place]
        for i, value in self._fixed:
            measurement[i] = value


@contextmanager
def running(machine: FmuMachine, inputs: Sequence[float]) -> Iterator[Running]:
    """A machine that is to begin, its inputs (SI) as they are before.

    Raises:
        UserError: it may not be run, or has no binary for this platform.
    """
    check_runs(machine.fmu, machine.allowed)
    found = Running(machine, inputs)
    try:
        yield found
    finally:
        found.close()
