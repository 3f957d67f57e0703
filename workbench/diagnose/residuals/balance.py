"""A physical balance of some records: what is left of it with values of the parameters, over its noise floor."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from plants.axis import LINEAR
from plants.effects.interface import Scales
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Priors, Values
from workbench.diagnose.residuals.weighing import Changes
from workbench.fitting.threads import side_by_side

BLOCKS = 10
"""Parts, each of one piece, into which the records are cut for cross-validation."""

LEAST_BLOCKS = 4
"""Parts of each record at least: blocks of several records must not be so few that none can be sure."""

RUNS_AWAY = 1e30
"""Floors beyond which a residual is no number: the plant diverges, and squares overflow."""

SIMULATION = "simulation"
"""What the simulation error is called among the balances."""

Residual = Callable[[Motion, Values], Sequence[np.ndarray]]
"""The residuals of a balance at the thinned instants of a motion, one array or more."""

Together = Callable[[Sequence[tuple[Motion, Values]]], Sequence[Sequence[np.ndarray]]]
"""The same of several motions or values at once."""

Near = Callable[[Values, Sequence[tuple[Motion, Values]]], Sequence[Sequence[np.ndarray]]]
"""The same near some values, to first order where that is enough."""

Beside = Callable[[Values], Changes]
"""What no parameter decides: directions (rows of the stack, directions) in which residuals may move, and the groups of
rows that do so on their own."""


def nothing(values: Values) -> Changes:
    """Every residual is decided by parameters."""
    return np.zeros((0, 0)), ()


@dataclass(frozen=True, eq=False)
class Balance:
    """A physical balance of some records: its residual over parameter values, the noise floor of it, and its unit.

    The floor is `simulated` where it is the residual of a plant that lacks nothing, on the motions in `null` if that is
    kept, else the sensors' noise alone. Where several draws of noise made it, `spread` is their standard deviation, as
    a share of it.
    `free` are the declared plant's own parameters that a fit moves before anything is called an effect, on a machine of
    these `scales`; `priors` are what is declared of those among them that are known to a deviation, and would be held
    without it. `parts` is the number of residuals that each motion gives. One with a `contact` in it says nothing where
    that rests, and none does where smoothing blurs what happened: rates are not linear in all signals. `axis` is that
    of the plant, "m" or "rad"; `beside` is what no parameter decides. Residuals that are dear one by one come
    `together` where several are asked for, and many to first order that are `near` to known ones.
    """

    name: str
    motions: Sequence[Motion]
    residual: Residual
    floor: float
    unit: str
    free: tuple[str, ...]
    scales: Scales
    effects: tuple[str, ...] = ()
    parts: int = 1
    contact: bool = False
    simulated: bool = False
    spread: float | None = None
    axis: str = LINEAR
    beside: Beside = nothing
    null: Sequence[Motion] = ()
    together: Together | None = None
    near: Near | None = None
    priors: Priors = field(default_factory=dict)

    def known(self, motion: Motion) -> np.ndarray:
        """At which of a motion's thinned instants the residual says something: a simulation is not smoothed, and says
        something wherever all samples from one instant to the next are known.
        """
        if self.name == SIMULATION:
            return np.logical_and.reduceat(motion.record.valid, motion.instants)
        thin = motion.thinned
        return thin.valid & ~thin.blurred

    def residuals(self, motion: Motion, values: Values) -> list[np.ndarray]:
        """Residuals (in `unit`) of a motion at its thinned instants."""
        return list(self.residual(motion, values))

    def stacked(self, values: Values) -> np.ndarray:
        """Residuals of all records over the floor, 0 where nothing is known, as large as their mean square over what is
        known: of records of which different shares are, the errors can be compared. NaN where a plant runs away.
        """
        return self.stacks([values])[0]

    def stacks(self, several: Sequence[Values]) -> list[np.ndarray]:
        """The same of several values."""
        asked = self._asked(several)
        return self._stacks(side_by_side(self._residuals, asked) if self.together is None else self.together(asked))

    def stacks_near(self, values: Values, several: Sequence[Values]) -> list[np.ndarray]:
        """The same of several that differ little from these values, to first order where that is known."""
        return self.stacks(several) if self.near is None else self._stacks(self.near(values, self._asked(several)))

    def _asked(self, several: Sequence[Values]) -> list[tuple[Motion, Values]]:
        return [(motion, values) for values in several for motion in self.motions]

    def _stacks(self, found: Sequence[Sequence[np.ndarray]]) -> list[np.ndarray]:
        count = len(self.motions)
        return [self.stack(found[at : at + count]) for at in range(0, len(found), count)]

    def stack(self, residuals: Sequence[Sequence[np.ndarray]]) -> np.ndarray:
        """The stack of residuals that are those of all records."""
        known = [self.known(motion) for motion in self.motions]
        share = sum(map(np.sum, known)) / max(sum(map(np.size, known)), 1)
        scale = 1.0 / (self.floor * np.sqrt(share)) if share > 0.0 else 0.0
        with np.errstate(over="ignore", invalid="ignore"):
            parts = [
                np.where(where, scale * part, 0.0) for where, own in zip(known, residuals, strict=True) for part in own
            ]
        stack = np.concatenate(parts)
        return np.where(np.abs(stack) < RUNS_AWAY, stack, np.nan)

    def _residuals(self, asked: tuple[Motion, Values]) -> Sequence[np.ndarray]:
        with np.errstate(over="ignore", invalid="ignore"):
            return self.residual(*asked)

    @cached_property
    def series(self) -> list[list[slice]]:
        """Where the residuals of each record stand in the stack."""
        sizes = [motion.thinned.time.size for motion in self.motions for _ in range(self.parts)]
        ends = np.cumsum(sizes).tolist()
        slices = [slice(end - size, end) for end, size in zip(ends, sizes, strict=True)]
        return [slices[i : i + self.parts] for i in range(0, len(slices), self.parts)]

    @property
    def rows(self) -> int:
        """Of the stack."""
        return self.series[-1][-1].stop

    @cached_property
    def blocks(self) -> list[np.ndarray]:
        """Rows of each block of the stack: pieces of time, with all residuals of a record in them."""
        per_record = max(BLOCKS // len(self.motions), LEAST_BLOCKS)
        return [
            np.concatenate(pieces)
            for slices in self.series
            for pieces in zip(
                *(np.array_split(np.arange(place.start, place.stop), per_record) for place in slices), strict=True
            )
        ]
