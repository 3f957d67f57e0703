"""Calls of an FMU's functions, of either version of FMI, by ctypes."""

import ctypes
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from workbench.errors import UserError, shortened
from workbench.fmu.description import Fmu

OK, WARNING, FATAL = 0, 1, 4
STATUS = ("ok", "warning", "discard", "error", "fatal", "pending")

pointer, string, number, flag, size = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_double, ctypes.c_int, ctypes.c_size_t
references, numbers = ctypes.POINTER(ctypes.c_uint), ctypes.POINTER(ctypes.c_double)


class FmuError(Exception):
    """An FMU's function that fails: which, and what the FMU says."""


class Numbers:
    """Variables that are read or written together."""

    def __init__(self, variables: Sequence[int]) -> None:
        self.references = (ctypes.c_uint * len(variables))(*variables)
        self.values = (ctypes.c_double * len(variables))()
        self.count = len(variables)


class Instance(Protocol):
    """An instance of an FMU. Every method raises FmuError where the FMU fails."""

    def start(self, tolerance: float, parameters: Mapping[int, float], inputs: Numbers) -> None:
        """Initialize it at time 0."""

    def write(self, values: Numbers) -> None: ...

    def read(self, values: Numbers) -> None: ...

    def step(self, start: float, length: float) -> None: ...

    def close(self) -> None: ...


class Calls:
    """The functions of a library, and what its log has said last."""

    def __init__(self, fmu: Fmu, library: ctypes.CDLL) -> None:
        self._fmu, self._library = fmu, library
        self.said = ""
        self.fatal = False

    def function(self, name: str, arguments: Sequence[Any], returned: Any = ctypes.c_int) -> Any:
        """A function of the library.

        Raises:
            UserError: it has none of that name.
        """
        try:
            found = self._library[name]
        except AttributeError:
            raise UserError(f"{self._fmu.path}: its binary lacks the function {name}") from None
        found.argtypes, found.restype = [*arguments], returned
        return found

    def heard(self, status: int, message: bytes | None) -> None:
        """Keep what the log says of something that went wrong."""
        if status > WARNING and message:
            self.said = shortened(" ".join(message.decode("utf-8", "replace").split()), 200)

    def check(self, name: str, status: int) -> None:
        """Raise FmuError where a call of that name has failed."""
        if status in (OK, WARNING):
            return
        self.fatal = self.fatal or status == FATAL
        word = STATUS[status] if 0 <= status < len(STATUS) else f"status {status}"
        raise FmuError(self.said if name in self.said else f"{name}: {self.said or word}")


def instance_of(fmu: Fmu, library: ctypes.CDLL, folder: Path) -> Instance:
    """An instance of an FMU that is loaded.

    Raises:
        UserError: its library lacks a function.
        FmuError: it cannot be made.
    """
    from workbench.fmu.fmi2 import Instance2
    from workbench.fmu.fmi3 import Instance3

    made = Instance2 if fmu.fmi == 2 else Instance3
    return made(fmu, Calls(fmu, library), folder)
