"""Work done by the workers of a dask cluster: who answers, what has ended, and who has gone."""

import functools
import logging
import platform
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from plants.equation import source_hash
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
    except ValueError as error:
        expected = "expected an address such as tcp://HOST:8786"
        raise UserError(f"{address or '--cluster'}: no scheduler answers there ({error}); {expected}") from None
    except OSError as error:
        raise UserError(f"{address}: no scheduler answers there ({error}); start one with: dask scheduler") from None
    try:
        yield client
    finally:
        client.close(timeout=LOOKS)


def check_answer(address: str | None) -> None:
    """Nothing is begun, nor written, where a cluster is asked for whose scheduler does not answer.

    Raises:
        UserError: see `connected`.
    """
    if address is not None:
        with connected(address):
            pass


def packed(work: Callable[..., Any]) -> bytes:
    """Work as it travels to a worker, which unpacks it once."""
    from distributed.protocol.pickle import dumps

    return dumps(work)


def done_there(work: bytes, *arguments: Any) -> Any:
    """On a worker: do `packed` work with these arguments."""
    return _unpacked(work)(*arguments)


@functools.lru_cache(maxsize=2)
def _unpacked(work: bytes) -> Callable[..., Any]:
    from distributed.protocol.pickle import loads

    return loads(work)


def check_version(version: str, folders: Sequence[str]) -> None:
    """Raises UserError where these folders of the program are of another version than that of whoever asks."""
    if source_hash(folders) != version:
        raise UserError(f"worker {platform.node()}: has another version of this program; install the same one there")


class Asked:
    """Work whose pieces any thread asks for, one at a time: each goes to a worker of the cluster at `address`."""

    def __init__(self, client: "Client", address: str, work: Callable[..., Any]) -> None:
        self._client, self._watch, self._work = client, Watch(client, address), packed(work)

    def __call__(self, *arguments: Any) -> Any:
        """What the work makes of these arguments; what a lost worker had begun another does.

        Raises:
            UserError: the scheduler has gone, or no worker is there for long, or they die over it.
        """
        self._watch.hands()
        future = self._client.submit(done_there, self._work, *arguments, pure=False)
        while not finished(self._client, {future: ()}, self._watch):
            pass
        return result_of(future, self._watch, self._killed)

    def _killed(self) -> Exception:
        return UserError(f"its workers are killed whenever they run a part, as by a lack of memory; {RESUME}")


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
    from distributed.comm import CommClosedError

    try:
        return future.result()
    except KilledWorker:
        raise killed() from None
    except (CancelledError, CommClosedError):
        raise watch.gone() from None
