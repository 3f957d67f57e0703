"""How far a diagnosis is."""

from typing import Protocol


class Tell(Protocol):
    """Is told in words what is being done, and which share of the time it takes is over: as it mostly is."""

    def __call__(self, said: str, done: float) -> None: ...
