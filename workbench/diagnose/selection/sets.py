"""Sets of effects in a search: what is asked of one, how it is fitted, and what it makes of those that are there."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np

from plants.effects.registry import effects as registered
from plants.equation import NEGATIVE
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.fit import FINAL, NEAR_NOISE, Fit, again, fit, stacks, weighing_at
from workbench.diagnose.residuals.unknowns import Bounds, Values, idle
from workbench.diagnose.selection.likelihood import Outlook, Proposal, asked
from workbench.diagnose.selection.selection import Effects
from workbench.diagnose.selection.trials import Shapes, Trial, looks, sizing
from workbench.fitting.covariance import inverse
from workbench.fitting.least_squares import Search
from workbench.parameters.sets import NEUTRAL

QUICK = Search(flat=1e-5, most_steps=15, learns=True)
"""When a fit ends by which sets are ranked."""

AT_FLOOR = 1.0
"""Floors up to which a balance lacks nothing that it could tell from what smoothing leaves."""


FAR = 5.0
"""Floors beyond which a fit is so far from noise that first order is no guide."""

SHARES = (0.3, 0.1, 0.03)
"""Of the way to where first order leads, from one of which a fit begins that is far from noise."""


@dataclass(frozen=True, eq=False)
class Asked:
    """What a search may move: the plant's own parameters, as `declared`, between which bounds; of so many
    candidates; values that shape an effect, where they are known (`shapes`), and the share of a residual's rms that a
    set has to take away, beside what its likelihood has to gain: that many `times` what noise would gain. Where fits
    are to means over samples, one is `shown` all of them as it is, and becomes a fit to `all_samples`.
    """

    declared: Values
    bounds: Bounds
    candidates: int
    shapes: Shapes
    least_share: float = 0.0
    settle: Callable[[Fit], Fit] | None = None
    times: float = 1.0
    shown: Callable[[Fit], Fit] | None = None
    all_samples: Callable[[Fit], Fit] | None = None

    def of(self, effect: str, names: Collection[str], balance: Balance) -> float:
        """Gain that an effect with these numbers has to exceed."""
        return self.times * asked(sizing(balance, effect, names), self.candidates * looks(balance, effect, names))

    def of_trial(self, trial: Trial, balance: Balance) -> float:
        """The same of a trial."""
        return self.of(trial.effect, trial.names, balance)

    def price(self, added: Sequence[Trial], dropped: Sequence[str], taken: Effects, balance: Balance) -> float:
        """Gain that a set has to exceed which has these beside what is `taken`, and does without others."""
        more = sum(self.of_trial(trial, balance) for trial in added)
        return more - sum(self.of(effect, taken[effect], balance) for effect in dropped)

    def price_of(self, proposal: Proposal, taken: Effects, balance: Balance) -> float:
        """The same of a set that is proposed."""
        return self.price(proposal.added, proposal.dropped, taken, balance)

    def is_at_floor(self, fitted: Fit) -> bool:
        """Whether a balance lacks nothing that it could tell from what smoothing leaves."""
        return self.least_share > 0.0 and fitted.rms <= AT_FLOOR

    def settled(self, found: Fit) -> Fit:
        """A fit by the likelihood of the noise that it leaves itself."""
        return again(found, weighing_at(found), self.bounds, FINAL) if self.settle is None else self.settle(found)


def fitted_with(current: Fit, taken: Effects, proposal: Proposal, ask: Asked) -> Fit:
    """The plant with the set that is proposed, fitted from where first order leads, with the other parameters as they
    are or moved along, or far from noise from that part of the way which leaves least.

    Where a long run shows parameters to parts in a million, one that moves alone takes the run astray.
    """
    dropped = {name for effect in proposal.dropped for name in taken[effect]}
    names = [name for name in current.names if name not in dropped]
    names += [name for trial in proposal.added for name in trial.names if name not in names]
    values = declared_again(current.values, dropped, ask.declared)
    reached = {name: proposal.start[name] for name in names if name in proposal.start}
    start = nearest(current, _starts(current, values, reached, proposal))
    return fit(current.balance, start, names, ask.bounds, QUICK, current.weighing)


def _starts(current: Fit, values: Values, reached: Values, proposal: Proposal) -> Sequence[Values]:
    """Where a fit of a set may begin: with its numbers where first order leads (`reached`), and all others as they are
    or there, too; far from noise some shares of the way, since much bends there.
    """
    added = {name: reached[name] for trial in proposal.added for name in trial.names if name in reached}
    starts = [{**values, **added}, *([{**values, **reached}] if added.keys() != reached.keys() else [])]
    if current.excess > NEAR_NOISE:
        first = {name: idle(name, values) for trial in proposal.added for name in trial.sized}
        ways = {name: (at, added[name] - at) for name, at in first.items()}
        shares = SHARES if ways else ()
        starts += [{**starts[0], **{name: at + share * way for name, (at, way) in ways.items()}} for share in shares]
    return starts


def nearest(current: Fit, starts: Sequence[Values]) -> Values:
    """Of places where a fit may begin that which leaves least, in the noise of another."""
    if len(starts) == 1:
        return starts[0]
    weighed = [current.weighing(stack) for stack in stacks(current.balance, starts)]
    return min(zip(starts, weighed, strict=True), key=lambda pair: float(pair[1] @ pair[1]))[0]


def declared_again(values: Values, dropped: Collection[str], declared: Values) -> dict[str, float]:
    """The values with those numbers as they are declared that are `dropped`; without what is not declared."""
    kept = {name: value for name, value in values.items() if name not in dropped}
    return {**kept, **{name: declared[name] for name in dropped if name in declared}}


def without_effects(found: Fit, taken: Effects, ask: Asked) -> Fit:
    """The fit without its effects, by the same noise; itself if it has none."""
    return fitted_without(found, taken, tuple(taken), ask) if taken else found


def fitted_without(current: Fit, taken: Effects, dropped: Collection[str], ask: Asked) -> Fit:
    """The fit without some of its effects, by the same noise."""
    away = {effect: away_of(current, taken[effect], ask) for effect in dropped}
    return fitted_with(current, taken, Outlook(current, {}).proposal((), away, 0.0), ask)


def away_of(current: Fit, own: Collection[str], ask: Asked) -> dict[int, float]:
    """How far the unknowns of an effect are from where it does nothing."""
    known = {**NEUTRAL, **ask.declared}
    away = {}
    for i, searched in enumerate(current.unknowns):
        if searched.name in own:
            plain = searched.name.removesuffix(f"_{NEGATIVE}")
            neutral = (
                current.values[plain]
                if plain != searched.name and plain in current.values
                else known.get(searched.name, 0.0)
            )
            if searched.logarithmic and neutral <= 0.0:
                continue
            away[i] = searched.place(neutral) - current.places[i]
    return away


def certainty_of(found: Fit, effect: str, own: Collection[str], ask: Asked) -> float:
    """By how much an effect is more certain than is asked of it, by the deviations of its own numbers: half the squares
    of how far those that size it are from where it does nothing (Wald 1943), less what noise would make of that in one
    fit of a hundred.

    A likelihood has the noise that it is told; deviations know of the memory, and of the scatter from part to part,
    that it has besides (White 1982). Without bound of an effect whose size can only be told in factors.
    """
    numbers = registered(found.balance.axis)[effect].numbers
    away = {i: far for i, far in away_of(found, own, ask).items() if not numbers[found.unknowns[i].name].shapes}
    if not away:
        return np.inf
    places, far = list(away), np.array(list(away.values()))
    squares = float(far @ inverse(found.covariance[np.ix_(places, places)]) @ far)
    return 0.5 * squares - ask.times * asked(len(places), 1)


def is_estimated(found: Fit, balance: Balance) -> bool:
    """Whether every number of an effect is an estimate, and no end of its range."""
    return not found.bounded - set(balance.free)


def numbers_of(effects: Effects) -> frozenset[str]:
    """The numbers of effects, by which a set is known: an effect with more of its numbers makes another set."""
    return frozenset(name for own in effects.values() for name in own)


def after(taken: Effects, proposal: Proposal) -> dict[str, tuple[str, ...]]:
    """The effects with their numbers once a set is taken."""
    kept = {effect: names for effect, names in taken.items() if effect not in proposal.dropped}
    for trial in proposal.added:
        kept[trial.effect] = tuple(dict.fromkeys([*kept.get(trial.effect, ()), *trial.names]))
    return kept
