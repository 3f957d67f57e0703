"""What `workbench identify` finds: both methods on the same records, and the corrected plant."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from workbench.identify.readiness import check_experiment, check_records
from workbench.identify.simulation.method import SimulationFit, identify_by_simulation
from workbench.identify.thesis.method import Estimate
from workbench.identify.thesis.records import ThesisFit, identify_by_thesis
from workbench.parameters.sets import known_units
from workbench.records.experiment import Experiment
from workbench.records.reading import Record, read_records
from workbench.records.schema import FRICTION


@dataclass(frozen=True)
class Identification:
    """An experiment with what each method found; None for a method that was not asked for."""

    experiment: Experiment
    records: list[Record]
    thesis: ThesisFit | None
    simulation: SimulationFit | None

    @property
    def names(self) -> list[str]:
        """Canonical names of all parameters that a method found or could not find, both directions apart."""
        found: dict[str, None] = {}
        for fit in (self.simulation, self.thesis):
            found |= dict.fromkeys(fit.estimates if fit is not None else ())
        if self.simulation is not None:
            found |= dict.fromkeys([*self.simulation.bounded, *self.simulation.unidentified])
        order = {name: i for i, name in enumerate(FRICTION)}
        return sorted(
            found, key=lambda name: (name.endswith("_negative"), order.get(name.removesuffix("_negative"), len(order)))
        )

    @property
    def corrected(self) -> Mapping[str, tuple[float, float | None, str]]:
        """Identified parameters by canonical name: value, standard deviation (SI) and where they are from."""
        count = len(self.records)
        where = f"identified from {count} record{'s' * (count > 1)} of {self.experiment.path.name}"
        if self.simulation is not None:
            fitted, bounded = self.simulation.estimates, self.simulation.bounded
            return {
                **{name: (one.value, one.std, f"{where}, by simulation error") for name, one in fitted.items()},
                **{
                    name: (value, None, f"{where}, by simulation error: {why}")
                    for name, (value, why) in bounded.items()
                },
            }
        if self.thesis is None:
            return {}
        return {
            name: (one.value, one.std if one.count > 1 else None, f"{where}, by the thesis's method")
            for name, one in self.thesis.estimates.items()
            if name not in self.thesis.unidentified
        }

    @property
    def values(self) -> dict[str, float]:
        """All parameters: the declared ones with what was identified."""
        return {**self.experiment.values, **{name: entry[0] for name, entry in self.corrected.items()}}


def identify(
    experiment: Experiment, method: str | None = None, progress: Callable[[str], None] | None = None
) -> Identification:
    """Identify the free parameters of an experiment from its fit records.

    `method` is "thesis", "simulation" or "both"; None: what the experiment says. `progress` is told in words what is
    being done.

    Raises:
        UserError: a record or the plant does not serve.
    """
    chosen = method or experiment.method
    check_experiment(experiment, chosen)
    if progress is not None:
        progress("reading the records")
    records = read_records(experiment)
    check_records(experiment, records, chosen)
    thesis = identify_by_thesis(experiment, records, progress) if chosen in ("thesis", "both") else None
    simulation = identify_by_simulation(experiment, records, progress) if chosen in ("simulation", "both") else None
    return Identification(experiment, records, thesis, simulation)


def as_data(found: Identification) -> dict[str, Any]:
    """The whole finding as plain data (SI), for identified.json."""
    experiment = found.experiment
    data: dict[str, Any] = {
        "title": experiment.title,
        "plant": experiment.plant.name,
        "declared": experiment.declared,
        "records": [
            {"file": record.path.name, "label": record.label, "rpm": record.rpm, "notes": list(record.notes)}
            for record in found.records
        ],
        "parameters": {name: _parameter(found, name) for name in found.names},
    }
    if found.thesis is not None:
        data["thesis"] = {
            "notes": list(found.thesis.notes),
            "unidentified": found.thesis.unidentified,
            "by_rpm": {
                f"{rpm:g}": {name: _estimate(one) for name, one in group.items()}
                for rpm, group in found.thesis.groups.items()
            },
        }
    if found.simulation is not None:
        fit = found.simulation
        data["simulation"] = {
            "unidentified": dict(fit.unidentified),
            "notes": list(fit.notes),
            "correlation": {"names": list(fit.estimates), "matrix": fit.correlation.tolist()},
            "sensors": {name: vars(one) for name, one in fit.sensors.items()},
            "rms": {"before": dict(fit.before), "after": dict(fit.rms)},
            "residual_memory_s": fit.memory,
            "evaluations": fit.evaluations,
        }
    return data


def _estimate(one: Estimate) -> dict[str, Any]:
    return {"mean": one.value, "std": one.std if one.count > 1 else None, "repeats": one.count}


def _parameter(found: Identification, name: str) -> dict[str, Any]:
    experiment = found.experiment
    plain = name.removesuffix("_negative")
    entry: dict[str, Any] = {
        "unit": known_units()[name],
        "declared": experiment.values.get(name, experiment.values.get(plain)),
    }
    if experiment.truth is not None:
        entry["truth"] = experiment.truth.get(name, experiment.truth.get(plain))
    if found.thesis is not None and name in found.thesis.estimates:
        one = found.thesis.estimates[name]
        entry["thesis"] = _estimate(one)
    if found.simulation is not None and name in found.simulation.estimates:
        entry["simulation"] = vars(found.simulation.estimates[name])
    if found.simulation is not None and name in found.simulation.bounded:
        entry["simulation"] = {"value": found.simulation.bounded[name][0], "at_bound": True}
    return entry
