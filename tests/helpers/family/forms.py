"""What a strength from 0 to 1 of an effect means on a machine, and in which forms it comes.

A strength of 1 is as much as anybody would believe. An effect of several parameters has a column for each; the seed
draws which of them act, and with what sign.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from .machines import Rig

Draw = np.random.Generator
Column = Callable[[float], dict[str, float]]
"""strength -> parameters of the machine that differ."""

Drawing = Callable[[Rig, Draw], "Form"]


@dataclass(frozen=True)
class Form:
    """What an effect may be on a rig: a column each parameter, and which of them act, each with its weight."""

    columns: Mapping[str, Column]
    weights: Mapping[str, float]

    def changes(self, strength: float) -> dict[str, float]:
        """What differs in the machine."""
        changed: dict[str, float] = {}
        for name, weight in self.weights.items():
            changed |= self.columns[name](weight * strength)
        return changed


def single(column: Column, weight: float = 1.0) -> Form:
    """An effect of one parameter."""
    return Form({"": column}, {"": weight})


def sign(draw: Draw) -> float:
    """-1 or 1."""
    return float(draw.choice([-1.0, 1.0]))
