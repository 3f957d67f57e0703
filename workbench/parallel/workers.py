"""Work done several at a time, on this machine's cores or on a cluster."""

import os
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager

from workbench.errors import UserError


def job_count(jobs: int | None) -> int:
    """How many pieces of work run at a time: as asked for, else one a core."""
    return jobs or os.cpu_count() or 1


@contextmanager
def workers(jobs: int | None = None, cluster: str | None = None) -> Iterator[Executor]:
    """Who does the work: threads of this machine, since compiled code lets other threads run, or a dask scheduler.

    Where the block is left by an error, or by Ctrl-C, what has not begun never will.

    Raises:
        UserError: no scheduler answers at the address `cluster`.
    """
    with ThreadPoolExecutor(job_count(jobs)) if cluster is None else _on_cluster(cluster) as executor:
        try:
            yield executor
        except BaseException:
            executor.shutdown(wait=False, cancel_futures=True)
            raise


@contextmanager
def _on_cluster(address: str) -> Iterator[Executor]:
    try:
        from distributed import Client
    except ImportError:
        raise UserError('--cluster needs the extra "cluster": pip install "friction-workbench[cluster]"') from None
    try:
        client = Client(address, timeout=10)
    except (OSError, ValueError) as error:
        raise UserError(f"{address}: no scheduler answers there ({error})") from None
    with client, client.get_executor() as executor:
        yield executor
