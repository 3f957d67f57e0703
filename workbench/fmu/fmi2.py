"""An instance of an FMU of FMI 2.0, for co-simulation."""

import ctypes
from collections.abc import Mapping
from pathlib import Path

from workbench.fmu.calls import Calls, FmuError, Numbers, flag, number, numbers, pointer, references, size, string
from workbench.fmu.description import Fmu

CO_SIMULATION = 1

Logger = ctypes.CFUNCTYPE(None, pointer, string, ctypes.c_int, string, string)
"""C has more arguments behind these, of which a message may be made; the message's form is what is kept."""


class Callbacks(ctypes.Structure):
    """What an instance calls. Memory is C's own."""

    _fields_ = [
        ("logger", Logger),
        ("allocate", pointer),
        ("free", pointer),
        ("step_finished", pointer),
        ("environment", pointer),
    ]


class Instance2:
    """An instance: see `workbench.fmu.calls.Instance`."""

    def __init__(self, fmu: Fmu, calls: Calls, folder: Path) -> None:
        self._calls = calls
        component = [pointer]
        self._setup = calls.function("fmi2SetupExperiment", [*component, flag, number, number, flag, number])
        self._enter = calls.function("fmi2EnterInitializationMode", component)
        self._exit = calls.function("fmi2ExitInitializationMode", component)
        self._get = calls.function("fmi2GetReal", [*component, references, size, numbers])
        self._set = calls.function("fmi2SetReal", [*component, references, size, numbers])
        self._step = calls.function("fmi2DoStep", [*component, number, number, flag])
        self._terminate = calls.function("fmi2Terminate", component)
        self._free = calls.function("fmi2FreeInstance", component, None)
        c = ctypes.CDLL(None)
        allocate, free = (ctypes.cast(function, pointer).value for function in (c.calloc, c.free))
        logger = Logger(lambda _, name, status, category, message: calls.heard(status, message))
        self._callbacks = Callbacks(logger, allocate, free, None, None)  # the instance keeps a pointer to them
        instantiate = calls.function(
            "fmi2Instantiate",
            [string, ctypes.c_int, string, string, ctypes.POINTER(Callbacks), flag, flag],
            pointer,
        )
        resources = (folder / "resources").as_uri().encode()
        self._component = instantiate(
            b"plant", CO_SIMULATION, fmu.token.encode(), resources, ctypes.byref(self._callbacks), 0, 1
        )
        if not self._component:
            raise FmuError(f"fmi2Instantiate: {calls.said or 'it makes no instance'}")

    def start(self, tolerance: float, parameters: Mapping[int, float], inputs: Numbers) -> None:
        check = self._calls.check
        check("fmi2SetupExperiment", self._setup(self._component, 1, tolerance, 0.0, 0, 0.0))
        if parameters:
            given = Numbers([*parameters])
            given.values[:] = [*parameters.values()]
            self.write(given)
        check("fmi2EnterInitializationMode", self._enter(self._component))
        self.write(inputs)
        check("fmi2ExitInitializationMode", self._exit(self._component))

    def write(self, values: Numbers) -> None:
        self._calls.check("fmi2SetReal", self._set(self._component, values.references, values.count, values.values))

    def read(self, values: Numbers) -> None:
        self._calls.check("fmi2GetReal", self._get(self._component, values.references, values.count, values.values))

    def step(self, start: float, length: float) -> None:
        self._calls.check("fmi2DoStep", self._step(self._component, start, length, 1))

    def close(self) -> None:
        if not self._calls.fatal:
            self._terminate(self._component)
            self._free(self._component)
