"""Whether two results agree: which verdicts are others, and which of these turn around."""

from collections.abc import Mapping

from workbench.compare.candidates import Cell
from workbench.compare.result import Agreement, Verdict


def agreement(first: Mapping[Cell, Verdict], second: Mapping[Cell, Verdict]) -> Agreement:
    """How the verdicts of two comparisons agree in the cells that both have, in the order of the first."""
    common = [cell for cell in first if cell in second]
    moved = {cell: (first[cell].kind, second[cell].kind) for cell in common if first[cell].kind != second[cell].kind}
    return Agreement(len(common), len(set(first) | set(second)), moved)


def agreement_words(held: Agreement) -> list[str]:
    """The counts, then a line for each verdict that moved."""
    alone = held.all_cells - held.cells
    shared = f" ({alone} are in one of the two alone)" if alone else ""
    turned = len(held.turned)
    counts = (
        f"{turned} of {held.cells} verdicts{shared} turn around, {len(held.moved) - turned} move between neighbours."
    )
    return [counts, *(f"{cell.whole_words}: {first}, {second}" for cell, (first, second) in held.moved.items())]
