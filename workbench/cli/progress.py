"""How far a command is: a bar on a terminal, plain lines now and then where standard error goes elsewhere."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from workbench.progress import Progress
from workbench.stopping import exit_code, is_requested

INTERVAL = 15.0
"""Seconds between two plain lines, and before the first: what is over sooner says nothing."""
AGAIN = "nothing is lost: run the same command again"
"""What there is to say of a stopped command that keeps nothing, or has not begun."""

BAR, BESIDE = 20, 14
"""Signs of a bar, and of all beside it but numbers of cases and words, which have what is left of a line."""

SAID = "{task.description}"

_kept = [AGAIN]
"""What a stop leaves, in words: of the command that runs, innermost last."""


@contextmanager
def stoppable(kept: str = "nothing is written") -> Iterator[None]:
    """Ctrl-C ends a command with one line that says what is `kept`, and with 130 as shells expect, SIGTERM with 143;
    most commands write their folder whole or not at all.
    """
    _kept.append(kept)
    try:
        yield
    except (KeyboardInterrupt, Exception) as error:
        if not isinstance(error, KeyboardInterrupt) and not is_requested():
            raise
        say_stopped()
        sys.exit(exit_code())
    finally:
        _kept.pop()


def say_stopped() -> None:
    """Write that line."""
    print(f"stopped; {_kept[-1]}", file=sys.stderr, flush=True)


class Lines:
    """Plain lines on standard error, each written at once, none sooner than `INTERVAL` after the one before."""

    def __init__(self) -> None:
        self._began = self._said = time.monotonic()

    def begin(self) -> None:
        """Count the time left from here: what was before was compiling, or an earlier run's."""
        self._began = time.monotonic()

    def say(self, text: str, done: float | None = None) -> None:
        """Write how far it is, in words and with the time left where `done`, the share that is done, is known."""
        now = time.monotonic()
        if now - self._said < INTERVAL:
            return
        self._said = now
        left = f", about {_duration((now - self._began) * (1.0 - done) / done)} left" if done else ""
        print(f"{text}{left}", file=sys.stderr, flush=True)


def _at_most(text: str, signs: int) -> str:
    """The beginning of a text that is longer."""
    return text if len(text) <= signs else f"{text[: max(signs - 1, 0)]}…"


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120.0 else f"{seconds / 60.0:.0f} min"


class ProgressBar:
    """Cases done, of all: a bar with the time left on a terminal, else plain lines."""

    def __init__(self, total: int) -> None:
        self._total = total
        self._bar: Any = None

    def __enter__(self) -> Callable[[int, int, str], None]:
        if not sys.stderr.isatty():
            return self._plain(Lines())
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (BarColumn(BAR), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn(SAID, markup=False))
        console = Console(stderr=True)
        self._bar = Progress(*columns, console=console)
        self._bar.start()
        task = self._bar.add_task("", total=self._total)

        def told(count: int, total: int, case: str) -> None:
            beside = BAR + 2 * len(str(total)) + BESIDE
            self._bar.update(task, completed=count, description=_at_most(case, console.width - beside))

        return told

    def _plain(self, lines: Lines) -> Callable[[int, int, str], None]:
        first: list[int] = []

        def told(count: int, total: int, case: str) -> None:
            if not first:
                first.append(count)
                lines.begin()
            if count < total:
                lines.say(f"{count} of {total} cases", (count - first[0]) / (total - first[0]))

        return told

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()


class ProgressLine:
    """What is being done, how far that is and how long it may take: a line on a terminal, else now and then a line."""

    def __init__(self) -> None:
        self._line: Any = None

    def __enter__(self) -> Progress:
        if not sys.stderr.isatty():
            return Lines().say
        from rich.console import Console
        from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Bar

        columns = (SpinnerColumn(), BarColumn(BAR), TimeRemainingColumn(), TextColumn(SAID, markup=False))
        console = Console(stderr=True)
        self._line = Bar(*columns, console=console, transient=True)
        self._line.start()
        task = self._line.add_task("", total=None)

        def told(doing: str, done: float | None = None, /) -> None:
            text = _at_most(doing, console.width - BAR - BESIDE)
            self._line.update(task, description=text, completed=done, total=None if done is None else 1.0)

        return told

    def __exit__(self, *_: object) -> None:
        if self._line is not None:
            self._line.stop()
