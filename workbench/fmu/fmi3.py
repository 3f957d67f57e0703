"""An instance of an FMU of FMI 3.0, for co-simulation."""

import ctypes
from collections.abc import Mapping
from pathlib import Path

from workbench.fmu.calls import Calls, FmuError, Numbers, number, numbers, pointer, references, size, string
from workbench.fmu.description import Fmu

boolean = ctypes.c_bool
Log = ctypes.CFUNCTYPE(None, pointer, ctypes.c_int, string, string)


class Instance3:
    """An instance: see `workbench.fmu.calls.Instance`."""

    def __init__(self, fmu: Fmu, calls: Calls, folder: Path) -> None:
        self._calls = calls
        instance, told = [pointer], ctypes.POINTER(boolean)
        self._enter = calls.function(
            "fmi3EnterInitializationMode", [*instance, boolean, number, number, boolean, number]
        )
        self._exit = calls.function("fmi3ExitInitializationMode", instance)
        self._get = calls.function("fmi3GetFloat64", [*instance, references, size, numbers, size])
        self._set = calls.function("fmi3SetFloat64", [*instance, references, size, numbers, size])
        self._step = calls.function("fmi3DoStep", [*instance, number, number, boolean, told, told, told, numbers])
        self._terminate = calls.function("fmi3Terminate", instance)
        self._free = calls.function("fmi3FreeInstance", instance, None)
        self._told = (boolean(), boolean(), boolean())
        self._reached = ctypes.c_double()
        self._log = Log(lambda _, status, category, message: calls.heard(status, message))
        instantiate = calls.function(
            "fmi3InstantiateCoSimulation",
            [string, string, string, *[boolean] * 4, references, size, pointer, Log, pointer],
            pointer,
        )
        resources = f"{folder / 'resources'}/".encode()
        self._instance = instantiate(
            b"plant", fmu.token.encode(), resources, False, True, False, False, None, 0, None, self._log, None
        )
        if not self._instance:
            raise FmuError(f"fmi3InstantiateCoSimulation: {calls.said or 'it makes no instance'}")

    def start(self, tolerance: float, parameters: Mapping[int, float], inputs: Numbers) -> None:
        check = self._calls.check
        if parameters:
            given = Numbers([*parameters])
            given.values[:] = [*parameters.values()]
            self.write(given)
        check("fmi3EnterInitializationMode", self._enter(self._instance, True, tolerance, 0.0, False, 0.0))
        self.write(inputs)
        check("fmi3ExitInitializationMode", self._exit(self._instance))

    def write(self, values: Numbers) -> None:
        status = self._set(self._instance, values.references, values.count, values.values, values.count)
        self._calls.check("fmi3SetFloat64", status)

    def read(self, values: Numbers) -> None:
        status = self._get(self._instance, values.references, values.count, values.values, values.count)
        self._calls.check("fmi3GetFloat64", status)

    def step(self, start: float, length: float) -> None:
        told = [ctypes.byref(one) for one in self._told]
        status = self._step(self._instance, start, length, True, *told, ctypes.byref(self._reached))
        self._calls.check("fmi3DoStep", status)
        if self._told[1].value or self._told[2].value:
            raise FmuError(f"fmi3DoStep: it ends by itself at {self._reached.value:g} s")

    def close(self) -> None:
        if not self._calls.fatal:
            self._terminate(self._instance)
            self._free(self._instance)
