"""One process at a time in a folder: a lock that the system takes back from a process that dies."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from workbench.errors import UserError

if sys.platform == "win32":
    import msvcrt

    def _lock(file: int) -> None:
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _lock(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def alone(path: Path, busy: str) -> Iterator[None]:
    """Hold the lock file at `path`, which is made if need be, while the block lasts; it is removed in the end.

    Raises:
        UserError: another process holds it; the message is `busy`.
        OSError: it cannot be made.
    """
    file = _taken(path, busy)
    try:
        yield
    finally:
        with suppress(OSError):  # its folder may be gone, and Windows removes no file that is open
            path.unlink()
        os.close(file)


def _taken(path: Path, busy: str) -> int:
    """The lock file, open and locked, and still the one at `path`: who had it before removes it when done."""
    while True:
        file = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            _lock(file)
            if os.path.samestat(os.fstat(file), os.stat(path)):
                return file
        except FileNotFoundError:
            pass
        except (BlockingIOError, PermissionError):
            os.close(file)
            raise UserError(busy) from None
        except OSError:
            os.close(file)
            raise
        os.close(file)
