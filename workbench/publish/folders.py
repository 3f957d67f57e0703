"""Folders of results: which files in them are ours to replace, and writing that is whole or not at all."""

import os
import shutil
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from workbench.errors import UserError
from workbench.publish.locks import alone

T = TypeVar("T")

LOCK = ".lock"
"""The file by which a command has a folder for itself, while it is at work."""


def remove(path: Path) -> None:
    """Remove a file, or a folder with all that is in it; nothing happens where there is neither."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def made(folder: Path) -> Path:
    """Make a folder of results, in which everything is written.

    Raises:
        UserError: it is a link: what is written there would lie elsewhere.
    """
    if folder.is_symlink():
        raise UserError(f"{folder}: is a link that leads elsewhere, where nothing is written; remove it")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def anew(path: Path) -> Path:
    """The path, without what was there if that is a link: what is written there does not go where it leads."""
    if path.is_symlink():
        path.unlink()
    return path


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` make a file beside `path`, then move it there: whenever this is stopped, `path` is whole."""
    temporary = path.with_name(f".{path.name}.part")
    temporary.unlink(missing_ok=True)  # it may be a link that leads elsewhere, or what a kill left
    try:
        write(temporary)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def held(folder: Path, names: Sequence[str]) -> str:
    """Which of these names a folder holds, in words; empty if none."""
    return ", ".join(name for name in names if (folder / name).exists())


def unwritable(folder: Path, error: Exception) -> UserError:
    """The error for a folder in which nothing can be made."""
    is_file = isinstance(error, FileExistsError | NotADirectoryError)
    why = "it is a file, or lies in one" if is_file else str(error)
    return UserError(f"{folder}: cannot be written ({why}); choose another folder with --out")


@contextmanager
def faults_told(folder: Path, kept: str) -> Iterator[None]:
    """What the disk or a database refuses while work goes into `folder`, in one line that says what is `kept`.

    Raises:
        UserError: a full disk, a folder that is gone or cannot be written, a database that another program holds.
    """
    try:
        yield
    except (OSError, sqlite3.OperationalError) as error:
        place, why = folder, str(error)
        if isinstance(error, OSError) and error.strerror:
            place, why = Path(error.filename or folder), error.strerror
        raise UserError(f"{place}: {why}; {kept}") from error


@contextmanager
def _alone_in(folder: Path, lock: Path) -> Iterator[None]:
    """The folder for this process alone, with a `lock` in it or, where nothing may be there yet, beside it."""
    busy = f"{folder}: another command is at work there; wait for it, or choose another --out"
    with ExitStack() as stack:
        try:
            lock.parent.mkdir(parents=True, exist_ok=True)
            stack.enter_context(alone(lock, busy))
        except OSError as error:
            raise unwritable(folder, error) from None
        yield


@dataclass(frozen=True)
class GrowingFolder:
    """What one command, whose work messages call a `noun`, writes while it works, and can go on with: its `content`.

    The last of `names` is the mark that the folder is the command's own. What is `kept` may be the command's too, but
    is never removed.
    """

    noun: str
    content: str
    names: tuple[str, ...]
    kept: tuple[str, ...] = ()

    @contextmanager
    def opened(self, folder: Path, *, resume: bool = False, overwrite: bool = False) -> Iterator[Path]:
        """The folder for this process alone, made if need be; yields the path of the mark.

        With `resume` earlier results stay, where there are any; else it is without any.

        Raises:
            UserError: it holds results already, or files of the same names that the command did not write; it cannot be
                written; another command is at work there; or the disk fails while the block is.
        """
        if resume and overwrite:
            raise UserError("--resume and --overwrite: choose one")
        kept = f"what is finished is kept in {folder}: mend that, then go on with --resume"
        with _alone_in(folder, folder / LOCK), faults_told(folder, kept):
            mark = folder / self.names[-1]
            yield mark if resume and mark.exists() else self._begun(folder, overwrite)

    def _begun(self, folder: Path, overwrite: bool) -> Path:
        """Make the folder, without earlier results; returns the path of the mark."""
        mark = folder / self.names[-1]
        if mark.exists() and not overwrite:
            raise UserError(f"{folder}: holds {self.content} already; go on with --resume, start anew with --overwrite")
        foreign = held(folder, (*self.kept, *self.names))
        if foreign and not mark.exists():
            raise UserError(f"{folder}: holds {foreign} that no {self.noun} wrote; choose another folder with --out")
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for name in (*self.names, f"{self.names[-1]}-journal"):
                remove(folder / name)
        except OSError as error:
            raise unwritable(folder, error) from None
        return mark


@dataclass(frozen=True)
class ResultFolder:
    """What one command, whose work messages call a `noun`, writes into the folder of its results.

    The first of `names` is the mark that all are there: it goes first and comes last. `is_ours` says of a file of that
    name whether the command wrote it.
    """

    noun: str
    names: tuple[str, ...]
    is_ours: Callable[[Path], bool] = Path.exists

    @contextmanager
    def claimed(self, folder: Path, overwrite: bool) -> Iterator[None]:
        """The folder, or the place for it, for this process alone, and without what a kill has left beside it.

        Raises:
            UserError: as `check`; another command is at work there; or the disk fails while the block is.
        """
        folder = Path(os.path.abspath(folder))
        self.check(folder, overwrite)
        lock = folder / LOCK if folder.exists() else folder.parent / f".{folder.name}{LOCK}"
        with _alone_in(folder, lock), faults_told(folder, "nothing is written: mend that and run it again"):
            for path in self._places(folder):
                remove(path)
            yield

    def check(self, folder: Path, overwrite: bool) -> None:
        """Whether they may be written there; nothing is changed.

        Raises:
            UserError: it is no folder, holds such results, or files of the same names that the command did not write.
        """
        if folder.exists() and not folder.is_dir():
            raise UserError(f"{folder}: is a file; give --out a folder")
        mark = folder / self.names[0]
        if mark.exists() and not overwrite:
            article = "an" if self.noun[0] in "aeiou" else "a"
            raise UserError(f"{folder}: holds {article} {self.noun} already; replace it with --overwrite")
        foreign = held(folder, self.names)
        if foreign and not (self._unfinished(folder).exists() or self.is_ours(mark)):
            raise UserError(f"{folder}: holds {foreign} that no {self.noun} wrote; choose another --out")

    def write(self, folder: Path, write: Callable[[Path], T]) -> T:
        """Let `write` fill an empty folder of its own, then move all to `folder`; returns what `write` returns.

        Whenever this is stopped, the mark is whole, and all others with it, or is not there.
        """
        folder = Path(os.path.abspath(folder))
        folder.parent.mkdir(parents=True, exist_ok=True)
        within, beside = self._places(folder)
        written = within if folder.exists() else beside  # the folder may be a disk of its own
        remove(written)
        try:
            written.mkdir()
            returned = write(written)
            if folder.exists():
                self._replace(written, folder)
            else:
                os.rename(written, folder)
        finally:
            remove(written)
        return returned

    def _places(self, folder: Path) -> tuple[Path, Path]:
        """Where files are until they are whole: in the folder if it is there, or beside it."""
        return folder / f".{self.noun}.part", folder.parent / f".{folder.name}.part"

    def _replace(self, written: Path, folder: Path) -> None:
        self._unfinished(folder).touch()
        for name in self.names:
            remove(folder / name)
        for name in reversed(self.names):
            if (written / name).exists():
                os.replace(written / name, folder / name)
        self._unfinished(folder).unlink()

    def _unfinished(self, folder: Path) -> Path:
        return folder / f".unfinished_{self.noun}"
