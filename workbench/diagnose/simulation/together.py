"""Simulations that are asked for together go side by side: columns of a Jacobian, starts that are moved, candidates.

Several of one record share its plant and its input, and are solved at once (`simulate_together`) by a plant that has
what acts in any of them: an effect leaves the bits as they are of one in which it does nothing. To compile such a plant
costs as much as some simulations; where it does not pay, each goes by itself, by the plant with all its effects, which
is there already, and of which what does nothing is skipped.
"""

from collections import Counter, OrderedDict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np

from plants.equation import from_array
from plants.interface import Plant
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.fitting.threads import parts_of, side_by_side
from workbench.records.reading import Record
from workbench.simulation.run import Run
from workbench.simulation.simulate import LANES, simulate, simulate_together

if TYPE_CHECKING:
    from workbench.diagnose.simulation.shooting import Shooting

SHOWN = 64
"""Simulations of which it is remembered what they are off by."""

WORTH = 200_000
"""Steps of simulations with some effects from which on it pays to compile a plant that has these alone."""


@dataclass(frozen=True, eq=False)
class Push:
    """What is added along records (N, or V of a valve's command), at every sample."""

    on_command: bool
    series: Mapping[Record, np.ndarray]


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

    @cached_property
    def moving(self) -> "Asked":
        """The simulation of the same motion, of which sensors show what is there; itself where a loop sees them."""
        values = {name: value for name, value in self.values.items() if name not in self.how.along.shown_alone}
        return self if self.how.is_led(self.motion) else replace(self, values=values)

    @property
    def kin(self) -> tuple[object, ...]:
        """What it shares with those that may go beside it."""
        return (*map(id, (self.how.setups[self.motion.record], self.motion)), self.how.length, self.how.most)


class _Memory:
    """What the latest simulations were off by: searches ask for the same more than once, but for those with a push,
    each of which is made for one look.
    """

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
            self._errors |= {one: own for one, own in errors.items() if one.how.push is None}
            while len(self._errors) > SHOWN:
                self._errors.popitem(last=False)


_memory = _Memory()


def errors_of(asked: Sequence[Asked]) -> list[list[np.ndarray]]:
    """What each of these simulations is off by, as `Shooting.errors` has it."""
    found = _memory.known(asked)
    shown: dict[Asked, list[Asked]] = {}
    for one in dict.fromkeys(asked):
        if one not in found:
            shown.setdefault(one.moving, []).append(one)
    made: dict[Asked, list[np.ndarray]] = {}
    for errors in side_by_side(lambda chunk: chunk.errors(shown), list(_chunks([*shown]))):
        made |= errors
    _memory.add(made)
    found |= made
    return [found[one] for one in asked]


@dataclass(frozen=True, eq=False)
class _Chunk:
    """Simulations along one record that are made in one go, by a plant that has what is `acting`, and that alone where
    it is compiled for them.
    """

    asked: Sequence[Asked]
    acting: frozenset[str]
    alone: bool

    def errors(self, shown: Mapping[Asked, Sequence[Asked]]) -> dict[Asked, list[np.ndarray]]:
        """What each is off by, and the others that are `shown` by sensors of the same motion."""
        how, motion = self.asked[0].how, self.asked[0].motion
        plant = how.along.having(self.acting, alone=self.alone)
        pieces = [list(one.how.pieces(motion, one.values, plant, one.moved)) for one in self.asked]
        setups = [setup for own in pieces for _, setup in own]
        made = simulate_together(setups) if self.alone else list(map(simulate, setups))
        _spent.add(self, sum(run.steps for run in made))
        runs, errors = iter(made), dict[Asked, list[np.ndarray]]()
        for one, own in zip(self.asked, pieces, strict=True):
            found = [(k, next(runs)) for k, _ in own]
            for other in shown[one]:
                seen = found if other.values == one.values else [(k, self._read(run, other)) for k, run in found]
                errors[other] = how.off_by(motion, seen)
        return errors

    def _read(self, run: Run, one: Asked) -> Run:
        """A run as sensors with errors of their own show it."""
        along = one.how.along
        plant = along.plant if run.plant is along.plant else along.having(self.acting | along.acts(one.values), True)
        state, parameters = from_array(plant.State, run.states.T), along.parameters_of(plant, one.values)
        return replace(
            run, measurements=np.column_stack(np.broadcast_arrays(run.time, *plant.measure(state, parameters))[1:])
        )


class _Spent:
    """Integration steps that simulations took: of each record and way to simulate it the last one's, and of each set of
    acting effects all. They decide what is compiled, which no result depends on.
    """

    def __init__(self) -> None:
        self._last: OrderedDict[tuple[object, ...], int] = OrderedDict()
        self._total: Counter[tuple[Plant, frozenset[str]]] = Counter()

    def add(self, chunk: _Chunk, steps: int) -> None:
        """Those of a chunk."""
        first = chunk.asked[0]
        self._last[first.kin] = steps // len(chunk.asked)
        self._total[first.how.along.plant, chunk.acting] += steps
        while len(self._last) > SHOWN:
            self._last.popitem(last=False)

    def expected(self, one: Asked) -> int:
        """Of one more like this: a step a sample, if nothing is known."""
        return self._last.get(one.kin, one.motion.record.time.size)

    def pays(self, one: Asked, acting: frozenset[str], count: int) -> bool:
        """Whether a plant is to be compiled for so many like this one, or is there."""
        steps = self._total[one.how.along.plant, acting] + count * self.expected(one)
        return not acting or steps > WORTH


_spent = _Spent()


def _chunks(wanted: Sequence[Asked]) -> Iterator[_Chunk]:
    """Simulations that go side by side: as many as are solved at once, and on every thread about as many."""
    groups: dict[tuple[object, ...], dict[frozenset[str], list[Asked]]] = {}
    for one in wanted:
        acting = one.how.along.acts(one.values)
        groups.setdefault(one.kin, {}).setdefault(acting, []).append(one)
    for by_acting in groups.values():
        rest = list[tuple[Asked, frozenset[str]]]()
        for acting, own in by_acting.items():
            if not _spent.pays(own[0], acting, len(own)):
                rest += [(one, acting) for one in own]
                continue
            most = 1 if len(own[0].how.starts(own[0].motion)) >= LANES else LANES
            yield from (_Chunk(part, acting, alone=True) for part in parts_of(own, most))
        if rest and LANES * _spent.expected(rest[0][0]) > WORTH:
            for part in parts_of(rest, LANES):
                yield _Chunk([one for one, _ in part], frozenset[str]().union(*(own for _, own in part)), alone=True)
        else:
            yield from (_Chunk([one], acting, alone=False) for one, acting in rest)
