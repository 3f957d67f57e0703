"""Whether a set of effects that was fitted is taken: by the noise that it leaves itself, against the best fit without
it, on parts that were left out, and against what it would gain where nothing is missing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from workbench.diagnose.residuals.fit import NEAR_NOISE, Fit, again, fit, weighing_at
from workbench.diagnose.selection.hum import hums_for, without_hum
from workbench.diagnose.selection.likelihood import Proposal, gained, left_by
from workbench.diagnose.selection.selection import Effects
from workbench.diagnose.selection.sets import (
    FAR,
    QUICK,
    Asked,
    after,
    fitted_with,
    fitted_without,
    is_estimated,
    numbers_of,
)
from workbench.fitting.threads import side_by_side

WEIGHED = 2
"""Sets of a round that are looked at by the noise that they leave themselves."""

BESIDE = 1.1
"""Times the least rms, of this and of any earlier round, that a fit may leave which is weighed: noise of any colour
hides what drifts away slowly.
"""

NEARER = 0.98
"""Times the rms that a set left when it was seen, from which it is another one."""

BY_BLOCKS = 0.3
"""Share of what an effect gains that it has to gain on blocks that were left out of its fit, too."""

BEYOND = 0.5
"""Share of what is asked of an effect by which it has to gain more where blocks that were left out do not show it: what
happens once in a record is in one block alone. Of a balance, whose noise nobody knows, blocks have to show it, unless
what is added brings near to noise what was far from it.
"""


def choose(
    better: Sequence[tuple[Proposal, Fit]],
    current: Fit,
    taken: Effects,
    seen: Mapping[frozenset[str], float],
    ask: Asked,
) -> tuple[tuple[Proposal, Fit] | None, Fit]:
    """The first set that gains what is asked of it by the noise that it leaves itself, on blocks left out, too; and the
    fit without it, which may be nearer than it was. Sets that were `seen`, by their numbers, with the rms that they
    left then, are none, unless they are nearer now.
    """
    known_as = partial(_is_known, taken=taken, seen=seen)
    nearer = current
    for proposal, tried in better[:WEIGHED]:
        if known_as(proposal, tried) or not _is_shown(tried, current, ask):
            continue
        proposal, found = _needed(proposal, ask.settled(tried), current, taken, ask)
        if known_as(proposal, found):
            continue
        beside = _beside(nearer, found, ask)
        worth = _gained(found, beside) - ask.price_of(proposal, taken, current.balance)
        least = ask.least_share * len(proposal.added)
        enough = not least or (not ask.is_at_floor(beside) and found.rms <= (1.0 - least) * beside.rms)
        known, near = is_estimated(found, current.balance), found.rms < BESIDE * min([beside.rms, *seen.values()])
        if (
            worth > max(0.0, _by_itself(beside, found, ask))
            and known
            and near
            and enough
            and _is_no_hum(proposal, found, beside, ask)
            and _is_sure(proposal, found, beside, current, taken, ask)
            and _is_in_all_samples(proposal, found, beside, taken, ask)
        ):
            return (proposal, found), nearer
        if beside is not nearer and beside.squares < nearer.seen_by(beside.weighing) - 1.0:
            nearer = beside
    return None, nearer


def _is_sure(proposal: Proposal, found: Fit, beside: Fit, current: Fit, taken: Effects, ask: Asked) -> bool:
    """Whether what is added gains far more than is asked of it, or holds on blocks left out, too; in exchange for
    others beside the fit without either, since what is sure beside a bad effect may be none.
    """
    if not proposal.added:
        return True
    if proposal.dropped:
        beside = ask.settled(fitted_without(current, taken, proposal.dropped, ask))
    price = sum(ask.of_trial(trial, found.balance) for trial in proposal.added)
    if ask.settle is None:
        far = beside.rms > FAR and found.rms < NEAR_NOISE
    else:
        far = _gained(found, beside) > (1.0 + BEYOND) * price
    return far or _holds(beside, found, price, ask)


def _is_no_hum(proposal: Proposal, found: Fit, beside: Fit, ask: Asked) -> bool:
    """Whether what is added and repeats over time gains what is asked of it beside hums of the sensors."""
    for trial in proposal.added:
        hums = hums_for(found.balance, trial.effect, found.moved, beside.residual)
        if hums:
            one, other = (
                (weighing, without_hum(found.balance, residual, hums), vague)
                for weighing, residual, vague in map(left_by, (found, beside))
            )
            if gained(found.balance, one, other) < ask.price((trial,), (), {}, found.balance):
                return False
    return True


def _is_shown(tried: Fit, current: Fit, ask: Asked) -> bool:
    """Whether all samples are likelier with a set than without, as both were fitted to means over some: what means
    alone have made is found out before it is settled.
    """
    return ask.shown is None or _gained(*map(ask.shown, (tried, current))) > 0.0


def _is_in_all_samples(proposal: Proposal, found: Fit, beside: Fit, taken: Effects, ask: Asked) -> bool:
    """Whether what a set gains of means over some samples it gains of all of them, too, with and without it fitted to
    these.

    A loop moves the plant by the noise of each sample, so that an effect may depend on noise before it, and does not on
    its own. A mean holds both, and noise is taken for an effect.
    """
    if ask.all_samples is None:
        return True
    return _gained(*map(ask.all_samples, (found, beside))) > ask.price_of(proposal, taken, found.balance)


def _is_known(proposal: Proposal, fitted: Fit, taken: Effects, seen: Mapping[frozenset[str], float]) -> bool:
    """Whether a set was left before that was as near as it is now."""
    return fitted.rms > NEARER * seen.get(numbers_of(after(taken, proposal)), np.inf)


def _gained(found: Fit, beside: Fit) -> float:
    """By how much a fit is likelier than another one beside it."""
    return gained(found.balance, left_by(found), left_by(beside))


def _needed(proposal: Proposal, found: Fit, current: Fit, taken: Effects, ask: Asked) -> tuple[Proposal, Fit]:
    """A set with its fit, less what it has that is not worth what is asked of it beside the others."""
    for trial in proposal.added if len(proposal.added) > 1 else ():
        others = tuple(other for other in proposal.added if other is not trial)
        start = {name: value for name, value in proposal.start.items() if any(name in other.names for other in others)}
        fewer = replace(proposal, added=others, start=start)
        without = ask.settled(fitted_with(current, taken, fewer, ask))
        lost = _gained(found, without)
        if lost < ask.of_trial(trial, current.balance) or found.rms > (1.0 - ask.least_share) * without.rms:
            return _needed(fewer, without, current, taken, ask)
    return proposal, found


def _beside(current: Fit, rival: Fit, ask: Asked) -> Fit:
    """A fit again without what a rival has, from where that one found the parameters of both, if that is better: what
    the rival gains is then no effect's.
    """
    start = {**current.values, **{name: rival.values[name] for name in current.names if name in rival.names}}
    begun = current if ask.settle is None else rival
    other = fit(begun.balance, start, current.names, ask.bounds, QUICK, rival.weighing)
    fits = [current, other, *([ask.settle(other)] if ask.settle is not None else [])]
    nearest = min(one.rms for one in fits)
    return min((one for one in fits if one.rms < BESIDE * nearest), key=lambda one: _gained(rival, one))


def _holds(before: Fit, found: Fit, price: float, ask: Asked) -> bool:
    """Whether what a set gains it gains on blocks left out, too."""
    there = before if before.weighing is found.weighing else again(before, found.weighing, ask.bounds, QUICK)
    left = 0.5 * (float(there.left_out @ there.left_out) - float(found.left_out @ found.left_out))
    return left > BY_BLOCKS * price


def _by_itself(before: Fit, found: Fit, ask: Asked) -> float:
    """What a set gains on motions on which nothing is missing: what smoothing and contacts leave, effects take."""
    null = replace(before.balance, motions=before.balance.null, null=())
    if not null.motions:
        return 0.0
    plain, rival = side_by_side(lambda one: fit(null, one.values, one.names, ask.bounds, QUICK), (before, found))
    rival = again(rival, weighing_at(rival), ask.bounds, QUICK)
    return 0.5 * max(plain.seen_by(rival.weighing) - rival.squares, 0.0)
