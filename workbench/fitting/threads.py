"""Simulations side by side, in threads that stay: compiled code lets other threads run.

Who asks works too, and whoever is idle helps: what is part of larger work that goes side by side goes so as well once
the other part of that is done.
"""

import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from functools import lru_cache
from os import getpid
from typing import Any, TypeVar

THREADS = 2

Item = TypeVar("Item")
Result = TypeVar("Result")


def side_by_side(function: Callable[..., Result], *items: Iterable[Any]) -> list[Result]:
    """What a function makes of items, in their order. One item alone is left to the thread that asks, whose own work
    may then go side by side.
    """
    calls = list(zip(*items, strict=False))
    made, left, team = dict[int, Result](), deque(range(len(calls))), _team(getpid())

    def work() -> None:
        while left:
            try:
                place = left.popleft()
            except IndexError:  # another has taken the last one
                break
            made[place] = function(*calls[place])

    try:
        helping = team.helping(work, len(calls) - 1)
        work()
        team.wait(helping)
    finally:
        left.clear()
    return [made[place] for place in range(len(calls))]


def free_threads() -> int:
    """How many threads what is asked for here may go to now."""
    return 1 + max(_team(getpid()).idle, 0)


def parts_of(items: Sequence[Item], most: int) -> Iterator[Sequence[Item]]:
    """Parts of items that are done at once, `most` at most: whole ones for every free thread, and about as many of what
    is left; one or two go alone, since those that are solved at once take as long whether there are two or four.
    """
    threads = free_threads()
    whole = len(items) // (threads * most) * threads
    left = len(items) - whole * most
    parts, at = min(threads, left), 0
    for size in [most] * whole + [left // parts + (i < left % parts) for i in range(parts)]:
        yield items[at : at + size]
        at += size


def in_parts(function: Callable[[Sequence[Item]], Sequence[Result]], items: Sequence[Item], most: int) -> list[Result]:
    """What a function makes of parts of items (`parts_of`) side by side, in the order of the items."""
    return [one for part in side_by_side(function, list(parts_of(items, most))) for one in part]


class _Team:
    """Threads of which so many work at a time as are to, those that ask among them."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(THREADS, "side by side")
        self._lock = threading.Lock()
        self.idle = THREADS - 1

    def helping(self, work: Callable[[], None], most: int) -> list[Future[None]]:
        """Those that are idle, `most` of them at most, at a work."""
        with self._lock:
            count = max(min(self.idle, most), 0)
            self.idle -= count
        return [self._pool.submit(self._help, work) for _ in range(count)]

    def _help(self, work: Callable[[], None]) -> None:
        try:
            work()
        finally:
            self._changed(1)

    def wait(self, helping: list[Future[None]]) -> None:
        """Wait until they are done, those that have begun; who waits is idle."""
        begun = [future for future in helping if not future.cancel()]
        self._changed(len(helping) - len(begun))
        if not begun:
            return
        self._changed(1)
        try:
            for future in begun:
                future.result()
        finally:
            self._changed(-1)

    def _changed(self, idle: int) -> None:
        with self._lock:
            self.idle += idle


@lru_cache(maxsize=1)
def _team(_process: int) -> _Team:
    """That of a process: a process that is forked has no threads."""
    return _Team()
