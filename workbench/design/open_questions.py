"""Hypotheses that a diagnosis left open, with what its records tell of them.

An effect that the records show is as they show it. One that they do not show is as large as they allow: two standard
deviations of what they tell of its size, once the plant's parameters have made up for it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from workbench.design.diagnosed import Evidence, Reported
from workbench.design.hypotheses import Hypothesis
from workbench.diagnose.readiness import declared_values
from workbench.diagnose.residuals.fit import VAGUE, Fit
from workbench.diagnose.residuals.unknowns import Values, unknown
from workbench.diagnose.selection.likelihood import Outlook, Proposal
from workbench.diagnose.selection.search import away_of
from workbench.diagnose.selection.selection import Effects
from workbench.diagnose.selection.sets import Asked, fitted_with, is_estimated
from workbench.diagnose.selection.trials import Columns, Trial, columns_of, trials_of
from workbench.errors import UserError, nearest
from workbench.fitting.covariance import inverse
from workbench.parameters.sets import NEUTRAL
from workbench.progress import Progress
from workbench.publish.words import listed, plain_name

SHOWN = 2.0
"""Standard deviations from 0 up to which records do not show an effect: it may be as large."""

SMALLER, TIMES = 0.3, 16
"""Factor by which such a size is taken down where first order does not reach so far, and how often."""

MOST = 4
"""Hypotheses of a diagnosis that names none, at most."""


def hypotheses_of(
    reported: Reported, evidence: Evidence, between: Sequence[str], progress: Progress
) -> list[Hypothesis]:
    """What may be true by a diagnosis: the sets that it could not tell apart, or those `between` which it is asked.

    Raises:
        UserError: an effect that these records' plant cannot have, or that no channel shows.
    """
    sets = _sets(reported, evidence, between)
    ask = Asked(declared_values(reported.experiment), reported.experiment.bounds, len(evidence.how.effects), {})
    taken: Effects = {
        effect: names
        for effect, own in reported.effects.items()
        if (names := tuple(name for name in own if name in evidence.fit.names))
    }
    found = []
    for number, effects in enumerate(sets):
        progress("hypotheses along the records", 0.05 + 0.1 * number / len(sets))
        found.append(_hypothesis(evidence.fit, taken, effects, ask))
    return found


def _sets(reported: Reported, evidence: Evidence, between: Sequence[str]) -> list[tuple[str, ...]]:
    """The sets of effects that are held against each other."""
    found, instead = list(reported.effects), reported.alternatives
    if between:
        for name in between:
            if name != "none" and name not in evidence.how.effects:
                raise UserError(
                    f'"{name}": no effect that the channels of {reported.experiment.path} could show; '
                    f"{nearest(name, ['none', *evidence.how.effects])}"
                )
        rest = [one for one in found if one not in between and not {*instead[one]} & {*between}]
        return [tuple(rest) if name == "none" else (*rest, name) for name in between]
    doubted = next((effect for effect in found if instead[effect]), None)
    if doubted is not None:
        rest = [one for one in found if one != doubted]
        return [(*rest, name) for name in (doubted, *instead[doubted])][:MOST]
    unseen = _unseen(evidence, found)
    return [tuple(found), *((*found, name) for name in unseen)][:MOST]


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
    found = None
    if proposal.gain > 0.5 * SHOWN**2:
        fitted = fitted_with(current, taken, proposal, ask)
        found = fitted.values if fitted.squares < current.squares and is_estimated(fitted, current.balance) else None
    if found is None:
        chosen = [_hidden(outlook, name) for name in added]
    return _beside(current, outlook, chosen, effects, found)


def _fitted(of: Fit, effects: tuple[str, ...]) -> Hypothesis:
    """A fit as a hypothesis."""
    return Hypothesis(effects, _acting(of.values, of.names), of.unknowns, of.curvature)


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
    """Of an effect's numbers and shapes those that could hide the largest size from the records."""

    def variance(trial: Trial) -> float:
        return float(inverse(_precision(outlook.fitted, [outlook.columns[trial]]))[-1, -1])

    return max((offer.added[0] for offer in _offers(outlook, {}, effect)), key=variance)


def _beside(
    current: Fit, outlook: Outlook, chosen: Sequence[Trial], effects: tuple[str, ...], found: Values | None
) -> Hypothesis:
    """Effects beside those that are there, at values that were `found`, else as large as the records allow."""
    columns = [outlook.columns[trial] for trial in chosen]
    shapes = dict(shape for trial in chosen for shape in trial.shapes)
    shaping = [unknown(name, {**current.values, **shapes}, {}, current.balance.scales) for name in shapes]
    inner = _precision(current, columns)
    count, both = len(current.unknowns), inner.shape[0]
    precision = np.eye(both + len(shaping)) / VAGUE**2
    precision[:both, :both] = inner
    starts = np.concatenate([one.starts for one in columns])
    unknowns = [*current.unknowns, *(u for one in columns for u in one.unknowns), *shaping]
    new = unknowns[count:both]
    neutral = {u.name: u.value(float(start)) for u, start in zip(new, starts, strict=True)}
    values = {**_acting(current.values, current.names), **shapes, **neutral}
    hypothesis = Hypothesis(effects, values, unknowns, precision)
    if found is not None:
        return replace(hypothesis, values={**values, **{u.name: found[u.name] for u in unknowns}})
    return replace(hypothesis, values=_allowed(current, hypothesis, range(count, both)))


def _precision(current: Fit, columns: Sequence[Columns]) -> np.ndarray:
    """Of the unknowns of a fit and of what sizes effects beside them."""
    own, block = current.jacobian * current.free, np.column_stack([one.block for one in columns])
    return np.block([[current.curvature, own.T @ block], [block.T @ own, block.T @ block]])


def _allowed(current: Fit, hypothesis: Hypothesis, sized: range) -> dict[str, float]:
    """The values with an effect as large as the records allow, and the other parameters as they make up for it.

    Raises:
        UserError: they speak against it at any size that the plant can have.
    """
    covariance = inverse(hypothesis.precision)
    shift = np.zeros(len(hypothesis.unknowns))
    for k in sized:
        side = 1.0 if hypothesis.room[1][k] > 0.0 else -1.0
        shift += side * SHOWN * covariance[:, k] / np.sqrt(max(covariance[k, k], 1e-300)) / np.sqrt(len(sized))
    for _ in range(TIMES):
        values = hypothesis.moved(shift)
        if current.seen_at(values) < current.squares + 2.0 * SHOWN**2:
            return values
        shift = SMALLER * shift
    names = listed([plain_name(effect) for effect in hypothesis.effects])
    raise UserError(f"{names}: the records speak against it at any size that the plant can have")
