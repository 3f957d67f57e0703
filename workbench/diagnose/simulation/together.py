"""Simulations that are asked for together go side by side: columns of a Jacobian, starts that are moved, candidates.

Several of one record share its plant and its input, and are solved at once (`simulate_together`); effects that act in
one of them alone do nothing in the others, whose bits they leave as they are.
"""

from collections import OrderedDict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np

from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.fitting.threads import THREADS, side_by_side
from workbench.simulation.simulate import LANES, simulate_together

if TYPE_CHECKING:
    from workbench.diagnose.simulation.shooting import Shooting

SHOWN = 64
"""Simulations of which it is remembered what they are off by."""


@dataclass(frozen=True, eq=False)
class Asked:
    """A simulation along a record that is asked for: the same as another one if it would show the same."""

    how: "Shooting"
    motion: Motion
    values: Values
    moved: np.ndarray | None = None

    @cached_property
    def _key(self) -> tuple[object, ...]:
        how, record = self.how, self.motion.record
        arrays = (how.begins.get(record), self.moved)
        begun = tuple(b"" if array is None or not np.any(array) else array.tobytes() for array in arrays)
        ways = how.setups[record], self.motion, how.push
        return (*map(id, ways), how.length, how.most, *begun, *self.values.items())

    def __hash__(self) -> int:
        return hash(self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Asked) and self._key == other._key

    @property
    def kin(self) -> tuple[object, ...]:
        """What it shares with those that may go beside it."""
        return (*map(id, (self.how.setups[self.motion.record], self.motion)), self.how.length, self.how.most)


class _Memory:
    """What the latest simulations were off by: searches ask for the same more than once."""

    def __init__(self) -> None:
        self._errors: OrderedDict[Asked, list[np.ndarray]] = OrderedDict()
        self._lock = Lock()

    def known(self, asked: Iterable[Asked]) -> dict[Asked, list[np.ndarray]]:
        """Those of these that are remembered."""
        with self._lock:
            found = {one: self._errors[one] for one in asked if one in self._errors}
            for one in found:
                self._errors.move_to_end(one)
        return found

    def add(self, errors: dict[Asked, list[np.ndarray]]) -> None:
        """Remember these, in the place of the oldest."""
        with self._lock:
            self._errors |= errors
            while len(self._errors) > SHOWN:
                self._errors.popitem(last=False)


_memory = _Memory()


def errors_of(asked: Sequence[Asked]) -> list[list[np.ndarray]]:
    """What each of these simulations is off by, as `Shooting.errors` has it."""
    found = _memory.known(asked)
    wanted = [one for one in dict.fromkeys(asked) if one not in found]
    chunks = list(_chunks(wanted))
    made = {
        one: errors
        for chunk, several in zip(chunks, side_by_side(_errors, chunks), strict=True)
        for one, errors in zip(chunk, several, strict=True)
    }
    _memory.add(made)
    found |= made
    return [found[one] for one in asked]


def _chunks(wanted: Sequence[Asked]) -> Iterator[list[Asked]]:
    """Simulations that go side by side: as many as are solved at once, and on every thread about as many."""
    groups: dict[tuple[object, ...], list[Asked]] = {}
    for one in wanted:
        groups.setdefault(one.kin, []).append(one)
    for group in groups.values():
        first = group[0]
        most = 1 if len(first.how.starts(first.motion)) >= LANES else LANES
        for size in _sizes(len(group), most):
            yield group[:size]
            group = group[size:]


def _sizes(count: int, most: int) -> list[int]:
    """Of parts of so many, `most` at most: whole ones for every thread, and about as many of what is left; one or two
    go alone, since those that are solved at once take as long whether there are two or four.
    """
    whole = count // (THREADS * most) * THREADS
    left = count - whole * most
    parts = min(THREADS, left)
    return [most] * whole + [left // parts + (i < left % parts) for i in range(parts)]


def _errors(chunk: Sequence[Asked]) -> list[list[np.ndarray]]:
    """Those of simulations along one record."""
    how, motion = chunk[0].how, chunk[0].motion
    plant = how.having(motion, frozenset[str]().union(*(how.along.acts(one.values) for one in chunk)))
    pieces = [list(one.how.pieces(motion, one.values, plant, one.moved)) for one in chunk]
    runs = iter(simulate_together([setup for own in pieces for _, setup in own]))
    return [one.how.off_by(motion, [(k, next(runs)) for k, _ in own]) for one, own in zip(chunk, pieces, strict=True)]
