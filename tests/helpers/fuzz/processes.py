"""Trials in several processes, each of which may hang, or die, without the others."""

import faulthandler
import multiprocessing
import os
import tempfile
import time
from collections.abc import Iterator
from multiprocessing.connection import Connection, wait
from pathlib import Path

from fuzz.sandbox import Sandbox
from fuzz.trials import trial
from fuzz.watch import LONGEST_SECONDS, warmed

ANSWERED = 30 * LONGEST_SECONDS
"""Seconds within which a process that hears no alarm, as in compiled code, is given up."""

Tried = tuple[int, str, list[tuple[str, str]]]
"""Number of a mutant, what became of it, and what was found: kinds and words."""


def tried(kind: str, seed: int, numbers: range, seconds: float, jobs: int) -> Iterator[Tried]:
    """The mutants of these numbers, for so long; a process that ends or hangs is a finding, another takes its place."""
    context, until = multiprocessing.get_context("spawn"), time.monotonic() + seconds

    def start(first: int) -> tuple[Connection, multiprocessing.process.BaseProcess]:
        ours, theirs = context.Pipe()
        process = context.Process(target=_worker, args=(theirs, kind, seed, range(first, numbers.stop, jobs), until))
        process.start()
        theirs.close()
        return ours, process

    running = dict(start(numbers.start + job) for job in range(jobs))
    current: dict[Connection, int] = {}
    while running:
        for pipe in wait(list(running)):
            assert isinstance(pipe, Connection)
            try:
                message = pipe.recv()
            except EOFError:
                running.pop(pipe).join()
                lost = current.pop(pipe, None)
                if lost is not None:
                    yield lost, "lost", [("hang", "the process ended, or did not answer to the alarm")]
                    running |= dict([start(lost + jobs)])
                continue
            if isinstance(message, int):
                current[pipe] = message
            else:
                current.pop(pipe, None)
                yield message


def _worker(pipe: Connection, kind: str, seed: int, numbers: range, until: float) -> None:
    """Trials, each announced before it is done: who reads knows which one a process died of."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    with tempfile.TemporaryDirectory() as folder:
        sandbox = warmed(Sandbox(Path(folder)), kind)
        for number in numbers:
            if time.monotonic() > until:
                break
            pipe.send(number)
            faulthandler.dump_traceback_later(ANSWERED, exit=True)  # compiled code hears no alarm
            one = trial(sandbox, kind, seed, number)
            faulthandler.cancel_dump_traceback_later()
            pipe.send((number, one.done, [(finding.kind, finding.what) for finding in one.findings]))
