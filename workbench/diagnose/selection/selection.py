"""Which effects a balance's residual supports: candidates compete on blocks that their fits did not see."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plants.axis import AXES
from plants.effects.registry import effects
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.fit import Fit, Search, fit
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.selection.promise import promise

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

BETTER = 0.98
"""Rms over that of a fit below which another start found a better one: that fit had stopped in a hollow."""

ANEW = 3
"""Times at most that a round begins anew from a better start."""

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
        more = [
            variant for variant in effects(balance.axis)[name].variants if name not in taken or extends(variant, names)
        ]
        if more:
            promises[name] = {variant: promise(before, variant, bounds) for variant in more}
    best = []
    for name in promises:
        ranked = sorted(promises[name], key=lambda variant: promises[name][variant] * (1.0 + PRICE * len(variant)))
        tried = []
        for variant in ranked[:VARIANTS]:
            free = [*names, *(number for number in variant if number not in names)]
            tried.append(Candidate(name, variant, fit(balance, before.values, free, bounds)))
        best.append(min(tried, key=_by_score))
    return sorted(best, key=_by_score)


def _by_score(candidate: Candidate) -> float:
    return candidate.score


def extends(variant: Sequence[str], names: Sequence[str]) -> bool:
    """Whether a variant has all of its effect's parameters that are free already, and more."""
    every = [effect for axis in AXES for effect in effects(axis).values()]
    own = next(set(effect.numbers) for effect in every if set(variant) <= set(effect.numbers))
    return own & set(names) < set(variant)


def select(balance: Balance, values: Values, bounds: Mapping[str, tuple[float, float]]) -> tuple[Fit, list[Step]]:
    """Add effects to a balance one by one, each fitted jointly with all before it, until none passes."""
    names, taken = list(balance.free), list[str]()
    current = fit(balance, values, names, bounds)
    steps: list[Step] = []
    anew = 0
    while len(taken) < MOST and (current.rms > AT_FLOOR or not steps):
        candidates = candidates_for(balance, current, names, taken, bounds)
        passing = [rival for rival in candidates if _passes(current, rival)] if current.rms > AT_FLOOR else []
        if passing and anew < ANEW and (better := beside(current, passing[0].fit, bounds, Search())) is not current:
            current, anew = better, anew + 1
            continue
        anew = 0
        steps.append(round_of(current, candidates, passing))
        added = steps[-1].added
        if added is None:
            break
        taken += [added.effect] if added.effect not in taken else []
        names += [name for name in added.variant if name not in names]
        current = added.fit
    return current, steps


def beside(current: Fit, rival: Fit, bounds: Mapping[str, tuple[float, float]], search: Search) -> Fit:
    """A fit again from where a rival with an effect found the parameters of both, if that is better: what the rival
    gains is then no effect's.
    """
    start = {**current.values, **{name: rival.values[name] for name in current.names}}
    again = fit(current.balance, start, current.names, bounds, search)
    return again if again.rms < BETTER * current.rms else current


def round_of(before: Fit, candidates: Sequence[Candidate], passing: Sequence[Candidate]) -> Step:
    """A round: of those that pass, from the best, the first is added, and those level with it are its alternatives."""
    added = passing[0] if passing else None
    rivals = [rival.effect for rival in passing[1:] if added is not None and is_level(added, rival)]
    return Step(before, candidates, added, rivals)


def is_circular(effect: str, balance: Balance) -> bool:
    """Whether an effect is made of what it is to explain: of the pressures, where they are what drives the mass."""
    return effects()[effect].circular and not balance.motions[0].has("force")


def least_gain(effect: str, count: int, balance: Balance) -> float:
    """Share of the left-out rms that an effect with so many parameters has to take away."""
    return (CIRCULAR_GAIN if is_circular(effect, balance) else LEAST_GAIN) + PRICE * count


def _passes(before: Fit, candidate: Candidate) -> bool:
    share, sure = gain(before, candidate.fit)
    if candidate.fit.bounded - set(before.balance.free):  # an effect's number that is no estimate
        return False
    return share > least_gain(candidate.effect, len(candidate.variant), before.balance) and sure > SURE


def is_level(best: Candidate, other: Candidate) -> bool:
    """Whether the left-out squares of two candidates differ by less than their scatter over blocks."""
    return _sure(other.fit, best.fit) < LEVEL and other.fit.validated_rms < NEAR * best.fit.validated_rms
