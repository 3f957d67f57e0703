"""What no file of ours holds, whatever it is about: endless numbers, dates, endless depth, unseen characters."""

import datetime
from collections.abc import Mapping

Key = tuple[str | int, ...]

MOST_LEVELS = 30
"""Of tables and lists in each other; ours have seven."""

MOST_VALUES = 5_000_000
"""Values in a file; a study of a million cases may name each."""

MOST_WHOLE = 2**63
"""TOML's whole numbers have 64 bits."""

TOO_LONG = "a whole number has too many digits, expected at most 19; write it with a point or an exponent, such as 1e30"

UNSEEN = frozenset(map(chr, (*range(9), 11, 12, *range(14, 32), *range(127, 160))))
"""Characters that steer a terminal; tabs and ends of lines are none of them."""


class UnsoundError(Exception):
    """A value that no file of ours holds: its key, and what is wrong."""

    def __init__(self, key: Key, message: str) -> None:
        super().__init__(message)
        self.key = key
        self.message = message


def check_sound(data: Mapping[str, object]) -> None:
    """Look at all of a file's content, table by table.

    Raises:
        UnsoundError: a value or a key that cannot be meant.
    """
    waiting: list[tuple[Key, Mapping[str, object] | list[object]]] = [((), data)]
    seen = 0
    while waiting:
        key, table = waiting.pop()
        if len(key) >= MOST_LEVELS:
            raise UnsoundError(key[:3], f"lists or tables in each other are too deep, expected at most {MOST_LEVELS}")
        seen += len(table)
        if seen > MOST_VALUES:
            raise UnsoundError((), f"holds more than {MOST_VALUES} values, which is the most")
        for name, value in table.items() if isinstance(table, Mapping) else enumerate(table):
            if isinstance(name, str) and (found := _unseen(name)):
                raise UnsoundError(
                    (*key, name), f"got a key with the character {found}, which nobody sees; leave it out"
                )
            if isinstance(value, dict | list):
                waiting.append(((*key, name), value))
            elif wrong := _wrong(value):
                raise UnsoundError((*key, name), wrong)


def _wrong(value: object) -> str:
    """Why a single value cannot be meant, in words; "" where it can."""
    if isinstance(value, str):
        return (
            f"got text with the character {found}, which nobody sees; leave it out" if (found := _unseen(value)) else ""
        )
    if isinstance(value, int):
        return "" if -MOST_WHOLE <= value < MOST_WHOLE else TOO_LONG
    if isinstance(value, datetime.date | datetime.time):
        return f"got the date or time {value}, expected text in quotes, or a number"
    return ""


def _unseen(text: str) -> str:
    """The first character that steers a terminal, as Python spells it; "" without any."""
    if text.isprintable():
        return ""
    return next((ascii(letter) for letter in text if letter in UNSEEN), "")
