"""Hypotheses of a plant: the values of its parameters, which of them are still open, and how well these are known."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plants.axis import AXES
from plants.effects.registry import effects
from workbench.diagnose.residuals.unknowns import Unknown, Values
from workbench.fitting.covariance import inverse
from workbench.publish.words import listed, plain_name

LONGEST_STEP, SHORTEST_STEP = 1e-2, 1e-6
"""Of an unknown as a search sees it, by which a difference quotient moves it; between them half its deviation."""

KNOWN_START = 1e-8
"""Precision of the states at a start, in units of a little change of each: next to nothing."""

NOTHING = "nothing missing"
"""What a plant without effects is called."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A plant with some `effects`: its `values` (SI), the `unknowns` that a fit to further records moves, and the
    `precision` with which they are known by now, shape (unknowns, unknowns), as a search sees them. `others` are the
    same effects in other shapes that are as likely by now, such as with another period.
    """

    effects: tuple[str, ...]
    values: Values
    unknowns: Sequence[Unknown]
    precision: np.ndarray
    others: tuple["Hypothesis", ...] = ()

    @property
    def name(self) -> str:
        """Its effects, in words."""
        return listed([plain_name(effect) for effect in self.effects]) if self.effects else NOTHING

    @cached_property
    def own(self) -> np.ndarray:
        """Which of its unknowns are the plant's own, and no effect's, by number."""
        named = {name for axis in AXES for effect in self.effects for name in effects(axis)[effect].numbers}
        return np.array([k for k, unknown in enumerate(self.unknowns) if unknown.name not in named], dtype=int)

    @cached_property
    def places(self) -> np.ndarray:
        """Where its unknowns are, as a search sees them."""
        return np.array([u.place(self.values[u.name]) for u in self.unknowns])

    @cached_property
    def room(self) -> tuple[np.ndarray, np.ndarray]:
        """How far its unknowns may move down and up, as a search sees them."""
        low, high = np.array([u.low for u in self.unknowns]), np.array([u.high for u in self.unknowns])
        return np.minimum(low - self.places, 0.0), np.maximum(high - self.places, 0.0)

    @cached_property
    def covariance(self) -> np.ndarray:
        """Of its unknowns, as a search sees them."""
        return inverse(self.precision)

    def precision_with(self, starts: int) -> np.ndarray:
        """The precision of its unknowns, and behind them of so many states in which a record may start."""
        count = len(self.unknowns)
        whole = np.diag(np.full(count + starts, KNOWN_START))
        whole[:count, :count] = self.precision
        return whole

    @cached_property
    def steps(self) -> np.ndarray:
        """By how much a difference quotient moves each unknown, to where there is room."""
        sizes = np.clip(0.5 * np.sqrt(np.maximum(np.diag(self.covariance), 0.0)), SHORTEST_STEP, LONGEST_STEP)
        return np.where(sizes <= self.room[1], sizes, -sizes)

    def moved(self, by: np.ndarray) -> dict[str, float]:
        """The values with the unknowns moved, within their room."""
        places = self.places + np.clip(by, *self.room)
        return {**self.values, **{u.name: u.value(float(x)) for u, x in zip(self.unknowns, places, strict=True)}}

    def is_part_of(self, other: "Hypothesis") -> bool:
        """Whether another one can do all that it does: a plant without an effect, which the other has beside."""
        return set(self.effects) < set(other.effects)


def truths_of(hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """What may be true: the hypotheses, and behind them all of their other shapes."""
    return [*hypotheses, *(other for one in hypotheses for other in one.others)]
