"""Finished work in SQLite, committed a little while after it is written: what a killed command does not lose."""

import json
import sqlite3
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any

from workbench.errors import UserError, spelled

COMMIT_INTERVAL = 0.25
"""Seconds between two commits, each of which waits for the disk: with that, less than half a second is at stake."""

PATIENCE = 5.0
"""Seconds to wait for another program that holds the file."""

DAMAGE = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)


class Database:
    """Rows of finished work. Several threads may use it; what one writes is committed within `COMMIT_INTERVAL`."""

    def __init__(self, connection: sqlite3.Connection, path: Path) -> None:
        self._connection, self._path, self._lock = connection, path, threading.Lock()
        self._ended = threading.Event()
        self._failed: sqlite3.Error | None = None

    def read(self, query: str, values: Sequence[object] = ()) -> list[Any]:
        """The rows that a query finds, as tuples; those not yet committed are among them.

        Raises:
            UserError: text in them is damaged.
        """
        try:
            with self._lock:
                return self._connection.execute(query, values).fetchall()
        except UnicodeDecodeError as error:
            raise damaged(self._path, error) from error

    def write(self, statement: str, *rows: Sequence[object]) -> None:
        """Change rows: all of these, or none.

        Raises:
            sqlite3.Error: they, or those before, cannot be written.
            FileNotFoundError: the file is there no more.
        """
        with self._lock:
            if self._failed is not None:
                raise self._failed
            self._path.stat()  # SQLite goes on with a file that was removed, and nobody finds what it writes
            self._connection.executemany(statement, rows)

    def commit(self) -> None:
        """Commit what was written so far.

        Raises:
            sqlite3.Error: it cannot be.
        """
        with self._lock:
            self._connection.commit()

    def commit_until_ended(self) -> None:
        """Commit again and again. What fails for good is told by the next write; who holds the file may let it go."""
        while not self._ended.wait(COMMIT_INTERVAL):
            try:
                self.commit()
            except sqlite3.Error as error:
                if _kind(error) != sqlite3.SQLITE_BUSY:
                    self._failed = error
                    return

    def end(self) -> None:
        """No more commits but the last."""
        self._ended.set()


@contextmanager
def database_at(path: Path, tables: str) -> Iterator[Database]:
    """The database at `path`, made if need be, with these `tables`: SQL that leaves alone those that are there.

    What the block writes is committed now and then, and at its end, also where that is an error.

    Raises:
        UserError: no database, or a damaged one.
        sqlite3.Error: it cannot be read or written.
    """
    try:
        with closing(sqlite3.connect(path, timeout=PATIENCE, check_same_thread=False)) as connection:
            connection.text_factory = bytes.decode
            (found,) = connection.execute("PRAGMA quick_check(1)").fetchone()
            if found != "ok":
                raise damaged(path, found.splitlines()[-1])
            connection.executescript(tables)
            database = Database(connection, path)
            committing = threading.Thread(target=database.commit_until_ended, daemon=True)
            committing.start()
            try:
                yield database
            finally:
                database.end()
                committing.join()
                database.commit()
    except sqlite3.DatabaseError as error:
        if _kind(error) not in DAMAGE:
            raise
        raise damaged(path, error) from error


def _kind(error: sqlite3.Error) -> int:
    """The first byte of SQLite's code, which says what is wrong; the rest says where. 0 of what is not SQLite's."""
    return getattr(error, "sqlite_errorcode", 0) & 0xFF


def damaged(path: Path, why: object) -> UserError:
    """The error for a database that holds what nobody wrote."""
    return UserError(f"{path}: is damaged ({why}); start anew with --overwrite, or choose another --out")


OTHERS = {"parameters": "other parameters or draws", "draws": "other draws"}
COMPARED = ("study", "draws")
"""Of what an identity holds: what is more than one, and what is kept as JSON, so that the first difference is told."""


def check_identity(database: Database, identity: Mapping[str, str], folder: Path) -> None:
    """Keep in a new database of what its rows are; hold the `identity` against that of one that is known.

    Raises:
        UserError: the rows are of something else, and of what.
    """
    known = dict(database.read("SELECT key, value FROM identity"))
    if not known:
        database.write("INSERT INTO identity VALUES (?, ?)", *identity.items())
    for key, value in identity.items():
        if known and known.get(key) != value:
            what = OTHERS.get(key, f"another {key}")
            if key in COMPARED:
                with suppress(json.JSONDecodeError):  # of an earlier version, which kept a hash
                    what += _first_difference(json.loads(known[key]), json.loads(value))
            raise UserError(
                f"{folder}: its results are of {what}; start anew with --overwrite, or choose another --out"
            )


def _first_difference(there: object, here: object, place: str = "") -> str:
    """Where the tables of two studies first differ, in brackets; "" where nothing does."""
    if isinstance(there, dict) and isinstance(here, dict):
        keys = dict.fromkeys((*there, *here))
        found = (_first_difference(there.get(key), here.get(key), f"{place}.{key}".lstrip(".")) for key in keys)
        return next(filter(None, found), "")
    return f" ({place}: {_said(there)} there, {_said(here)} here)" if there != here else ""


def _said(value: object) -> str:
    return "nothing" if value is None else spelled(value)
