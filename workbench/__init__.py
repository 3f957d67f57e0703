"""Friction Workbench: an actuator sticks. Compensate the friction, or avoid it?

    import workbench as wb
    run = wb.simulate(wb.setup("rotating", "owen2001_simulation", rpm=460, controller=wb.pid(kp=500)))

`workbench.api` documents the public names. They are imported when they are first used: importing this costs nothing.
"""

import importlib
import os
import sys
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from workbench.api import *  # noqa: F403 - the public names, written down there
    from workbench.api import ControllerChoice

    def __getattr__(name: str) -> Callable[..., ControllerChoice]: ...


# Threads of the linear algebra wait for each other on a busy machine: 4 s for a product that one makes in 15 ms. NumPy
# reads it when it comes in; who has it in already, or has set it, has said what he wants.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

QUESTIONS = ("tune", "decide", "identify", "diagnose", "report", "bench", "rehearse", "design")
"""Rooms of the program, and functions of the same names."""


class _Question(ModuleType):
    # A room that is called as the question it answers: `workbench.tune` holds `workbench.tune.run`, and
    # `workbench.tune(path)` tunes.

    def __call__(self, *arguments: object, **options: object) -> object:
        return self._function(*arguments, **options)

    @property
    def _function(self) -> "Callable[..., object]":
        function: Callable[..., object] = getattr(_api(), self.__name__.rpartition(".")[2])
        return function

    @property
    def __signature__(self) -> object:
        import inspect

        return inspect.signature(self._function)

    @property
    def __doc__(self) -> str | None:  # type: ignore[override]
        return self._function.__doc__


class _FrontDoor(ModuleType):
    def __getattr__(self, name: str) -> object:
        if name == "__all__":
            return _api().__all__
        if name.startswith("__"):
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        if name in QUESTIONS:
            return importlib.import_module(f"workbench.{name}")
        if name in _api().__all__:
            return getattr(_api(), name)
        from workbench.errors import nearest

        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}; {nearest(name, _api().__all__)}")

    def __setattr__(self, name: str, value: object) -> None:
        """Import puts a room in the place of the function of its name: there it becomes one that can be called."""
        if name in QUESTIONS and isinstance(value, ModuleType):
            value.__class__ = _Question
        super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *_api().__all__})


def _api() -> ModuleType:
    return importlib.import_module("workbench.api")


sys.modules[__name__].__class__ = _FrontDoor
