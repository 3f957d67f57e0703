"""The search for what a plant lacks: sets of effects compete by the likelihood of what they leave of a balance.

From a fit, what every effect would gain is known to first order, and so is what every set of them would, with any that
are there dropped or exchanged. The sets that promise most are fitted; the best one that gains more than is asked of it
is taken, and the search goes on from there. So one effect that stood in for two others is dropped again.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from plants.effects.registry import effects as registered
from workbench.diagnose.residuals.balance import SIMULATION
from workbench.diagnose.residuals.fit import NEAR_NOISE, Fit, again, fit
from workbench.diagnose.selection.judging import choose
from workbench.diagnose.selection.likelihood import Outlook, Proposal, effects_of, gained, left_by, own_noise
from workbench.diagnose.selection.selection import Candidate, Effects, Step
from workbench.diagnose.selection.sets import (
    FAR,
    QUICK,
    Asked,
    after,
    away_of,
    certainty_of,
    declared_again,
    fitted_with,
    fitted_without,
    is_estimated,
    nearest,
    numbers_of,
)
from workbench.diagnose.selection.trials import Seen, Shape, Shapes, Trial, seen_of, together, trials_of
from workbench.fitting.least_squares import Search
from workbench.fitting.threads import side_by_side

FIRST_STEPS = Search(flat=1e-3, most_steps=8, learns=True)
"""When a fit ends that shows whether an effect leads anywhere."""

NEARLY = 0.3
"""Share of what the best effect gains in a few steps, from which another is fitted on."""

TOGETHER = 3
"""Effects that are added at once, at most."""

MOST = 4
"""Effects that a plant lacks at once, at most: far from its records more and more effects gain something, and each is
fitted beside all others. What four do not explain nobody would believe of five.
"""

LEADING = 8
"""Effects of those that promise most, of which sets are made."""

TRIED = 4
"""Sets that are fitted in a round."""

SHARE = 0.6
"""Of what the best set keeps, from which another that promises so much is fitted beside it."""

ROUNDS = 6
"""Rounds at most."""

LEVEL = 3.0
"""Difference of the logarithms of two likelihoods (odds of 20 to 1) within which data cannot tell two sets apart."""

EXCHANGED, REACH = 3, 2.0
"""Effects that are tried in the place of one, at most; times `LEVEL` within which first order has to see them."""


Fits = dict[tuple[tuple[Trial, ...], tuple[str, ...]], Fit]
"""Fits of sets that were proposed beside another fit, by what they add and drop."""


@dataclass(frozen=True, eq=False)
class Found:
    """What a search ends with: the fit, its effects with their numbers, the rounds, the gain of each effect that is
    there, for each those that do as well in its place, and the values that would shape every effect best. `otherwise`
    are for each other numbers of the same effect that do as well.
    """

    fit: Fit
    effects: Effects
    steps: Sequence[Step]
    gains: Mapping[str, float]
    alternatives: Mapping[str, Sequence[str]]
    shapes: Shapes
    otherwise: Mapping[str, Sequence[tuple[str, ...]]] = field(default_factory=dict)


def search(start: Fit, effects: Effects, ask: Asked) -> Found:
    """Add, drop and exchange effects until no set gains more than is asked of it."""
    current = start
    taken: Effects = dict(effects)
    steps, seen = list[Step](), {numbers_of(taken): start.rms}
    shapes: dict[str, list[Shape]] = {}
    columns: Seen | None = None
    fits: Fits = {}
    for _ in range(ROUNDS):
        outlook, columns = _outlook(current, taken, ask, columns)
        shapes |= _best_shapes(outlook)
        explored = current.rms > FAR and current.balance.name != SIMULATION  # a pass of a balance costs little
        proposals = _proposals(outlook, taken, ask)
        if ask.is_at_floor(current):
            proposals = [proposal for proposal in proposals if not proposal.added]
        fitted = _promising(proposals, current, taken, ask, fits)
        if explored:
            fitted += _explored(outlook, taken, ask)
        candidates = _candidates(outlook, fitted, ask)
        better = [pair for pair in fitted if is_estimated(pair[1], current.balance)]
        better.sort(key=lambda pair: _left_by(pair, current, taken, ask, explored))
        taking, nearer = choose(better, current, taken, seen, ask)
        if taking is None:
            if nearer is not current:
                current, fits = nearer, {}
            elif ask.shapes:  # which another residual showed best: what it did not show may have others
                ask = replace(ask, shapes={})
            elif (idle := _idle(current, taken, effects, ask)) is not None:
                effect, fewer = idle
                steps.append(Step(current, candidates, (), (effect,)))
                current, fits = fewer, {}
                taken = {name: own for name, own in taken.items() if name != effect}
                seen[numbers_of(taken)] = current.rms
            else:
                steps.append(Step(current, candidates))
                break
            continue
        proposal, found = taking
        steps.append(Step(current, candidates, effects_of(proposal.added), proposal.dropped))
        current, taken, fits = found, after(taken, proposal), {}
        seen[numbers_of(taken)] = found.rms
    current, taken = _simplest(current, taken, ask)
    level = _in_their_place(_outlook(current, taken, ask, columns)[0], taken, ask) if taken else {}
    gains = {effect: min(_worth_of(current, taken, effect, ask), _gained_by(effect, steps)) for effect in taken}
    otherwise = _by_other_numbers(current, taken, ask) if taken else {}
    return Found(current, taken, steps, gains, level, shapes, otherwise)


def _left_by(pair: tuple[Proposal, Fit], current: Fit, taken: Effects, ask: Asked, explored: bool) -> float:
    """By what fitted sets are ordered: half the squares that they leave, and their price; far from noise the rms."""
    proposal, found = pair
    return found.rms if explored else 0.5 * found.squares + ask.price_of(proposal, taken, current.balance)


def _best_shapes(outlook: Outlook) -> dict[str, list[Shape]]:
    """For each effect, and each set of numbers that shape it, the values by which it would gain most."""
    best: dict[tuple[str, frozenset[str]], tuple[float, Shape]] = {}
    for trial in outlook.columns:
        if trial.shapes:
            key = trial.effect, frozenset(name for name, _ in trial.shapes)
            gain = outlook.proposal([trial], {}, 0.0).gain
            if key not in best or gain > best[key][0]:
                best[key] = gain, trial.shapes
    found: dict[str, list[Shape]] = {}
    for (effect, _), (_, shape) in best.items():
        found.setdefault(effect, []).append(shape)
    return found


def _idle(current: Fit, taken: Effects, given: Effects, ask: Asked) -> tuple[str, Fit] | None:
    """An effect with which a fit near noise does no better than it would by chance, and that fit without it; None where
    there is none.
    """
    if current.excess > NEAR_NOISE:
        return None
    return _uncertain(current, taken, ask) or _worthless(current, taken, given, ask)


def _uncertain(current: Fit, taken: Effects, ask: Asked) -> tuple[str, Fit] | None:
    """The effect of a simulated plant that is least certain by its own deviations, if it is not certain enough: once
    nothing more is found, since what is missing makes deviations of its own.
    """
    if ask.settle is None or not taken:
        return None
    certain = {effect: certainty_of(current, effect, own, ask) for effect, own in taken.items()}
    least = min(certain, key=certain.__getitem__)
    return (least, ask.settled(fitted_without(current, taken, [least], ask))) if certain[least] < 0.0 else None


def _worthless(current: Fit, taken: Effects, given: Effects, ask: Asked) -> tuple[str, Fit] | None:
    """An effect without which a fit leaves no more than it costs.

    First order tells too much of one that bends, or jumps as a dry friction does. One that a search has added alone was
    held against the plant without it then; one that was `given` to it, or stands beside others, was not.
    """
    prices = {effect: ask.of(effect, own, current.balance) for effect, own in taken.items()}
    doubtful = [effect for effect in taken if effect in given or len(taken) > 1]
    fits = side_by_side(lambda effect: fitted_without(current, taken, [effect], ask), doubtful)
    lost = {
        effect: 0.5 * (fewer.squares - current.squares) - prices[effect]
        for effect, fewer in zip(doubtful, fits, strict=True)
    }
    for effect, fewer in sorted(zip(doubtful, fits, strict=True), key=lambda pair: lost[pair[0]]):
        if lost[effect] > 0.0:
            break
        settled = ask.settled(fewer)
        if gained(current.balance, left_by(current), left_by(settled)) < prices[effect]:
            return effect, settled
    return None


def _simplest(current: Fit, taken: Effects, ask: Asked) -> tuple[Fit, Effects]:
    """The fit without numbers of its effects that gain less than is asked of them."""
    axis = current.balance.axis
    for effect, own in taken.items():
        for variant in registered(axis)[effect].variants:
            more = [name for name in own if name not in variant]
            if not more or not set(variant) < set(own):
                continue
            spared = ask.of(effect, own, current.balance) - ask.of(effect, variant, current.balance)
            gain, reached = Outlook(current, {}).gain([], away_of(current, more, ask))
            if -gain > REACH * spared:
                continue
            names = [name for name in current.names if name not in more]
            values = declared_again(current.values, more, ask.declared)
            start = nearest(current, [values, {**values, **{name: reached[name] for name in names}}])
            fewer = fit(current.balance, start, names, ask.bounds, QUICK, current.weighing)
            if 0.5 * (fewer.squares - current.squares) < spared:
                current, taken = fewer, {**taken, effect: tuple(name for name in own if name not in more)}
                break
    return current, taken


def _in_their_place(outlook: Outlook, taken: Effects, ask: Asked) -> dict[str, list[str]]:
    """For each effect that was found those that do as well in its place."""
    tried = list[tuple[str, Proposal]]()
    for effect in taken:
        offers: dict[str, Proposal] = {}
        for trial in outlook.columns:
            if trial.effect not in taken:
                offer = _offered(outlook, trial, effect, taken, ask)
                if trial.effect not in offers or offer.score > offers[trial.effect].score:
                    offers[trial.effect] = offer
        near = sorted(offers.values(), key=lambda offer: -offer.score)[:EXCHANGED]
        tried += [(effect, offer) for offer in near]
    level: dict[str, list[str]] = {effect: [] for effect in taken}
    for effect, trial in _as_good(outlook.fitted, tried, taken, ask):
        level[effect].append(trial.effect)
    return level


def _by_other_numbers(current: Fit, taken: Effects, ask: Asked) -> dict[str, list[tuple[str, ...]]]:
    """For each effect that was found the sets of others of its numbers that do as well in the place of its own."""
    known = registered(current.balance.axis)
    trials = [
        Trial(effect, variant)
        for effect, own in taken.items()
        for variant in known[effect].variants
        if not set(variant) & set(own) and not any(known[effect].numbers[name].shapes for name in variant)
    ]
    outlook = Outlook(current, together(seen_of(current, trials, ask.bounds), trials))
    tried = [(trial.effect, _offered(outlook, trial, trial.effect, taken, ask)) for trial in outlook.columns]
    found: dict[str, list[tuple[str, ...]]] = {}
    for effect, trial in _as_good(current, tried, taken, ask):
        found.setdefault(effect, []).append(trial.names)
    return found


def _offered(outlook: Outlook, trial: Trial, effect: str, taken: Effects, ask: Asked) -> Proposal:
    """What a trial promises in the place of an effect that was found."""
    current = outlook.fitted
    price = ask.price((trial,), (effect,), taken, current.balance)
    return outlook.proposal([trial], {effect: away_of(current, taken[effect], ask)}, price)


def _as_good(
    current: Fit, tried: Sequence[tuple[str, Proposal]], taken: Effects, ask: Asked
) -> list[tuple[str, Trial]]:
    """Of trials in the place of effects those that do as well once they are fitted, each with that effect."""
    near = [(effect, offer) for effect, offer in tried if offer.score >= -REACH * LEVEL]
    others = side_by_side(lambda one: fitted_with(current, taken, one[1], ask), near)
    return [
        (effect, offer.added[0])
        for (effect, offer), other in zip(near, others, strict=True)
        if 0.5 * (other.squares - current.squares) + ask.price_of(offer, taken, current.balance) < LEVEL
        and is_estimated(other, current.balance)
    ]


def _explored(outlook: Outlook, taken: Effects, ask: Asked) -> list[tuple[Proposal, Fit]]:
    """Every further effect with all its numbers, fitted in a few steps from the plant as it is declared, in the shape
    that shows most of what is left: far from noise a fit without it has gone where first order tells no size. Those
    that come near the best are fitted on.
    """
    current = outlook.fitted
    own = {name: ask.declared[name] for name in current.names if name in ask.declared}
    largest: dict[str, Trial] = {}
    shown = {trial: outlook.proposal([trial], {}, 0.0).gain for trial in outlook.columns}
    for trial in (one for one in trials_of(current, list(taken), ask.shapes) if _is_few([one], (), taken)):
        before = largest.get(trial.effect)
        if before is None or _fuller(trial, shown) > _fuller(before, shown):
            largest[trial.effect] = trial

    def fitted(trial: Trial) -> tuple[Proposal, Fit]:
        names = [*current.names, *(name for name in trial.names if name not in current.names)]
        start = {**current.values, **own, **dict(trial.shapes)}
        found = fit(current.balance, start, names, ask.bounds, FIRST_STEPS)
        gain = 0.5 * found.residual.size * float(np.log(current.rms**2 / found.rms**2))
        return Proposal((trial,), (), gain, gain - ask.of_trial(trial, current.balance), {}), found

    tried = side_by_side(fitted, largest.values())
    tried.sort(key=lambda pair: -pair[0].score)
    near = [(p, found) for p, found in tried if p.score > NEARLY * max(tried[0][0].score, 0.0)][:TRIED]
    further = side_by_side(lambda pair: again(pair[1], pair[1].weighing, ask.bounds, QUICK), near)
    return [(proposal, found) for (proposal, _), found in zip(near, further, strict=True)]


def _fuller(trial: Trial, shown: Mapping[Trial, float]) -> tuple[int, float]:
    """How many numbers a trial has, and what it gains as far as that is `shown`."""
    return len(trial.names), shown.get(trial, 0.0)


def _outlook(current: Fit, taken: Effects, ask: Asked, before: Seen | None) -> tuple[Outlook, Seen]:
    """What is to be expected beside a fit, and the columns that show it, with those that were seen `before`."""
    trials = trials_of(current, list(taken), ask.shapes)
    seen = seen_of(current, trials, ask.bounds, before)
    return Outlook(current, together(seen, trials)), seen


def _proposals(outlook: Outlook, taken: Effects, ask: Asked) -> list[Proposal]:
    """Sets that may do better, from the best: further effects, one or more at once, with any of those that are there
    dropped.
    """
    ordered = list(_best_alone(outlook, ask).values())
    own_noise(outlook.fitted)  # once for all threads
    further = [trial for trial in ordered if _is_few([trial], (), taken)]
    alone = side_by_side(lambda trial: outlook.alone(trial, ask.of_trial(trial, outlook.fitted.balance)), further)
    leading = ordered[:LEADING]
    sets: list[tuple[Trial, ...]] = []
    for count in range(2, TOGETHER + 1):
        sets += list(combinations(leading, count))
    drops: list[tuple[str, ...]] = [(), *((effect,) for effect in taken)]
    found = []
    for dropped in drops:
        wanted = [(), *((trial,) for trial in leading)] if dropped else sets
        for added in (one for one in wanted if _is_few(one, dropped, taken)):
            away = {effect: away_of(outlook.fitted, taken[effect], ask) for effect in dropped}
            found.append(outlook.proposal(added, away, ask.price(added, dropped, taken, outlook.fitted.balance)))
    most = max((proposal.score for proposal in alone), default=0.0)
    found = [proposal for proposal in found if proposal.score > most or proposal.dropped]  # else one goes first
    return sorted([*alone, *found], key=lambda proposal: -proposal.score)


def _is_few(added: Sequence[Trial], dropped: Sequence[str], taken: Effects) -> bool:
    """Whether with these a plant lacks no more effects than it may at once, or no more than those that are taken."""
    return len({*taken} - {*dropped} | {*effects_of(added)}) <= max(MOST, len(taken))


def _promising(
    proposals: Sequence[Proposal], current: Fit, taken: Effects, ask: Asked, fits: Fits
) -> list[tuple[Proposal, Fit]]:
    """Sets that promise something, fitted from the best on, until one keeps what the others do not even promise; those
    that were fitted beside the same effects are in `fits`, and are added to it.
    """
    fitted, kept = list[tuple[Proposal, Fit]](), 0.0
    for proposal in proposals[:TRIED]:
        if proposal.score <= max(min(SHARE * kept, kept - LEVEL), 0.0):
            break
        key = proposal.added, proposal.dropped
        found = fits[key] if key in fits else fitted_with(current, taken, proposal, ask)
        fits[key] = found
        fitted.append((proposal, found))
        if is_estimated(found, current.balance):
            kept = max(kept, 0.5 * (current.squares - found.squares) - ask.price_of(proposal, taken, current.balance))
    return fitted


def _worth_of(current: Fit, taken: Effects, effect: str, ask: Asked) -> float:
    """What an effect gains that is there: how much would be lost without it, to first order."""
    outlook = Outlook(current, {})
    return -outlook.gain([], away_of(current, taken[effect], ask))[0]


def _gained_by(effect: str, steps: Sequence[Step]) -> float:
    """What an effect gained in the round that added it alone, without bound if none did: what is lost without it to
    first order is too much of one that bends far.
    """
    gains = [one.gain for step in steps if step.added == (effect,) for one in step.candidates if one.effect == effect]
    return gains[-1] if gains else np.inf


def _candidates(outlook: Outlook, fitted: Sequence[tuple[Proposal, Fit]], ask: Asked) -> list[Candidate]:
    """Every effect of a round, from the best, with what it gains by the noise that it would leave itself."""
    best, balance = _best_alone(outlook, ask), outlook.fitted.balance
    found = {
        effect: Candidate(effect, trial.names, outlook.alone(trial, 0.0).gain, ask.of_trial(trial, balance))
        for effect, trial in best.items()
    }
    for proposal, other in fitted:
        if len(proposal.added) == 1 and not proposal.dropped:
            (trial,) = proposal.added
            gain = max(proposal.gain, 0.5 * (outlook.fitted.squares - other.squares))
            found[trial.effect] = Candidate(trial.effect, trial.names, gain, ask.of_trial(trial, balance), other)
    return sorted(found.values(), key=lambda candidate: candidate.asked - candidate.gain)


def _best_alone(outlook: Outlook, ask: Asked) -> dict[str, Trial]:
    """For each effect the trial that promises most by the noise of the fit, from the best effect on."""
    best: dict[str, tuple[float, Trial]] = {}
    for trial in outlook.columns:
        score = outlook.proposal([trial], {}, ask.of_trial(trial, outlook.fitted.balance)).score
        if trial.effect not in best or score > best[trial.effect][0]:
            best[trial.effect] = (score, trial)
    return {effect: trial for effect, (_, trial) in sorted(best.items(), key=lambda item: -item[1][0])}
