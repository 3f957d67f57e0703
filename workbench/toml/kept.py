"""Numbers that a slow library gives for two words, kept between runs of the program in the user's cache folder."""

import contextlib
import functools
import json
import os
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import TypeVar

from plants.cache import cache_folder

Number = TypeVar("Number", float, float | None)


def kept_with(library: str) -> Callable[[Callable[[str, str], Number]], Callable[[str, str], Number]]:
    """Decorator: keep what a function returns while the version of `library` is the same; an error is not kept.

    A file that cannot be read or written is done without: the library is then asked again.
    """

    def keep(function: Callable[[str, str], Number]) -> Callable[[str, str], Number]:
        @functools.cache
        def known() -> tuple[Path, dict[str, Number]]:
            path = cache_folder() / f"{library}_{version(library)}_{function.__name__.strip('_')}.json"
            try:
                numbers = json.loads(path.read_text(encoding="utf-8"))
            except (OSError, ValueError):
                numbers = {}
            return path, numbers if isinstance(numbers, dict) else {}

        @functools.wraps(function)
        def looked_up(first: str, second: str) -> Number:
            path, numbers = known()
            key = f"{first} | {second}"
            if key not in numbers:
                numbers[key] = function(first, second)
                with contextlib.suppress(OSError):
                    _write(path, json.dumps(dict(numbers)))
            return numbers[key]

        return looked_up

    return keep


def _write(path: Path, text: str) -> None:
    """Write the file whole: of processes that write at once one wins, and what it did not know is found again."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with NamedTemporaryFile("w", dir=path.parent, delete=False, encoding="utf-8") as file:
        file.write(text)
    os.replace(file.name, path)
