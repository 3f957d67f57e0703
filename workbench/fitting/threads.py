"""Simulations side by side, in threads that stay: compiled code lets other threads run."""

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from os import getpid
from typing import Any, TypeVar

THREADS = 2

Result = TypeVar("Result")

_here = threading.local()


def side_by_side(function: Callable[..., Result], *items: Iterable[Any]) -> list[Result]:
    """What a function makes of items, in their order; one after the other where a thread of these asks for it. One item
    alone is left to the thread that asks, whose own work may then go side by side.
    """
    lists = [list(each) for each in items]
    if free_threads() == 1 or min(map(len, lists)) == 1:
        return list(map(function, *lists))
    return list(_pool(getpid()).map(function, *lists))


def free_threads() -> int:
    """How many threads what is asked for here may go to: a thread of these has itself alone."""
    return 1 if getattr(_here, "works", False) else THREADS


@lru_cache(maxsize=1)
def _pool(_process: int) -> ThreadPoolExecutor:
    """The threads of a process: a process that is forked has none."""
    return ThreadPoolExecutor(THREADS, "side by side", initializer=_begin)


def _begin() -> None:
    _here.works = True
