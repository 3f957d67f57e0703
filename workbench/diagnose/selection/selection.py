"""Which effects a balance's residual supports: candidates compete on blocks that their fits did not see."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plants.effects import EFFECTS
from workbench.diagnose.residuals.fitting import Balance, Fit, fit, promise
from workbench.diagnose.residuals.unknowns import Values

LEAST_GAIN = 0.04
"""Share of the left-out rms that an effect must take away."""

CIRCULAR_GAIN = 0.15
"""The same of an effect that is made of what it is to explain."""

SURE = 2.5
"""Standard errors, over blocks, by which the left-out squares must fall."""

LEVEL = 2.0
"""Standard errors, over blocks, within which two candidates cannot be told apart."""

NEAR = 1.1
"""Ratio of the left-out rms to the best beyond which a candidate is no alternative, however blocks scatter."""

PRICE = 0.01
"""Share of the left-out rms that every further parameter has to take away."""

AT_FLOOR = 1.05
"""Floors at which a residual is what it would be if nothing were missing."""

FEWEST = 3
"""Blocks in which something moves, below which nothing is sure."""

VARIANTS = 2
"""Sets of an effect's parameters that are fitted whole."""

MOST = 4
"""Effects that are added to one balance."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """An effect, with the parameters of it that are free, fitted jointly with the baseline."""

    effect: str
    variant: tuple[str, ...]
    fit: Fit

    @property
    def score(self) -> float:
        """Left-out rms in floors, with the price of its parameters: lower is better."""
        return self.fit.validated_rms * (1.0 + PRICE * len(self.variant))


@dataclass(frozen=True, eq=False)
class Step:
    """One round: where it began, all candidates from the best, the one that was added (None: none passed), and those
    that the data cannot tell apart from it."""

    before: Fit
    candidates: Sequence[Candidate]
    added: Candidate | None
    alternatives: Sequence[str]


@dataclass(frozen=True, eq=False)
class BalanceResult:
    """A balance before and after selection, with every round of it."""

    balance: Balance
    before: Fit
    after: Fit
    steps: Sequence[Step]


def _sure(before: Fit, after: Fit) -> float:
    """Standard errors, over blocks, by which the logarithm of the left-out squares falls: a block counts as one, loud
    or quiet."""
    loud = (before.block_squares > 0.0) & (after.block_squares > 0.0)  # a machine at rest leaves none
    if np.sum(loud) < FEWEST:
        return 0.0
    ratio = np.log(before.block_squares[loud] / after.block_squares[loud])
    return float(np.mean(ratio)) / max(float(np.std(ratio, ddof=1)) / np.sqrt(ratio.size), 1e-12)


def gain(before: Fit, after: Fit) -> tuple[float, float]:
    """Share by which the left-out rms falls, and how sure that is, in standard errors over blocks."""
    return 1.0 - after.validated_rms / before.validated_rms, _sure(before, after)


def candidates_for(
    balance: Balance, before: Fit, names: Sequence[str], taken: Sequence[str], bounds: Mapping[str, tuple[float, float]]
) -> list[Candidate]:
    """Every effect of the balance that is not there yet, or not with all its parameters, its best variant, from the
    best.

    One step of a fit says what each variant of an effect promises; the two that promise most are fitted whole.
    """
    promises: dict[str, dict[tuple[str, ...], float]] = {}
    for name in balance.effects:
        more = [one for one in EFFECTS[name].variants if name not in taken or extends(one, names)]
        if more:
            promises[name] = {variant: promise(before, variant, bounds) for variant in more}
    found = []
    for name in promises:
        ranked = sorted(promises[name], key=lambda variant: promises[name][variant] * (1.0 + PRICE * len(variant)))
        tried = []
        for variant in ranked[:VARIANTS]:
            free = [*names, *(one for one in variant if one not in names)]
            tried.append(Candidate(name, variant, fit(balance, before.values, free, bounds)))
        found.append(min(tried, key=lambda one: one.score))
    return sorted(found, key=lambda one: one.score)


def extends(variant: Sequence[str], names: Sequence[str]) -> bool:
    """Whether a variant has all of its effect's parameters that are free already, and more."""
    own = next(set(effect.numbers) for effect in EFFECTS.values() if set(variant) <= set(effect.numbers))
    return own & set(names) < set(variant)


def select(balance: Balance, values: Values, bounds: Mapping[str, tuple[float, float]]) -> tuple[Fit, list[Step]]:
    """Add effects to a balance one by one, each fitted jointly with all before it, until none passes."""
    names, taken = list(balance.free), list[str]()
    current = fit(balance, values, names, bounds)
    steps: list[Step] = []
    while len(taken) < MOST and (current.rms > AT_FLOOR or not steps):
        found = candidates_for(balance, current, names, taken, bounds)
        passing = [one for one in found if _passes(current, one)] if current.rms > AT_FLOOR else []
        added = passing[0] if passing else None
        rivals = [one.effect for one in passing[1:] if added is not None and is_level(added, one)]
        steps.append(Step(current, found, added, rivals))
        if added is None:
            break
        taken += [added.effect] if added.effect not in taken else []
        names += [one for one in added.variant if one not in names]
        current = added.fit
    return current, steps


def is_circular(effect: str, balance: Balance) -> bool:
    """Whether an effect is made of what it is to explain: of the pressures, where they are what drives the mass."""
    return EFFECTS[effect].circular and not balance.motions[0].has("force")


def least_gain(effect: str, count: int, balance: Balance) -> float:
    """Share of the left-out rms that an effect with so many parameters has to take away."""
    return (CIRCULAR_GAIN if is_circular(effect, balance) else LEAST_GAIN) + PRICE * count


def _passes(before: Fit, one: Candidate) -> bool:
    share, sure = gain(before, one.fit)
    if one.fit.bounded - set(before.balance.free):  # an effect's number that is no estimate
        return False
    return share > least_gain(one.effect, len(one.variant), before.balance) and sure > SURE


def is_level(best: Candidate, other: Candidate) -> bool:
    """Whether the left-out squares of two candidates differ by less than their scatter over blocks."""
    return _sure(other.fit, best.fit) < LEVEL and other.fit.validated_rms < NEAR * best.fit.validated_rms
