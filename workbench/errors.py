"""What a user can get wrong, said in one or two lines."""

from collections.abc import Iterable
from difflib import get_close_matches


class UserError(Exception):
    """A mistake in a file or a command: what was got, where, what was expected, the fix. Exit code 2."""


class MetricError(UserError):
    """A metric of a plug-in that raises."""


def nearest(name: str, valid: Iterable[str]) -> str:
    """A hint for a misspelled name: the nearest valid one, or else all that there are."""
    names = list(valid)
    close = get_close_matches(name, names, n=1, cutoff=0.6)
    if close:
        return f'did you mean "{close[0]}"?'
    return "expected one of " + ", ".join(names) if names else "none is expected here"
