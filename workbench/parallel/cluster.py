"""Work done by the workers of a dask cluster: who answers, what has ended, and who has gone."""

import logging
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from workbench.errors import UserError

if TYPE_CHECKING:
    from distributed import Client

ANSWER = 10.0
"""s in which a scheduler has to answer at first."""

LOOKS = 1.0
"""s between two looks at whether the scheduler and any worker are still there."""

GONE = 5.0
"""s without a connection after which the scheduler has gone."""

WITHOUT = 60.0
"""s in which a first worker has to come, or another where all have gone."""

CHATTER = ("distributed", "asyncio", "tornado")
"""Loggers of dask that write of every lost connection, some with a traceback."""

RESUME = "what is finished is kept: go on with --resume"


@contextmanager
def connected(address: str) -> Iterator["Client"]:
    """The cluster behind the scheduler at an address.

    Raises:
        UserError: dask is not installed, or no scheduler answers there.
    """
    try:
        from distributed import Client
    except ImportError:
        raise UserError('--cluster needs the extra "cluster": pip install "friction-workbench[cluster]"') from None
    for name in (*CHATTER, *logging.root.manager.loggerDict):
        if name.partition(".")[0] in CHATTER:
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)  # what is lost is told in our words
    try:
        client = Client(address, timeout=ANSWER)
    except (OSError, ValueError) as error:
        raise UserError(f"{address}: no scheduler answers there ({error}); start one with: dask scheduler") from None
    try:
        yield client
    finally:
        client.close(timeout=LOOKS)


class Watch:
    """Whether a cluster is still there, and how many hands it has."""

    def __init__(self, client: "Client", address: str) -> None:
        self._client, self._address = client, address
        self._connected = self._manned = time.monotonic()

    def hands(self) -> int:
        """How many pieces of work its workers do at a time, all together.

        Raises:
            UserError: the scheduler has gone, or no worker is there for long.
        """
        now = time.monotonic()
        if self._client.status == "running":
            self._connected = now
        elif self._client.status == "closed" or now - self._connected > GONE:
            raise self.gone()
        else:
            return 0  # it may come back
        try:
            found = sum(self._client.nthreads().values())
        except OSError:
            return 0  # busy, or gone: the next look tells
        if found:
            self._manned = now
        elif now - self._manned > WITHOUT:
            raise UserError(
                f"{self._address}: no worker for {WITHOUT:g} s; start one with: dask worker {self._address}; {RESUME}"
            )
        return found

    def gone(self) -> UserError:
        """What is said of a scheduler that has gone."""
        return UserError(f"{self._address}: the scheduler has gone; {RESUME}")


def finished(client: "Client", held: Mapping[Any, Sequence[int]], watch: Watch) -> list[Any]:
    """Those of the futures that have ended; waits for the first.

    Raises:
        UserError: see `Watch.hands`.
    """
    from distributed import wait

    while True:
        try:
            return list(wait(list(held), timeout=LOOKS, return_when="FIRST_COMPLETED").done)
        except TimeoutError:
            watch.hands()
        except Exception as error:
            if client.status != "running":
                raise watch.gone() from error
            raise


def result_of(future: Any, watch: Watch, killed: Callable[[], Exception]) -> Any:
    """What a future holds; the exception that was raised where it was made; `killed` where its workers died over it."""
    from distributed import CancelledError, KilledWorker

    try:
        return future.result()
    except KilledWorker:
        raise killed() from None
    except CancelledError:
        raise watch.gone() from None
