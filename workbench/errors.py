"""What a user can get wrong, said in one to three lines that a terminal shows as they are."""

import re
from collections.abc import Iterable
from difflib import get_close_matches
from unicodedata import category

MOST_LINES, LONGEST_LINE = 3, 400
"""Of a message: lines, and characters of each behind the place that it begins with."""

LONGEST_VALUE = 60
"""Characters of a value that a message quotes."""

LONGEST_LIST = 200
"""Characters of names that a message lists."""

ENDLESS = re.compile(r"[^\s/]{121,}")
"""What no word is."""

LONGEST_SOUGHT = 200
"""Characters of a name from which on it is no misspelled other one."""

UNSEEN = {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}
"""Unicode's categories of characters that steer a terminal, or show nothing."""


class UserError(Exception):
    """A mistake in a file or a command: what was got, where, what was expected, the fix. Exit code 2."""

    def __init__(self, message: str) -> None:
        super().__init__(in_few_lines(message))


class MetricError(UserError):
    """A metric of a plug-in that raises."""


def visible(text: str) -> str:
    r"""Text without characters that steer a terminal or show nothing: each as its escape, such as \x1b; lines stay."""
    if text.isascii() and text.replace("\n", "").isprintable():
        return text
    return "".join(ascii(letter)[1:-1] if category(letter) in UNSEEN and letter != "\n" else letter for letter in text)


def in_few_lines(text: str) -> str:
    """A message of at most `MOST_LINES` visible lines, none much longer than `LONGEST_LINE`."""
    lines = visible(text).split("\n")
    if len(lines) > MOST_LINES:
        lines = [*lines[: MOST_LINES - 1], f"... and {len(lines) - MOST_LINES + 1} lines more"]
    return "\n".join(map(in_one_line, lines))


def in_one_line(line: str) -> str:
    """A line of a message with its middle left out where it is too long; the place that it begins with is not."""
    place, colon, said = line.partition(": ")
    if len(place) > LONGEST_LINE:
        place, colon, said = "", "", line
    said = ENDLESS.sub(lambda found: shortened(found[0]), said)
    if len(said) > LONGEST_LINE:
        end = LONGEST_LINE // 3
        said = f"{said[: LONGEST_LINE - end - 5]} ... {said[-end:]}"
    return place + colon + said


def shortened(text: str, longest: int = LONGEST_VALUE) -> str:
    """Text as a message quotes it: on one line, its beginning and its length where it is long."""
    shown = visible(text[: longest + 1]).replace("\n", "\\n")
    return shown if len(shown) <= longest else f"{shown[:longest]}... ({len(text):,} characters)".replace(",", " ")


def spelled(value: object) -> str:
    """A value as Python spells it, `shortened`."""
    if isinstance(value, int) and abs(value) >= 10**LONGEST_VALUE:
        return "a whole number of very many digits"
    return shortened(repr(value))


def few_of(names: Iterable[str], longest: int = LONGEST_LIST) -> str:
    """Names in a row; of many those that begin it, and how many there are more."""
    found = [shortened(str(name)) for name in names]
    shown, length = 0, 0
    while shown < len(found) and length + len(found[shown]) <= longest:
        length += len(found[shown]) + 2
        shown += 1
    more = len(found) - shown
    return ", ".join(found[:shown]) + (f" and {more} more" if more else "")


def nearest(name: str, valid: Iterable[str], broken: Iterable[str] = (), *, with_others: bool = False) -> str:
    """A hint for a misspelled name: the nearest valid one, or else all that there are.

    `broken` tells of plug-ins that might have brought the name, and cannot be used; `with_others` tells all beside the
    nearest, too.
    """
    names = list(valid)
    close = get_close_matches(name, names, n=1, cutoff=0.6) if len(name) <= LONGEST_SOUGHT else []
    hint = f"expected one of {few_of(names)}" if names else "none is expected here"
    if close:
        hint = f'did you mean "{close[0]}"?' + (f" There are {few_of(names)}" if with_others else "")
    reasons = "; ".join(broken)
    return hint + ((" " if close else "; ") + reasons if reasons else "")
