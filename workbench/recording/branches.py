"""Where what was recorded branches: what is dear, and wanted on one side of a `where` alone, is computed there only.

An equation computes both sides of a `select`. What is needed for one side and nothing else may as well wait until the
condition is known, which saves its cost where the other side is taken; the result is the same.
"""

from collections import defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from workbench.recording.operations import CONDITIONS
from workbench.recording.symbols import INPUT, NUMBER, Instruction

WORTH = 12
"""Cost of a side, in additions, from which on a branch pays: that of a wrongly foreseen one, and a call's."""

COSTS = defaultdict(
    lambda: WORTH,
    {
        INPUT: 0,
        NUMBER: 0,
        "negative": 0,
        "absolute": 0,
        "copysign": 1,
        "divide": 4,
        "sqrt": 5,
        "minimum": 2,
        "maximum": 2,
    }
    | dict.fromkeys(("add", "subtract", "multiply", "where", "floor", "ceil", "rint", "trunc", *CONDITIONS), 1)
    | {"sign": 2},
)
"""Of an operation, in additions; a function of the mathematics library costs a branch."""

Side: TypeAlias = tuple[int, int]
"""Where a `where` is recorded, and which of its operands: 1 where the condition holds, else 2."""

WHOLE: Side = (-1, 0)
"""What is computed whatever holds."""


@dataclass
class Branches:
    """In which side each place is computed, and the places of each side in their order."""

    side: dict[int, Side]
    within: Mapping[Side, Sequence[int]] = field(init=False)

    def __post_init__(self) -> None:
        within = defaultdict(list)
        for place, side in sorted(self.side.items()):
            within[side].append(place)
        self.within = within

    def branches(self, place: int) -> bool:
        """Whether a `where` is a branch: something waits on one of its sides."""
        return bool(self.within[place, 1] or self.within[place, 2])


def branches_of(instructions: Sequence[Instruction], places: Sequence[int], results: Collection[int]) -> Branches:
    """Where each of these places, which are all that the `results` need, is computed."""
    side = _sides(instructions, places, results, split=lambda place: instructions[place].operation == "where")
    cost: defaultdict[Side, int] = defaultdict(int)
    for place in places:
        cost[side[place]] += COSTS[instructions[place].operation]
    inner: defaultdict[int, int] = defaultdict(int)
    for place in places:  # what lies on a side within a side counts for the outer one as well
        if instructions[place].operation == "where":
            inner[place] = sum(cost[place, k] for k in (1, 2))
            cost[side[place]] += inner[place]
    worth = {place for place in inner if max(cost[place, 1], cost[place, 2]) >= WORTH}
    return Branches(_sides(instructions, places, results, split=worth.__contains__))


def _sides(
    instructions: Sequence[Instruction], places: Sequence[int], results: Collection[int], split: Callable[[int], bool]
) -> dict[int, Side]:
    """The innermost side, of the `where`s that are `split`, that holds all that wants a place."""
    wanted, side = dict.fromkeys(results, WHOLE), dict[int, Side]()
    for place in reversed(places):
        side[place] = wanted[place]
        for number, operand in enumerate(instructions[place].operands):
            wants = (place, number) if number and split(place) else side[place]
            wanted[operand] = _common(side, wanted[operand], wants) if operand in wanted else wants
    return side


def _common(side: Mapping[int, Side], one: Side, other: Side) -> Side:
    """The innermost side that holds both: a `where` is recorded behind all that lies on its sides."""
    while one != other:
        if WHOLE in (one, other):
            return WHOLE
        if one[0] > other[0]:
            one, other = other, one
        one = side[one[0]]
    return one
