"""How far a command is, on a terminal; nothing where standard error goes elsewhere."""

import sys
from typing import Any


class ProgressBar:
    """A progress bar with the time left, only on a terminal."""

    def __init__(self, total: int) -> None:
        self._total = total
        self._bar: Any = None

    def __enter__(self) -> Any:
        if not sys.stderr.isatty():
            return None
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("{task.description}"))
        self._bar = Progress(*columns, console=Console(stderr=True))
        self._bar.start()
        task = self._bar.add_task("", total=self._total)
        return lambda count, total, case: self._bar.update(task, completed=count, description=case.label)

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()


class ProgressLine:
    """A line that says what is being done, how far that is and how long it may take, only on a terminal."""

    def __init__(self) -> None:
        self._line: Any = None

    def __enter__(self) -> Any:
        if not sys.stderr.isatty():
            return None
        from rich.console import Console
        from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeRemainingColumn

        columns = (SpinnerColumn(), BarColumn(), TimeRemainingColumn(), TextColumn("{task.description}"))
        self._line = Progress(*columns, console=Console(stderr=True), transient=True)
        self._line.start()
        task = self._line.add_task("", total=None)

        def told(said: str, done: float | None = None) -> None:
            self._line.update(task, description=said, completed=done, total=None if done is None else 1.0)

        return told

    def __exit__(self, *_: object) -> None:
        if self._line is not None:
            self._line.stop()
