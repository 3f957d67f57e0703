"""Work side by side: in order, by whoever is idle, and by no more threads than are to work."""

import threading
import time

import pytest

from workbench.fitting.threads import THREADS, free_threads, side_by_side

pytestmark = pytest.mark.usefixtures("both_threads")


def test_results_come_in_order() -> None:
    assert side_by_side(lambda one, other: one * other, range(9), range(9)) == [k * k for k in range(9)]
    assert side_by_side(abs, []) == []
    assert free_threads() == THREADS


def test_a_part_that_is_left_is_shared_with_who_is_done() -> None:
    """Of two works one is done at once; the other's parts then go side by side."""
    done, used = threading.Event(), set[int]()

    def part(_: int) -> None:
        used.add(threading.get_ident())
        time.sleep(0.02)

    def work(short: bool) -> None:
        if short:
            done.set()
            return
        done.wait(60.0)
        while free_threads() == 1:
            time.sleep(0.001)
        side_by_side(part, range(6))

    side_by_side(work, [True, False])
    assert len(used) == THREADS
    assert free_threads() == THREADS


def test_no_more_work_than_are_to() -> None:
    working, most, lock = [0], [0], threading.Lock()

    def part(_: int) -> None:
        with lock:
            working[0] += 1
            most[0] = max(most[0], working[0])
        time.sleep(0.002)
        with lock:
            working[0] -= 1

    def within(depth: int) -> None:
        side_by_side(part if depth == 0 else lambda _: within(depth - 1), range(3))

    within(3)
    assert most[0] <= THREADS
    assert free_threads() == THREADS


def test_what_fails_is_told_and_leaves_all_idle() -> None:
    def fails(number: int) -> None:
        if number == 3:
            raise ValueError("three")

    for _ in range(5):
        with pytest.raises(ValueError, match="three"):
            side_by_side(fails, range(8))
    deadline = time.monotonic() + 60.0
    while free_threads() < THREADS and time.monotonic() < deadline:
        time.sleep(0.001)
    assert free_threads() == THREADS
