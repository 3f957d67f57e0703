"""Whether two results agree: which verdicts are others, and which of these turn around."""

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.compare.candidates import Cell
from workbench.compare.overview import cell_name
from workbench.compare.verdicts import Kind, Verdict

AGAINST: frozenset[frozenset[Kind]] = frozenset({frozenset({"compensate", "avoid"})})
"""Verdicts that say the opposite of each other."""


@dataclass(frozen=True)
class Agreement:
    """The cells of two comparisons: how many both have, of how many; whose verdict moved, whose turned around."""

    cells: int
    all_cells: int
    moved: dict[Cell, tuple[Kind, Kind]]

    @property
    def turned(self) -> dict[Cell, tuple[Kind, Kind]]:
        """The cells in which one says compensate and the other avoid."""
        return {cell: pair for cell, pair in self.moved.items() if frozenset(pair) in AGAINST}

    @property
    def words(self) -> list[str]:
        """The counts, then a line for each verdict that moved."""
        shared = "" if self.cells == self.all_cells else f" ({self.all_cells - self.cells} are in one of the two alone)"
        first = (
            f"{len(self.turned)} of {self.cells} verdicts{shared} turn around, "
            f"{len(self.moved) - len(self.turned)} move between neighbours."
        )
        return [first, *(f"{cell_name(cell, True)}: {one}, {other}" for cell, (one, other) in self.moved.items())]


def agreement(one: Mapping[Cell, Verdict], other: Mapping[Cell, Verdict]) -> Agreement:
    """How the verdicts of two comparisons agree in the cells that both have."""
    common = [cell for cell in one if cell in other]
    moved = {cell: (one[cell].kind, other[cell].kind) for cell in common if one[cell].kind != other[cell].kind}
    return Agreement(len(common), len(set(one) | set(other)), moved)
