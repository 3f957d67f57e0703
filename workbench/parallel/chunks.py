"""Many pieces of work, done in chunks of about the same time: each piece is worth less than handing it over.

A chunk takes as long as a kill may cost, and how many pieces that are follows from what those before have taken. Chunks
go to processes where the system can fork one: a case is part compiled code, part Python, of which a process runs one
thread at a time. The results are the same wherever they are made; they come as they end.
"""

import functools
import gc
import os
import sys
import threading
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.context import ForkContext, ForkProcess
from typing import Any, Generic, TypeVar

from workbench.parallel.cluster import Watch, connected, done_there, finished, packed, result_of
from workbench.parallel.workers import job_count
from workbench.stopping import held_back, in_a_worker

Result = TypeVar("Result")

CHUNK = 0.2
"""s, about, that a chunk takes."""

LONGEST = 2.0 * CHUNK
"""s after which a chunk brings back what it has: its pieces cost more than those before."""

GROWTH = 8
"""By which a chunk may be longer than those before."""

AHEAD = 2
"""Chunks that are given out for each worker: one that it works on, one that it finds when that is done."""

PARTS = 8
"""Chunks into which a worker's share of what is left is cut at least: at the end none waits long for another."""

ATTEMPTS = 2
"""Times that a piece may take its process down with it; one that was stopped from outside is done again."""

WATCHED = 0.2
"""s between two looks of a process at whether the one that made it is still there."""


@dataclass(frozen=True)
class Chunk(Generic[Result]):
    """What was made of some pieces, and the time (s) that it took."""

    places: Sequence[int]
    results: Sequence[Result]
    took: float


Work = Callable[[Sequence[int]], Sequence[Result]]
"""Makes the results of some pieces, in their order; a number tells each from the others. Where that takes much longer
than a chunk should (`enough`) it may end before the last of them; at least one is made."""


def enough(began: float, share: float = 1.0) -> bool:
    """Whether a chunk that `began` (by time.perf_counter) has taken so long that what is made is to be brought back, or
    a share of that time.
    """
    return time.perf_counter() - began > share * LONGEST


def in_chunks(
    work: Work[Result], places: Sequence[int], *, jobs: int | None = None, cluster: str | None = None
) -> Generator[Chunk[Result], None, None]:
    """The results of all pieces, in chunks, as they end.

    Args:
        work: what is to be done; on a cluster it travels, once to each worker.
        places: the pieces, by number.
        jobs: how many are worked on at a time on this machine; default one a core.
        cluster: address of a dask scheduler to work on instead.

    Raises:
        KilledError: a piece takes its process down whenever it is begun.
        UserError: no scheduler answers at the address `cluster`, or it goes away.
    """
    if cluster is not None:
        yield from _on_cluster(cluster, functools.partial(_chunk, work), places)
        return
    with _not_collected():
        if job_count(jobs) == 1 or len(places) < 2:
            yield from _one_by_one(work, places)
        elif sys.platform == "linux":
            yield from _in_processes(work, places, min(job_count(jobs), len(places)))
        else:  # a fork leaves libraries half alive
            yield from _in_threads(work, places, min(job_count(jobs), len(places)))


@contextmanager
def _not_collected() -> Iterator[None]:
    """What lives already is not looked through for garbage again and again, a million objects that stay."""
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


class KilledError(Exception):
    """The process that worked on the piece at `place` was killed, each time it was begun."""

    def __init__(self, place: int) -> None:
        super().__init__(f"the process that worked on piece {place} was killed {ATTEMPTS} times")
        self.place = place


class Sizes:
    """How many pieces make a chunk, from what those before have taken; never more than `most`."""

    def __init__(self, most: int = sys.maxsize) -> None:
        self._most = most
        self._cost = 0.0
        self._size = 1

    def learn(self, chunk: Chunk[Result]) -> None:
        """Take note of what a chunk has cost."""
        each = max(chunk.took / len(chunk.places), 1e-9)
        self._cost = each if self._cost == 0.0 else 0.5 * (self._cost + each)
        self._size = max(1, min(int(CHUNK / self._cost), GROWTH * len(chunk.places), self._most))

    def next(self, left: int, workers: int) -> int:
        """How many pieces the next chunk has, of so many that are left: towards the end all workers have some."""
        return max(1, min(self._size, left // (PARTS * workers)))


def _chunk(work: Work[Result], places: Sequence[int]) -> Chunk[Result]:
    began = time.perf_counter()
    results = work(places)
    return Chunk(places[: len(results)], results, time.perf_counter() - began)


def _one_by_one(work: Work[Result], places: Sequence[int]) -> Iterator[Chunk[Result]]:
    """Chunks one after another, by whoever asks."""
    begun, sizes = 0, Sizes()
    while begun < len(places):
        chunk = _chunk(work, places[begun : begun + sizes.next(len(places) - begun, 1)])
        begun += len(chunk.places)
        sizes.learn(chunk)
        yield chunk


def _in_threads(work: Work[Result], places: Sequence[int], workers: int) -> Iterator[Chunk[Result]]:
    executor = ThreadPoolExecutor(workers)
    try:
        yield from _handed_out(executor, functools.partial(_chunk, work), places, workers, Sizes(), {})
    finally:
        executor.shutdown(cancel_futures=True)


Held = dict[Future[Chunk[Result]], Sequence[int]]
"""What workers have been given and have not brought back."""


def _handed_out(
    executor: Executor,
    work: Callable[[Sequence[int]], Chunk[Result]],
    places: Sequence[int],
    workers: int,
    sizes: Sizes,
    held: Held[Result],
) -> Iterator[Chunk[Result]]:
    """Chunks from an executor's workers, as they end."""
    left = _Left(places)
    while left or held:
        while left and len(held) < AHEAD * workers:
            chosen = left.take(sizes.next(len(left), workers))
            held[executor.submit(work, chosen)] = chosen
        for future in wait(held, return_when=FIRST_COMPLETED).done:
            chunk = future.result()
            left.give_back(held.pop(future)[len(chunk.places) :])
            sizes.learn(chunk)
            yield chunk


class _Left:
    """Pieces that nobody works on: from `begun` on, and before those what a chunk has brought back unmade."""

    def __init__(self, places: Sequence[int]) -> None:
        self._places, self._begun, self._back = places, 0, list[int]()

    def __len__(self) -> int:
        return len(self._back) + len(self._places) - self._begun

    def take(self, count: int) -> Sequence[int]:
        """The next so many pieces; those that were brought back by themselves."""
        if self._back:
            chosen, self._back = self._back[:count], self._back[count:]
            return chosen
        self._begun += count
        return self._places[self._begun - count : self._begun]

    def give_back(self, places: Sequence[int]) -> None:
        """Pieces that are still to be made."""
        self._back.extend(places)


def _on_cluster(
    address: str, work: Callable[[Sequence[int]], Chunk[Result]], places: Sequence[int]
) -> Iterator[Chunk[Result]]:
    """Chunks from the workers of a cluster, as many as there are now; what a lost one had begun another does."""
    with connected(address) as client:
        watch, sizes, held, left = Watch(client, address), Sizes(), dict[Any, Sequence[int]](), _Left(places)
        whole = packed(work)
        while left or held:
            hands = watch.hands()
            while left and len(held) < max(AHEAD * hands, 1):
                chosen = left.take(sizes.next(len(left), max(hands, 1)))
                held[client.submit(done_there, whole, chosen, pure=False)] = chosen
            for future in finished(client, held, watch):
                chosen = held.pop(future)
                chunk = result_of(future, watch, functools.partial(KilledError, chosen[0]))
                left.give_back(chosen[len(chunk.places) :])
                sizes.learn(chunk)
                yield chunk


def _in_processes(work: Work[Result], places: Sequence[int], workers: int) -> Iterator[Chunk[Result]]:
    """Chunks from forked processes. What a process that was killed had begun is done again, one piece at a time.

    Raises:
        KilledError: a piece for which that does not help.
    """
    left, killed, sizes = dict.fromkeys(places), dict[int, int](), Sizes()
    while left:
        again = [place for place in left if place in killed]
        held: Held[Result] = {}
        executor = ProcessPoolExecutor(1 if again else workers, Forking(), _begin, (work, os.getpid()))
        try:
            given = (again, 1, Sizes(most=1)) if again else ([*left], workers, sizes)
            for chunk in _handed_out(executor, _forked_chunk, *given, held):
                for place in chunk.places:
                    del left[place]
                    killed.pop(place, None)
                yield chunk
        except BrokenProcessPool:
            for place in (place for chosen in held.values() for place in chosen if place in left):
                killed[place] = killed.get(place, 0) + 1
                if killed[place] > ATTEMPTS:
                    raise KilledError(place) from None
        finally:
            _stop(executor)


class Worker(ForkProcess):
    """A forked process that no signal reaches until it has begun."""

    def start(self) -> None:
        """Fork it."""
        with held_back():
            super().start()


class Forking(ForkContext):
    """Makes such processes for an executor."""

    Process = Worker


def _stop(executor: ProcessPoolExecutor) -> None:
    """End all processes at once: what they have not brought back nobody waits for."""
    processes = [*(executor._processes or {}).values()]
    for process in processes:
        process.terminate()
    executor.shutdown(cancel_futures=True)


_work: Work[Any] | None = None
"""In a forked process: what it was made for."""


def _begin(work: Work[Any], parent: int) -> None:
    """Set up a forked process: it works, and ends with its parent."""
    global _work
    _work = work
    in_a_worker()
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(WATCHED)
    os._exit(1)


def _forked_chunk(places: Sequence[int]) -> Chunk[Any]:
    assert _work is not None
    return _chunk(_work, places)
