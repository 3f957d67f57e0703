"""The cases of a study, of which there may be more than memory holds: each is made when it is looked at."""

import functools
import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, overload

import numpy as np

from workbench.errors import UserError
from workbench.study.at_point import Gains, at_point
from workbench.study.layers import MACHINE
from workbench.study.names import comparable
from workbench.study.overrides import Overrides
from workbench.study.study import CASE, DRAW, NAMED_AXES, Case, Study
from workbench.study.uncertainty import Draws
from workbench.toml.gain_file import KEY, gain_path

NAMES = (*NAMED_AXES, CASE)
"""What chooses a whole table; other axes are numbers and settings, of which there may be very many."""


@dataclass(frozen=True)
class Block:
    """One of [cases], or all there is without: its tables, and its axes, each with its values."""

    name: str | None
    tables: Mapping[str, Any]
    axes: Mapping[str, Sequence[Any]]

    @property
    def size(self) -> int:
        """How many cases it is."""
        return math.prod(map(len, self.axes.values()))

    def point(self, place: int) -> dict[str, Any]:
        """The values of the axes at a place; the last one changes fastest."""
        values: dict[str, Any] = {}
        for axis in reversed([*self.axes]):
            place, i = divmod(place, len(self.axes[axis]))
            values[axis] = self.axes[axis][i]
        return {axis: values[axis] for axis in self.axes}


class Cases(Sequence[Case]):
    """All cases of a study, each made when it is asked for: there may be more than memory holds.

    [cases] come first, then the axes as they stand, the last one changing fastest, then the draws.
    """

    def __init__(
        self,
        study: Study,
        blocks: Sequence[Block],
        places: np.ndarray | None = None,
        draws: Draws | None = None,
    ) -> None:
        self._study, self._blocks, self._places, self.draws = study, blocks, places, draws
        self._ends = list(itertools.accumulate(block.size for block in blocks))
        self._gains = Gains()

    def __len__(self) -> int:
        return self.bases * self.repeats

    @property
    def bases(self) -> int:
        """How many cases there are beside their draws."""
        return self._ends[-1] if self._places is None else len(self._places)

    @property
    def repeats(self) -> int:
        """How often each of them is run: on so many machines."""
        return 1 if self.draws is None else len(self.draws.numbers)

    @overload
    def __getitem__(self, index: int) -> Case: ...
    @overload
    def __getitem__(self, index: slice) -> list[Case]: ...
    def __getitem__(self, index: int | slice) -> Case | list[Case]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        index = range(len(self))[index]
        base, turn = divmod(index, self.repeats)
        block, point = self._at(base)
        tables, declared = at_point(self._study, block.name, block.tables, point, self._gains)
        return self.drawn(Case(base, block.name, point, tables, declared, self._study.path.parent), turn)

    def drawn(self, case: Case, turn: int = 0) -> Case:
        """A case that is not drawn yet on one of the machines."""
        if self.draws is None:
            return case
        number = self.draws.numbers[turn]
        return replace(
            case,
            index=case.index * self.repeats + turn,
            axes={**case.axes, DRAW: number},
            overrides=Overrides(sample=self.draws.sample(number)),
            tells_solver_error=turn == 0,
        )

    def __reduce__(self) -> tuple[object, ...]:
        return Cases, (self._study, self._blocks, self._places, self.draws)

    def __iter__(self) -> Iterator[Case]:
        return (self[i] for i in range(len(self)))

    def _at(self, base: int) -> tuple[Block, dict[str, Any]]:
        """The block that holds a case, and the values of its axes."""
        place = base if self._places is None else int(self._places[base])
        number = next(i for i, end in enumerate(self._ends) if place < end)
        block = self._blocks[number]
        return block, block.point(place - (self._ends[number] - block.size))

    def columns(self, index: int) -> dict[str, object]:
        """What tells a case from the others, without making it."""
        base, turn = divmod(index, self.repeats)
        block, point = self._at(base)
        named = {CASE: block.name} if block.name is not None else {}
        drawn = {DRAW: self.draws.numbers[turn]} if self.draws is not None else {}
        return {**named, **point, **drawn}

    def columns_of(self, indices: np.ndarray) -> dict[str, list[object]]:
        """What tells these cases apart, by column a value for each, None where a case has none."""
        bases, turns = np.divmod(indices, self.repeats)
        places = bases if self._places is None else self._places[bases]
        owners = np.searchsorted(self._ends, places, side="right")
        found: dict[str, np.ndarray] = {axis: np.full(len(indices), None, dtype=object) for axis in self.axes}
        for number, block in enumerate(self._blocks):
            own = np.flatnonzero(owners == number)
            if block.name is not None:
                found[CASE][own] = block.name
            left = places[own] - (self._ends[number] - block.size)
            for axis, values in reversed([*block.axes.items()]):
                left, at = np.divmod(left, len(values))
                found[axis][own] = _objects(values)[at]
        if self.draws is not None:
            found[DRAW] = _objects(self.draws.numbers)[turns]
        return {axis: values.tolist() for axis, values in found.items()}

    @functools.cached_property
    def axes(self) -> dict[str, list[object]]:
        """The columns that tell the cases apart, each with its values, as they first occur."""
        found: dict[str, list[Sequence[object]]] = {}
        for block in self._blocks:
            named = {CASE: [block.name]} if block.name is not None else {}
            drawn = {DRAW: self.draws.numbers} if self.draws is not None else {}
            for axis, values in {**named, **block.axes, **drawn}.items():
                found.setdefault(axis, []).append(values)
        return {axis: _distinct(values) for axis, values in found.items()}

    def gain_files(self) -> list[Path]:
        """The gain files that controllers of any case may take, those by machine for each machine."""
        found = dict[Path, None]()
        for block in self._blocks:
            named = [
                table for table in block.tables["controllers"].values() if isinstance(table, dict) and KEY in table
            ]
            for table, machine in itertools.product(named, block.axes.get(MACHINE.axis, [None])):
                with suppress(UserError):  # of a controller that no case has
                    found[gain_path(table, self._study.path.parent, machine)] = None
        return [*found]

    def where(self, wanted: Mapping[str, object]) -> np.ndarray:
        """Places of the cases that have these values in their columns, as `matches` compares them."""
        of_bases = wanted if self.draws is None else {key: value for key, value in wanted.items() if key != DRAW}
        chosen = np.concatenate([_matching(block, of_bases) for block in self._blocks])
        if self._places is not None:
            chosen = chosen[self._places]
        if self.draws is not None:
            chosen = np.logical_and.outer(chosen, _equal(self.draws.numbers, wanted, DRAW)).ravel()
        return np.flatnonzero(chosen)

    def among(self, places: np.ndarray) -> "Cases":
        """Those cases alone, of a study that draws none yet."""
        return Cases(self._study, self._blocks, places, self.draws)

    def on(self, draws: Draws | None) -> "Cases":
        """Each case on each of these machines."""
        return Cases(self._study, self._blocks, self._places, draws)

    def telling(self, most: int) -> list[int]:
        """Places of cases that stand for all: at most so many of those on the first machine each.

        All, where they are no more. Else each value of each axis, then every combination of names with each value of
        each other axis, as far as there is room; the rest are drawn by lot, the same each time.
        """
        if self.bases <= most:
            return [base * self.repeats for base in range(self.bases)]
        found = dict[int, None]()
        if self._places is None:
            for crossing in (self._lines, self._crossing):
                ends = zip(self._blocks, self._ends, strict=True)
                bases = np.concatenate([crossing(block, end) for block, end in ends]).tolist()
                if len({*found, *bases}) <= most:
                    found.update(dict.fromkeys(bases))
        lot = (base for base in np.random.default_rng(0).permutation(self.bases).tolist() if base not in found)
        found.update(dict.fromkeys(itertools.islice(lot, most - len(found))))
        return sorted(base * self.repeats for base in found)

    @staticmethod
    def _lines(block: Block, end: int) -> np.ndarray:
        """Bases of a block, which ends before `end`, where all axes but one have their first value."""
        grid = _grid(block, end)
        firsts = (0,) * grid.ndim
        lines = [np.moveaxis(grid, axis, -1)[firsts[1:]] for axis in range(grid.ndim)]
        return np.unique(np.concatenate([np.ravel(grid)[:1], *lines]))

    @staticmethod
    def _crossing(block: Block, end: int) -> np.ndarray:
        """Bases of a block, which ends before `end`, where names meet and at most one number is not the first."""
        grid = _grid(block, end)
        shape = grid.shape
        numbers = [i for i, axis in enumerate(block.axes) if axis not in NAMES]
        firsts = tuple(0 if i in numbers else slice(None) for i in range(len(shape)))
        lines = [tuple(slice(None) if i == line else firsts[i] for i in range(len(shape))) for line in numbers]
        return np.unique(np.concatenate([np.ravel(grid[at]) for at in (firsts, *lines)]))


def _objects(values: Sequence[object]) -> np.ndarray:
    """Values as they are, lists among them."""
    return np.fromiter(values, dtype=object, count=len(values))


def _distinct(lists: Sequence[Sequence[object]]) -> list[object]:
    """The values of several lists, each of which holds none twice, as they first occur."""
    if len(lists) == 1:
        return list(lists[0])
    return list({json.dumps(value): value for values in lists for value in values}.values())


def _grid(block: Block, end: int) -> np.ndarray:
    """The bases of a block, which ends before `end`, an axis each."""
    return np.arange(end - block.size, end).reshape(tuple(map(len, block.axes.values())))


def _matching(block: Block, wanted: Mapping[str, object]) -> np.ndarray:
    """Whether each case of a block has the wanted values."""
    own = {CASE, *block.axes}
    whole = all(comparable(None) == comparable(value) for key, value in wanted.items() if key not in own)
    masks = [_equal([block.name], wanted, CASE) & whole]
    masks += [_equal(values, wanted, axis) for axis, values in block.axes.items()]
    return functools.reduce(np.logical_and.outer, masks).ravel()


def _equal(values: Sequence[object], wanted: Mapping[str, object], key: str) -> np.ndarray:
    """Which of the values of a column are the wanted one: all, where none is asked for."""
    if key not in wanted:
        return np.ones(len(values), dtype=bool)
    one = comparable(wanted[key])
    return np.array([comparable(value) == one for value in values])
