"""What a diagnosis knows: its hypotheses, fitted to the records that it had, and the noise that they leave."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plants.effects.registry import effects as registered
from workbench.design.hypotheses import Hypothesis
from workbench.diagnose.readiness import check_experiment, declared_values, motions_of
from workbench.diagnose.report.folder import RESULT
from workbench.diagnose.residuals.fit import AS_IT_IS, Fit, fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.residuals.weighing import Whitening
from workbench.diagnose.selection.likelihood import Outlook
from workbench.diagnose.selection.search import away_of
from workbench.diagnose.selection.selection import Effects
from workbench.diagnose.selection.sets import Asked, fitted_with
from workbench.diagnose.selection.trials import columns_of, trials_of
from workbench.diagnose.simulation.fits import Fitting
from workbench.diagnose.simulation.setup import as_simulated, shooting_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.errors import UserError, nearest
from workbench.parameters.sets import NEUTRAL
from workbench.progress import Progress
from workbench.records.experiment import Experiment, read_experiment
from workbench.records.reading import read_records

SHOWN = 2.0
"""Standard deviations from 0 up to which records do not show an effect: it may still be larger by as many."""

MOST = 4
"""Hypotheses of a diagnosis that names none, at most."""


@dataclass(frozen=True, eq=False)
class Reported:
    """What report.json of a diagnosis says: the experiment, effects with their numbers (SI) and what each may be instead,
    fitted parameters with and without them, those that are not identified, and whether a voltage held.
    """

    folder: Path
    experiment: Experiment
    effects: Mapping[str, Mapping[str, float]]
    alternatives: Mapping[str, Sequence[str]]
    baseline: Mapping[str, float]
    fitted: Mapping[str, float]
    vague: Sequence[str]
    held: bool


@dataclass(frozen=True, eq=False)
class Evidence:
    """The records of a diagnosis: how its plant is simulated along them, and how it fits them with what was found."""

    motions: Sequence[Motion]
    how: Shooting
    fit: Fit

    @property
    def noise(self) -> dict[str, float]:
        """Standard deviation (SI) of a sample of each channel."""
        return {name: max(one.sensed[name] for one in self.motions) for name in self.how.channels}

    @property
    def whitening(self) -> dict[str, Whitening]:
        """Of each channel's means, as the fit weighs them."""
        return dict(zip(self.how.channels, self.fit.weighing.filters, strict=True))


def read_diagnosis(folder: Path) -> Reported:
    """What a folder of `workbench diagnose` says.

    Raises:
        UserError: it is none, or its experiment is not there.
    """
    path = folder / RESULT
    try:
        said: Any = json.loads(path.read_text(encoding="utf-8"))
        effects = {one["name"]: _values(one["parameters"]) for one in said["effects"]}
        instead = {one["name"]: list(one["alternatives"]) for one in said["effects"]}
        fitted, baseline = said["fitted"], _values(said["baseline"])
        experiment, simulation = Path(said["experiment"]), said["simulation"]
        vague = [name for name, one in fitted.items() if not one["identified"]]
        numbers = _values(fitted)
    except OSError:
        raise UserError(f"{folder}: is no diagnosis: it holds no {RESULT}; expected a folder of workbench diagnose") from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise UserError(f"{path}: is not what workbench diagnose writes ({error}); diagnose again") from None
    if simulation is None:
        raise UserError(f"{folder}: its records do not drive the plant in a simulation, by which a motion is designed")
    found = _found(experiment, folder)
    return Reported(
        folder, read_experiment(found), effects, instead, baseline, numbers, vague, bool(simulation["voltage_is_held"])
    )


def _values(table: Mapping[str, Mapping[str, float]]) -> dict[str, float]:
    return {name: float(number["value"]) for name, number in table.items()}


def _found(experiment: Path, folder: Path) -> Path:
    """The experiment of a diagnosis, as it was told, from here or from a folder around the diagnosis."""
    for place in (Path(), *folder.resolve().parents):
        if (place / experiment).is_file():
            return place / experiment
    raise UserError(f"{folder}: its experiment {experiment} is not there; run this where workbench diagnose was run")


def evidence_of(reported: Reported, progress: Progress) -> Evidence:
    """The diagnosed plant along its records, fitted from where the diagnosis has left it.

    Raises:
        UserError: its records are gone, or nobody commanded them.
    """
    experiment = reported.experiment
    progress("reading records", 0.0)
    check_experiment(experiment)
    motions = as_simulated(experiment, motions_of(experiment, read_records(experiment, "fit")))
    how = shooting_of(experiment, motions, held=reported.held)
    if how is None or how.is_beside(motions[0]):
        raise UserError(
            f"{experiment.path}: no channel is the plant's {experiment.plant.command}: what moves by hand has no motion "
            "that could be designed"
        )
    known = how.along.parameter_names
    found = {name: value for own in reported.effects.values() for name, value in own.items() if name in known}
    values = {**declared_values(experiment), **reported.baseline, **reported.fitted, **found}
    names = [name for name in [*reported.baseline, *found] if name in known]
    fitting = Fitting(motions, list(dict.fromkeys(names)), experiment.bounds)
    progress("the diagnosed plant along its records", 0.02)
    best = fitting.final(fitting.begun(how, values))
    return Evidence(motions, best.how, best.fit)


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
        effect: tuple(name for name in own if name in evidence.fit.names) for effect, own in reported.effects.items()
    }
    taken = {effect: names for effect, names in taken.items() if names}
    found = []
    for number, effects in enumerate(sets):
        progress("hypotheses along the records", 0.05 + 0.1 * number / len(sets))
        found.append(_hypothesis(evidence, _fit_of(evidence, taken, effects, ask), effects))
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
    """Effects that the records could not have shown at any plausible size, or hardly: those they show least come first."""
    trials = [trial for trial in trials_of(evidence.fit, list(found), {}) if not trial.shapes]
    columns = columns_of(evidence.fit, trials, {})
    shown = {
        trial.effect: float(np.linalg.norm(columns[trial].block)) if trial in columns else 0.0 for trial in trials
    }
    return sorted(shown, key=lambda name: shown[name])


def _fit_of(evidence: Evidence, taken: Effects, effects: Sequence[str], ask: Asked) -> Fit:
    """The plant with these effects fitted to the records, from the fit with those that were found."""
    current = evidence.fit
    added = [name for name in effects if name not in taken]
    away = {effect: away_of(current, taken[effect], ask) for effect in taken if effect not in effects}
    if not added and not away:
        return current
    trials = [trial for trial in trials_of(current, list(taken), {}) if trial.effect in added]
    outlook = Outlook(current, columns_of(current, trials, ask.bounds))
    chosen = []
    for name in added:
        offers = [outlook.proposal([trial], away, 0.0) for trial in outlook.columns if trial.effect == name]
        if not offers:
            raise UserError(f"{name}: the records do not show it at any plausible size, nor would a motion like theirs")
        chosen += list(max(offers, key=lambda offer: offer.gain).added)
    found = fitted_with(current, taken, outlook.proposal(chosen, away, 0.0), ask)
    return fit(found.balance, found.values, found.names, ask.bounds, AS_IT_IS, current.weighing)


def _hypothesis(evidence: Evidence, fitted: Fit, effects: tuple[str, ...]) -> Hypothesis:
    """A fit as a hypothesis; an effect that the records do not show is as large as they allow."""
    values = {name: value for name, value in fitted.values.items() if name not in NEUTRAL or name in fitted.names}
    hypothesis = Hypothesis(effects, values, fitted.unknowns, fitted.curvature)
    axis, covariance, shift = evidence.how.along.plant.axis, hypothesis.covariance, np.zeros(len(fitted.unknowns))
    for effect in effects:
        numbers = registered(axis)[effect].numbers
        own = [i for i, u in enumerate(fitted.unknowns) if u.name in numbers and not numbers[u.name].shapes]
        places = hypothesis.places[own] - _neutral(hypothesis, own)
        deviations = np.sqrt(np.maximum(np.diag(covariance)[own], 0.0))
        if own and np.all(np.abs(places) < SHOWN * deviations):
            k = int(np.argmax(np.abs(places) / np.maximum(deviations, 1e-300)))
            side = 1.0 if places[k] >= 0.0 else -1.0
            shift += covariance[:, own[k]] / deviations[k] * SHOWN * side
    return replace(hypothesis, values=hypothesis.moved(shift))


def _neutral(hypothesis: Hypothesis, own: Sequence[int]) -> np.ndarray:
    """Where these unknowns do nothing, as a search sees them."""
    values: Values = hypothesis.values
    places = []
    for i in own:
        unknown = hypothesis.unknowns[i]
        plain = unknown.name.removesuffix("_negative")
        neutral = values[plain] if plain != unknown.name else NEUTRAL.get(unknown.name, 0.0)
        places.append(0.0 if unknown.logarithmic and neutral <= 0.0 else unknown.place(neutral))
    return np.array(places)
