"""Names from files as names of files: one function, which nothing leads out of its folder."""

import hashlib
import re
from typing import Annotated

from pydantic import Field

from workbench.errors import UNSEEN, category

LONGEST = 180
"""Bytes of a name: with what is put before and behind it, it stays below the 255 of most file systems."""

ESCAPE = "%"
SEPARATING = frozenset('/\\:*?"<>|' + ESCAPE)
"""Characters that separate folders, or stand for others, on some system; and that of the escapes."""

RESERVED = re.compile(r"(con|prn|aux|nul|(com|lpt)[0-9¹²³])(\..*)?", re.IGNORECASE)
"""Names of devices on Windows, with any ending."""

FileName = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-][A-Za-z0-9_.-]*$", max_length=LONGEST)]
"""A name that a study gives to one of its files, as it stands."""


def file_name(name: str) -> str:
    """The name of a file, or of a folder, for a name that a user's file gives: different ones for different names.

    An ordinary name stays as it is. What separates folders or steers a terminal, dots and spaces at the ends, and what
    a system keeps for itself, become escapes such as %2F; of a long name the beginning is left, with a hash of it all.
    """
    shown = "".join(_escaped(letter) if _is_special(letter) else letter for letter in name) or ESCAPE
    if shown[0] == "." or RESERVED.fullmatch(shown):
        shown = _escaped(shown[0]) + shown[1:]
    if shown[-1] in ". ":
        shown = shown[:-1] + _escaped(shown[-1])
    if len(shown.encode()) > LONGEST:
        told = hashlib.sha256(name.encode(errors="surrogatepass")).hexdigest()
        shown = f"{shown.encode()[: LONGEST - 66].decode(errors='ignore')}{ESCAPE}~{told}"
    return shown


def is_file_name(name: object) -> bool:
    """Whether something read from a file of results is the name of a file in a folder, and leads nowhere else."""
    return isinstance(name, str) and not {"/", "\\", "\0"} & {*name} and name not in ("", ".", "..")


def _is_special(letter: str) -> bool:
    return letter in SEPARATING or (not " " <= letter <= "~" and category(letter) in UNSEEN)


def _escaped(letter: str) -> str:
    return "".join(f"{ESCAPE}{byte:02X}" for byte in letter.encode(errors="surrogatepass"))
