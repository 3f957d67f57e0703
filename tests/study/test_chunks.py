"""Work in chunks: every piece once, whoever does it, and whoever is killed over it."""

import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from workbench.parallel import chunks
from workbench.parallel.chunks import CHUNK, GROWTH, Chunk, KilledError, Sizes, Work, enough, in_chunks


def each(work: Callable[[int], Any]) -> Work[Any]:
    """One piece after another."""
    return lambda places: [work(place) for place in places]


square: Work[int] = each(lambda place: place**2)


def results(found: list[Chunk[int]]) -> dict[int, int]:
    return {place: result for chunk in found for place, result in zip(chunk.places, chunk.results, strict=True)}


@pytest.mark.parametrize("jobs", [1, 2])
def test_every_piece_is_done_once(jobs: int) -> None:
    found = list(in_chunks(square, range(500), jobs=jobs))
    assert sum(len(chunk.places) for chunk in found) == 500
    assert results(found) == {place: place**2 for place in range(500)}


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_chunk_that_takes_too_long_brings_back_what_it_has(monkeypatch: pytest.MonkeyPatch, jobs: int) -> None:
    """Pieces cheap at first, then dear: none waits for those behind it in its chunk, and each is made once."""
    monkeypatch.setattr(chunks, "LONGEST", 0.05)

    def work(places: Sequence[int]) -> list[int]:
        began, made = time.perf_counter(), list[int]()
        for place in places:
            time.sleep(0.03 if place >= 300 else 0.0)
            made.append(place**2)
            if enough(began):
                break
        return made

    found = list(in_chunks(work, range(330), jobs=jobs))
    assert sorted(place for chunk in found for place in chunk.places) == [*range(330)]
    assert results(found) == {place: place**2 for place in range(330)}
    assert max(len(chunk.places) for chunk in found if max(chunk.places) >= 310) <= 3


def test_threads_where_no_process_can_be_forked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunks.sys, "platform", "elsewhere")
    assert results(list(in_chunks(each(lambda place: (place, os.getpid())), range(9), jobs=2))) == {
        place: (place, os.getpid()) for place in range(9)
    }


def test_chunks_grow_to_the_time_that_may_be_lost() -> None:
    sizes = Sizes()
    assert sizes.next(1000, 2) == 1
    sizes.learn(Chunk([0], [0], 0.001))
    assert sizes.next(1000, 2) == GROWTH
    sizes.learn(Chunk([*range(100)], [*range(100)], 0.1))
    assert sizes.next(10_000, 2) == pytest.approx(CHUNK / 0.001, rel=0.01)
    assert sizes.next(32, 2) == 2, "towards the end there is work for all"
    sizes.learn(Chunk([0], [0], 10.0))
    assert sizes.next(1000, 2) == 1


def test_a_piece_whose_process_was_killed_is_done_again(tmp_path: Path) -> None:
    """Killed from outside, once: nothing is lost, and nothing said."""

    def work(place: int) -> int:
        mark = tmp_path / "killed"
        if place == 7 and not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return place**2

    assert results(list(in_chunks(each(work), range(20), jobs=2))) == {place: place**2 for place in range(20)}
    assert (tmp_path / "killed").exists()


def test_a_piece_that_kills_its_process_is_told_and_the_others_are_done() -> None:
    def work(place: int) -> int:
        if place == 7:
            os.kill(os.getpid(), signal.SIGKILL)
        return place**2

    found: list[Chunk[int]] = []
    with pytest.raises(KilledError, match="piece 7 was killed"):
        found.extend(in_chunks(each(work), range(20), jobs=2))  # a list holds what came before
    assert {*results(found)} >= {0, 1, 2}


def test_mistakes_come_from_the_process_that_made_them() -> None:
    with pytest.raises(ZeroDivisionError):
        list(in_chunks(each(lambda place: 1 // (5 - place)), range(20), jobs=2))


def test_whoever_stops_waits_for_no_piece() -> None:
    """Left early, as by Ctrl-C, all processes end."""
    began = time.monotonic()
    with closing(in_chunks(each(lambda place: time.sleep(0.0 if place < 2 else 60.0)), range(10), jobs=2)) as found:
        next(found)
    assert time.monotonic() - began < 30.0
    assert threading.active_count() >= 1


def test_processes_end_with_the_one_that_made_them(tmp_path: Path) -> None:
    """A program that is killed leaves nothing behind that works on."""
    told = tmp_path / "workers"
    told.mkdir()

    def work(place: int) -> None:
        (told / str(os.getpid())).touch()
        time.sleep(60.0)

    if (parent := os.fork()) == 0:
        list(in_chunks(each(work), range(4), jobs=2))
        os._exit(0)
    waited_for(lambda: len(list(told.iterdir())) == 2)
    os.kill(parent, signal.SIGKILL)
    os.waitpid(parent, 0)
    waited_for(lambda: not any(alive(int(path.name)) for path in told.iterdir()))


def waited_for(condition: object) -> None:
    """Until it holds; fails after a while."""
    assert callable(condition)
    for _ in range(600):
        if condition():
            return
        time.sleep(0.05)
    pytest.fail("waited in vain")


def alive(process: int) -> bool:
    """Whether a process is there and has not ended."""
    try:
        return ") Z " not in Path(f"/proc/{process}/stat").read_text()
    except FileNotFoundError:
        return False
