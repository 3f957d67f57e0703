"""An FMU's archive: read and unpacked so that nothing in it leads elsewhere, or grows beyond bounds."""

import hashlib
import stat
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from shutil import copyfileobj
from typing import IO

from workbench.errors import UserError, shortened

DESCRIPTION = "modelDescription.xml"

MOST_FILES = 10_000
MOST_BYTES = 2**30
"""Of all files unpacked."""

MOST_DESCRIPTION = 2**24
"""Bytes of the description."""


def sha256_of(path: Path) -> str:
    """A hash of a file's content.

    Raises:
        UserError: it cannot be read.
    """
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({error.strerror})") from None


def read_description(path: Path) -> tuple[bytes, tuple[str, ...]]:
    """The description of an FMU, and the names of all files in it.

    Raises:
        UserError: it is no archive, or not one of an FMU.
    """
    with _opened(path) as archive:
        names = tuple(item.filename for item in _checked(path, archive))
        if DESCRIPTION not in names:
            raise UserError(f"{path}: holds no {DESCRIPTION}; expected an FMU")
        with archive.open(DESCRIPTION) as file:
            content = file.read(MOST_DESCRIPTION + 1)
        if len(content) > MOST_DESCRIPTION:
            raise UserError(f"{path}: {DESCRIPTION} is longer than {MOST_DESCRIPTION} bytes")
        return content, names


def unpack(path: Path, folder: Path, beginnings: tuple[str, ...]) -> None:
    """Unpack into `folder` the files of an FMU whose names begin with one of these.

    Raises:
        UserError: as `read_description`, or more bytes than the archive says.
    """
    with _opened(path) as archive:
        for item in _checked(path, archive):
            if item.is_dir() or not item.filename.startswith(beginnings):
                continue
            target = folder / item.filename
            target.parent.mkdir(parents=True, exist_ok=True)
            with archive.open(item) as source, target.open("wb") as made:
                copyfileobj(_Bounded(path, source, item.file_size), made)


class _Bounded:
    """A stream of which no more is read than was promised."""

    def __init__(self, path: Path, stream: IO[bytes], size: int) -> None:
        self._path, self._stream, self._left = path, stream, size

    def read(self, count: int = -1) -> bytes:
        data = self._stream.read(count)
        self._left -= len(data)
        if self._left < 0:
            raise UserError(f"{self._path}: holds more than its list of files says")
        return data


@contextmanager
def _opened(path: Path) -> Iterator[zipfile.ZipFile]:
    try:
        with zipfile.ZipFile(path) as archive:
            yield archive
    except OSError as error:
        if error.strerror is None:
            raise UserError(f"{path}: a damaged archive ({shortened(str(error))})") from None
        raise UserError(f"{path}: cannot be read ({error.strerror})") from None
    except (zipfile.BadZipFile, zlib.error, EOFError, ValueError, NotImplementedError, RuntimeError) as error:
        raise UserError(f"{path}: no archive that can be read ({shortened(str(error))}); expected an FMU") from None


def _checked(path: Path, archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    """All files of the archive, of which none leads out of a folder into which they are unpacked."""
    items = archive.infolist()
    if len(items) > MOST_FILES:
        raise UserError(f"{path}: holds {len(items)} files, expected at most {MOST_FILES}")
    if sum(item.file_size for item in items) > MOST_BYTES:
        raise UserError(f"{path}: would unpack to more than {MOST_BYTES} bytes")
    for item in items:
        place = PurePosixPath(item.filename)
        odd = place.is_absolute() or ".." in place.parts or "\\" in item.filename or ":" in item.filename
        if odd or stat.S_ISLNK(item.external_attr >> 16):
            raise UserError(
                f'{path}: its file "{shortened(item.filename)}" leads out of the archive; nothing is unpacked'
            )
    return items
