"""What a diagnosis says and has: its report, its plant along its records, and the noise that this leaves."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workbench.diagnose.readiness import check_experiment, declared_values, motions_of
from workbench.diagnose.report.folder import RESULT
from workbench.diagnose.residuals.fit import Fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.weighing import Whitening
from workbench.diagnose.simulation.fits import Fitting, exactly
from workbench.diagnose.simulation.setup import as_simulated, shooting_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.errors import UserError
from workbench.progress import Progress
from workbench.records.experiment import Experiment, read_experiment
from workbench.records.reading import read_records


@dataclass(frozen=True, eq=False)
class Reported:
    """What report.json of a diagnosis says: the experiment, effects with their numbers (SI) and what each may be
    instead, fitted parameters with and without them, those that are not identified, and whether a voltage held.
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
        raise UserError(
            f"{folder}: is no diagnosis: it holds no {RESULT}; expected a folder of workbench diagnose"
        ) from None
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
    if how is None or how.is_beside:
        raise UserError(
            f"{experiment.path}: no channel is the plant's {experiment.plant.command}: what moves by hand has no "
            "motion that could be designed"
        )
    known = how.along.parameter_names
    found = {name: value for own in reported.effects.values() for name, value in own.items() if name in known}
    values = {**declared_values(experiment), **reported.baseline, **reported.fitted, **found}
    names = [name for name in [*reported.baseline, *found] if name in known]
    fitting = Fitting(motions, list(dict.fromkeys(names)), experiment.bounds)
    progress("the diagnosed plant along its records", 0.02)
    best = exactly(fitting.final(fitting.begun(how, values)), fitting)
    return Evidence(motions, best.how, best.fit)
