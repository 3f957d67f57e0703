"""How a simulation is stopped: a flag in memory, which every compiled loop looks at once a step.

with stopping_on_signals(say):   # around a command's work
    ...

Python runs the handler of a signal between two instructions of its main thread, and compiled code has none. So a
thread waits for signals beside it, and sets the flag at once: the loops of all threads end, and what they are part of.
"""

import os
import signal
import socket
import sys
import threading
import time
from array import array
from collections.abc import Callable, Iterator
from contextlib import contextmanager

SIGNALS = (signal.SIGINT, signal.SIGTERM)
"""Ctrl-C, and what asks a process to end."""

AGAIN = 0.1
"""s, after which KeyboardInterrupt is raised once more where something has dropped it, as imports of libraries do."""

GRACE = 3.0
"""s. What holds on for longer, such as the compiler, or a library that looks at no signal, ends with the process."""

_FLAG = array("q", [0])

ADDRESS = _FLAG.buffer_info()[0]
"""Of the flag: a 64-bit integer, 0 as long as loops may run, else the signal that stops them."""


def request(number: int = signal.SIGINT) -> None:
    """Stop every compiled loop, and those that begin, as the signal of this number does: `simulate` raises
    KeyboardInterrupt.
    """
    _FLAG[0] = number


def clear() -> None:
    """Let loops run again."""
    _FLAG[0] = 0


def is_requested() -> bool:
    """Whether something has asked to stop: an error then is most likely how a library passes on KeyboardInterrupt."""
    return bool(_FLAG[0])


def exit_code() -> int:
    """What a stopped process exits with, as shells expect: 130 after Ctrl-C, 143 after SIGTERM."""
    return 128 + (_FLAG[0] or signal.SIGINT)


@contextmanager
def stopping_on_signals(say: Callable[[], None], *, to_the_end: bool = False) -> Iterator[None]:
    """While inside, the first of `SIGNALS` stops every compiled loop and the worker processes at once, and raises
    KeyboardInterrupt in the main thread, again where it is dropped there; later ones are ignored, and so are those that
    the process ignores already.

    Where the block is not left within `GRACE`, `say` writes what there is to say and the process exits. Outside the
    main thread, which alone is told of signals, the block is left as it is. Where the process ends behind it
    (`to_the_end`) signals stay ignored.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    clear()
    heard = [number for number in SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
    inside, outside = socket.socketpair()
    outside.setblocking(False)
    ended, due = threading.Event(), threading.Event()
    due.set()

    def interrupt(number: int, _: object) -> None:
        if due.is_set():
            due.clear()
            request(number)
            raise KeyboardInterrupt

    watcher = threading.Thread(target=_watch, args=(inside, ended, due, say), name="stopping", daemon=True)
    watcher.start()
    waking = signal.set_wakeup_fd(outside.fileno(), warn_on_full_buffer=False)
    handlers = {number: signal.signal(number, interrupt) for number in heard}
    said, sys.unraisablehook = sys.unraisablehook, _without_stops(sys.unraisablehook)
    try:
        yield
    finally:
        ignore()
        sys.unraisablehook = said
        signal.set_wakeup_fd(waking)
        ended.set()
        outside.close()
        watcher.join()
        inside.close()
        clear()
        for number, handler in handlers.items() if not to_the_end else ():
            signal.signal(number, handler)


def ignore() -> None:
    """While Python ends: the work is done, or stopped, and its exit code stands."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


@contextmanager
def held_back() -> Iterator[None]:
    """Fork a worker process inside: until it is `in_a_worker` no signal reaches it. It would go by the handlers of the
    process that forks, and through a socket that they share stop that one too.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def in_a_worker() -> None:
    """Begin a worker process with this: a signal, which a terminal sends to all processes of a command, ends it without
    a word; the process that it works for says what there is to say.
    """
    signal.set_wakeup_fd(-1)
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)


def _without_stops(hook: Callable[["sys.UnraisableHookArgs"], object]) -> Callable[["sys.UnraisableHookArgs"], object]:
    """What says nothing of a KeyboardInterrupt that Python drops, in a finaliser or while it forks: the flag stays."""

    def say(dropped: "sys.UnraisableHookArgs") -> None:
        if dropped.exc_type is not KeyboardInterrupt or not is_requested():
            hook(dropped)

    return say


def _watch(inside: socket.socket, ended: threading.Event, due: threading.Event, say: Callable[[], None]) -> None:
    """Wait for a signal, or for the end of the block, which closes the other socket."""
    while received := inside.recv(1):
        number = received[0]
        if number not in SIGNALS:
            continue
        request(number)
        if "multiprocessing" in sys.modules:
            for worker in sys.modules["multiprocessing"].active_children():
                worker.terminate()
        latest = time.monotonic() + GRACE
        while not ended.wait(min(AGAIN, GRACE)):
            if time.monotonic() > latest:
                say()
                os._exit(exit_code())
            if not due.is_set() and not _is_unwinding():
                due.set()
                signal.pthread_kill(threading.main_thread().ident or 0, number)


def _is_unwinding() -> bool:
    """Whether the main thread is handling a KeyboardInterrupt, or what became of one: else it has been dropped."""
    handled = sys._current_exceptions().get(threading.main_thread().ident or 0)
    error = handled[1] if isinstance(handled, tuple) else handled
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__context__
    return error is not None
