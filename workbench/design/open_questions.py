"""Hypotheses that a diagnosis left open, with what its records tell of them.

An effect that the records show, among as many shapes as it may have, is as they show it. One that they do not show is
as large as they allow: two standard deviations of what they tell of its size, once the plant's parameters are fitted to
it anew; and where it has a shape, such as a period, it may be of others too, of which those are taken that would look
most unlike in the records.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from plants.effects.registry import effects as registered
from workbench.design.diagnosed import Evidence, Reported
from workbench.design.hypotheses import Hypothesis
from workbench.diagnose.readiness import declared_values
from workbench.diagnose.residuals.fit import AS_IT_IS, THOROUGH, Fit, fit
from workbench.diagnose.residuals.unknowns import Bounds, Values
from workbench.diagnose.selection.likelihood import Outlook, Proposal
from workbench.diagnose.selection.search import away_of
from workbench.diagnose.selection.selection import Effects
from workbench.diagnose.selection.sets import Asked, fitted_with, is_estimated
from workbench.diagnose.selection.trials import Columns, Shape, Trial, columns_of, looks, trials_of
from workbench.errors import UserError, nearest
from workbench.fitting.covariance import inverse
from workbench.parameters.sets import NEUTRAL
from workbench.progress import Progress
from workbench.publish.words import listed, plain_name

SHOWN = 2.0
"""Standard deviations from 0 up to which records do not show an effect: it may be as large."""

BEYOND = 1.5
"""Times what first order says of such a size that squares may rise by."""

SMALLER, TIMES, FURTHER = 0.3, 16, 4
"""Factor by which such a size is taken down where first order does not reach so far, how often, and how often it is
taken up where it reaches farther.
"""

MOST = 3
"""Hypotheses of a diagnosis that names none, at most."""

OTHERS, ALIKE = 2, 0.9
"""Further shapes of an effect that the records do not show, at most, and the cosine between what two shapes change of
the records up to which they are not one.
"""


def hypotheses_of(
    reported: Reported, evidence: Evidence, between: Sequence[str], progress: Progress
) -> list[Hypothesis]:
    """What may be true by a diagnosis: the sets that it could not tell apart, or those `between` which it is asked.

    Raises:
        UserError: an effect that these records' plant cannot have, or that no channel shows.
    """
    sets, is_asked = _sets(reported, evidence, between)
    ask = Asked(declared_values(reported.experiment), reported.experiment.bounds, len(evidence.how.effects), {})
    taken: Effects = {
        effect: names
        for effect, own in reported.effects.items()
        if (names := tuple(name for name in own if name in evidence.fit.names))
    }
    found = list[Hypothesis]()
    for effects in sets:
        progress("hypotheses along the records", 0.05 + 0.1 * len(found) / MOST)
        try:
            found.append(_hypothesis(evidence.fit, taken, effects, ask))
        except UserError:
            if is_asked or not found:
                raise  # else it was only tried: the next one may be
        if len(found) == MOST and not is_asked:
            break
    return found


def _sets(reported: Reported, evidence: Evidence, between: Sequence[str]) -> tuple[list[tuple[str, ...]], bool]:
    """The sets of effects that are held against each other, and whether all of them are asked for: else they are those
    that may be, the best first.
    """
    found, instead = list(reported.effects), reported.alternatives
    if between:
        for name in between:
            if name != "none" and name not in evidence.how.effects:
                raise UserError(
                    f'"{name}": no effect that the channels of {reported.experiment.path} could show; '
                    f"{nearest(name, ['none', *evidence.how.effects])}"
                )
        rest = [one for one in found if one not in between and not {*instead[one]} & {*between}]
        return [tuple(rest) if name == "none" else (*rest, name) for name in between], True
    doubted = next((effect for effect in found if instead[effect]), None)
    if doubted is not None:
        rest = [one for one in found if one != doubted]
        return [(*rest, name) for name in (doubted, *instead[doubted])][:MOST], True
    return [tuple(found), *((*found, name) for name in _unseen(evidence, found))], False


def _unseen(evidence: Evidence, found: Sequence[str]) -> list[str]:
    """Effects that the records could not have shown, or hardly: what they show least comes first."""
    trials = [trial for trial in trials_of(evidence.fit, list(found), {}) if not trial.shapes]
    columns = columns_of(evidence.fit, trials, {})
    shown = {trial.effect: float(np.linalg.norm(columns[trial].block)) if trial in columns else 0.0 for trial in trials}
    return sorted(shown, key=lambda name: shown[name])


def _hypothesis(current: Fit, taken: Effects, effects: tuple[str, ...], ask: Asked) -> Hypothesis:
    """The plant with these effects, from the fit with those that were found."""
    added = [name for name in effects if name not in taken]
    away = {effect: away_of(current, taken[effect], ask) for effect in taken if effect not in effects}
    if not added and not away:
        return _fitted(current, effects)
    trials = [trial for trial in trials_of(current, list(taken), {}) if trial.effect in added]
    outlook = Outlook(current, columns_of(current, trials, ask.bounds))
    chosen = [_likeliest(outlook, away, name) for name in added]
    proposal = outlook.proposal(chosen, away, 0.0)
    if away:
        return _fitted(fitted_with(current, taken, proposal, ask), effects)
    shapes = dict(shape for trial in chosen for shape in trial.shapes)
    chance = sum(np.log(looks(current.balance, trial.effect, trial.names)) for trial in chosen)
    if proposal.gain > 0.5 * SHOWN**2 + chance:
        fitted = fitted_with(current, taken, proposal, ask)
        if fitted.squares < current.squares and is_estimated(fitted, current.balance):
            return _known(fitted, [*fitted.names, *shapes], effects, ask.bounds)
    further = trials_of(current, list(taken), {name: _grid(current, name) for name in added})
    trials += [trial for trial in further if trial.effect in added and trial not in trials]
    outlook = Outlook(current, columns_of(current, trials, ask.bounds))
    hidden = [outlook.columns[_hidden(outlook, name)] for name in added]
    first = _allowed(current, hidden, effects, ask.bounds)
    return replace(first, others=_others(outlook, hidden, effects, ask.bounds))


def _fitted(of: Fit, effects: tuple[str, ...]) -> Hypothesis:
    """A fit as a hypothesis."""
    return Hypothesis(effects, _acting(of.values, of.names), of.unknowns, of.curvature)


def _known(of: Fit, names: Sequence[str], effects: tuple[str, ...], bounds: Bounds) -> Hypothesis:
    """The values of a fit as a hypothesis, with what its records tell of more of them."""
    return _fitted(fit(of.balance, of.values, tuple(dict.fromkeys(names)), bounds, AS_IT_IS, of.weighing), effects)


def _acting(values: Values, names: Sequence[str]) -> dict[str, float]:
    """The values of the plant, without those of effects that are not there."""
    return {name: value for name, value in values.items() if name not in NEUTRAL or name in names}


def _offers(outlook: Outlook, away: Mapping[str, Mapping[int, float]], effect: str) -> list[Proposal]:
    """An effect with each of its numbers and shapes that the records could show."""
    offers = [outlook.proposal([trial], away, 0.0) for trial in outlook.columns if trial.effect == effect]
    if not offers:
        raise UserError(f"{plain_name(effect)}: the records tell of no size that it could have")
    return offers


def _likeliest(outlook: Outlook, away: Mapping[str, Mapping[int, float]], effect: str) -> Trial:
    """Of an effect's numbers and shapes those that the records like best."""
    return max(_offers(outlook, away, effect), key=lambda offer: offer.gain).added[0]


def _hidden(outlook: Outlook, effect: str) -> Trial:
    """Of an effect's numbers and shapes those with which it would show most, had no parameter made up for it, at the
    size that the records allow.
    """

    def shows(trial: Trial) -> float:
        columns = outlook.columns[trial]
        size = _reaches(outlook.fitted, [columns])[len(outlook.fitted.unknowns) :]
        return float(np.linalg.norm(columns.block @ np.clip(size, columns.low, columns.high)))

    return max((offer.added[0] for offer in _offers(outlook, {}, effect)), key=shows)


def _grid(current: Fit, effect: str) -> list[Shape]:
    """The shapes of an effect from which searches begin by themselves: a period that no record shows stands out of
    none.
    """
    numbers = registered(current.balance.axis)[effect].numbers
    grids = {
        name: [number.scale(current.balance.scales) * value for value in number.grid]
        for name, number in numbers.items()
        if number.shapes
    }
    return [tuple(zip(grids, values, strict=True)) for values in product(*grids.values())] if grids else []


def _others(
    outlook: Outlook, hidden: Sequence[Columns], effects: tuple[str, ...], bounds: Bounds
) -> tuple[Hypothesis, ...]:
    """The same with a single hidden effect in its other shapes; none of several effects at once."""
    if len(hidden) != 1:
        return ()
    (of,) = hidden
    same = [
        one
        for one in outlook.columns.values()
        if (one.trial.effect, one.trial.sized) == (of.trial.effect, of.trial.sized)
    ]
    ways = {one.trial: np.linalg.qr(one.block)[0] for one in same}
    chosen, found = [of.trial], list[Hypothesis]()
    while len(chosen) <= OTHERS:
        cosines = {
            trial: max(float(np.linalg.norm(ways[other].T @ way, 2)) for other in chosen) for trial, way in ways.items()
        }
        unlike = min(cosines, key=lambda trial: cosines[trial])
        if cosines[unlike] > ALIKE:
            break
        chosen.append(unlike)
        try:
            found.append(_allowed(outlook.fitted, [outlook.columns[unlike]], effects, bounds))
        except UserError:  # the records speak against this shape
            continue
    return tuple(found)


def _reaches(current: Fit, columns: Sequence[Columns]) -> np.ndarray:
    """How far the unknowns of a fit and of what sizes effects move, to first order, where these are as large as the
    records allow.
    """
    own, block = current.jacobian * current.free, np.column_stack([one.block for one in columns])
    count, more = own.shape[1], block.shape[1]
    covariance = inverse(np.block([[current.curvature, own.T @ block], [block.T @ own, block.T @ block]]))
    room = np.concatenate([one.high for one in columns])
    shift = np.zeros(count + more)
    for k in range(count, count + more):
        side = 1.0 if room[k - count] > 0.0 else -1.0
        shift += side * SHOWN * covariance[:, k] / np.sqrt(max(covariance[k, k], 1e-300)) / np.sqrt(more)
    return shift


def _allowed(current: Fit, columns: Sequence[Columns], effects: tuple[str, ...], bounds: Bounds) -> Hypothesis:
    """Effects beside those that are there, as large as the records allow once the other parameters are fitted to them
    anew: their profile likelihood falls by what `SHOWN` standard deviations make of it.

    Raises:
        UserError: the records speak against them at any size that the plant can have.
    """
    shift, count = _reaches(current, columns), len(current.unknowns)
    most = current.squares + BEYOND * SHOWN**2
    named = [*current.names, *(name for one in columns for name in one.values(one.starts))]
    low, high = np.array([u.low for u in current.unknowns]), np.array([u.high for u in current.unknowns])

    def sized(share: float, own: np.ndarray) -> dict[str, float]:
        """The values with the effects at a share of that size, and the plant's own parameters moved."""
        values, at = {**_acting(current.values, current.names), **current.at(np.clip(own, low, high))}, count
        for one in columns:
            values |= one.values(share * shift[at : at + one.starts.size])
            at += one.starts.size
        return values

    def profiled(share: float) -> Fit:
        ways = [sized(share, current.places + moved * shift[:count]) for moved in (share, 0.0)]
        start = min(ways, key=current.seen_at)
        return fit(current.balance, start, current.names, bounds, THOROUGH, current.weighing)

    share, found, refused = 1.0, profiled(1.0), False
    for _ in range(TIMES):
        if found.squares < most:
            break
        share, refused = SMALLER * share, True
        found = profiled(share)
    else:
        words = listed([plain_name(effect) for effect in effects])
        raise UserError(f"{words}: the records speak against it at any size that the plant can have")
    for _ in range(FURTHER):
        larger = profiled(share * (SMALLER**-0.5 if refused else 1.0 / SMALLER))
        if larger.squares >= most or larger.values == found.values:
            break
        share, found = share * (SMALLER**-0.5 if refused else 1.0 / SMALLER), larger
        if refused:
            break
    return _known(found, named, effects, bounds)
