"""Work done several at a time, by threads of one process."""

import os
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager


def job_count(jobs: int | None) -> int:
    """How many pieces of work run at a time: as asked for, else one a core."""
    return jobs or os.cpu_count() or 1


@contextmanager
def workers(jobs: int | None = None) -> Iterator[Executor]:
    """Threads of this machine that do the work, since compiled code lets other threads run.

    Where the block is left by an error, or by Ctrl-C, what has not begun never will.
    """
    with ThreadPoolExecutor(job_count(jobs)) as executor:
        try:
            yield executor
        except BaseException:
            executor.shutdown(wait=False, cancel_futures=True)
            raise
