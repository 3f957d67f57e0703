"""What a user can get wrong, said in one or two lines."""

from collections.abc import Iterable
from difflib import get_close_matches


class UserError(Exception):
    """A mistake in a file or a command: what was got, where, what was expected, the fix. Exit code 2."""


class MetricError(UserError):
    """A metric of a plug-in that raises."""


def nearest(name: str, valid: Iterable[str], broken: Iterable[str] = ()) -> str:
    """A hint for a misspelled name: the nearest valid one, or else all that there are.

    `broken` tells of plug-ins that might have brought the name, and cannot be used.
    """
    names = list(valid)
    close = get_close_matches(name, names, n=1, cutoff=0.6)
    hint = "expected one of " + ", ".join(names) if names else "none is expected here"
    if close:
        hint = f'did you mean "{close[0]}"?'
    reasons = "; ".join(broken)
    return hint + ((" " if close else "; ") + reasons if reasons else "")
