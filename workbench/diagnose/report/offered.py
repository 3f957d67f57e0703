"""A data-driven term as parameters of a curve, which a plant can have: off, until who reads it switches it on."""

from collections.abc import Mapping

import numpy as np

from plants.effects.curves import HIGH, LOW, NODES, SHARE, nodes_of
from plants.interface import Plant
from workbench.diagnose.selection.unexplained import OfferedTerm, Unexplained, curve_over
from workbench.parameters.corrected import Entry


def curve_values(name: str, term: OfferedTerm) -> dict[str, float]:
    """The parameters (SI) of a curve of that name with a term's values: at even distances, on lines between its nodes.

    It is off.
    """
    low, high = float(term.nodes[0]), float(term.nodes[-1])
    values = np.interp(np.linspace(low, high, NODES), term.nodes, term.values)
    return {
        f"{name}_{SHARE}": 0.0,
        f"{name}_{LOW}": low,
        f"{name}_{HIGH}": high,
        **dict(zip(nodes_of(name), values.tolist(), strict=True)),
    }


def offered_entries(
    unexplained: Unexplained | None, plant: Plant, declared: Mapping[str, float], source: str
) -> list[Entry]:
    """What is offered as entries of a parameter file for a plant, and how it is switched on; none where it can have
    none, or is declared with that curve already.
    """
    if unexplained is None or (effect := curve_over(plant, unexplained.balance, unexplained.term.signal)) is None:
        return []
    here = effect.along(plant.axis)
    share, *_ = here.own_names
    if declared.get(share, 0.0):
        return []
    values = dict(zip(here.own_names, curve_values(effect.name, unexplained.term).values(), strict=True))
    switch = (
        f"{source}: {here.words}. It describes the records and names no cause. "
        f"Off; {share} = 1, here or in [plant.set], switches it on"
    )
    return [
        Entry(name, value, None, switch if name == share else f"{source}: see {share}")
        for name, value in values.items()
    ]
