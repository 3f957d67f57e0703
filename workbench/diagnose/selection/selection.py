"""What became of effects that competed for a residual, round by round."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from plants.effects.registry import effects
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.fit import Fit

Effects = Mapping[str, tuple[str, ...]]
"""Effects by name, with their parameters."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """An effect in a round: its numbers that would be free, what it gains in the logarithm of the likelihood, what is
    asked of it, and its fit, if it was fitted: else its gain is that of first order.
    """

    effect: str
    variant: tuple[str, ...]
    gain: float
    asked: float
    fit: Fit | None = None

    @property
    def deviations(self) -> float:
        """By how many standard deviations of the noise it stands out: what one number would that gains as much."""
        return stands_out(self.gain)

    @property
    def asked_deviations(self) -> float:
        """The same of what is asked."""
        return stands_out(self.asked)


def stands_out(gain: float) -> float:
    """Standard deviations of noise by which a single number stands out that gains so much in log-likelihood."""
    return float(np.sqrt(2.0 * max(gain, 0.0)))


@dataclass(frozen=True, eq=False)
class Step:
    """One round: where it began, all candidates from the best, the effects that were added and dropped, and those that
    would have done as well as one that was added.
    """

    before: Fit
    candidates: Sequence[Candidate]
    added: tuple[str, ...] = ()
    dropped: tuple[str, ...] = ()
    alternatives: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class BalanceResult:
    """A balance before and after selection: with every round of it, its effects, what each gains in the logarithm of
    the likelihood, for each those that do as well in its place, and `otherwise` other numbers of it that do.
    """

    balance: Balance
    before: Fit
    after: Fit
    steps: Sequence[Step]
    effects: Effects
    gains: Mapping[str, float]
    alternatives: Mapping[str, Sequence[str]]
    otherwise: Mapping[str, Sequence[tuple[str, ...]]] = field(default_factory=dict)

    def withdrawn(self) -> "BalanceResult":
        """The same with nothing added."""
        steps = [Step(self.before, self.steps[0].candidates)]
        return BalanceResult(self.balance, self.before, self.before, steps, {}, {}, {})


def is_circular(effect: str, balance: Balance) -> bool:
    """Whether an effect is made of what it is to explain: of the pressures, where they are what drives the mass."""
    return effects()[effect].circular and not balance.motions[0].has("force")
