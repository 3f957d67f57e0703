"""How far long work is: who does it tells, who waits for it shows it."""

from typing import Protocol


class Progress(Protocol):
    """Is told in words what is being done, and which share (0 to 1) of the whole is over; None where nobody knows."""

    def __call__(self, doing: str, done: float | None = None, /) -> None: ...


def silent(doing: str, done: float | None = None, /) -> None:
    """Progress that nobody watches."""


def part_of(progress: Progress, begin: float, share: float) -> Progress:
    """Progress of a part of the work, told to that of the whole: the part begins at `begin` and is a `share` of it."""

    def told(doing: str, done: float | None = None, /) -> None:
        progress(doing, None if done is None else begin + share * done)

    return told


def of_unknown_length(progress: Progress) -> Progress:
    """Progress of work of which nobody knows how much is left."""
    return lambda doing, done=None, /: progress(doing)
