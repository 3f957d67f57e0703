"""What an identification finds, whole when it is made; `Identification.to_json` is the content of identified.json."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

from workbench.identify.simulation.found import Fitted, SimulationFit
from workbench.identify.thesis.method import Estimate
from workbench.identify.thesis.records import ThesisFit
from workbench.parameters.sets import known_units
from workbench.records.experiment import Experiment
from workbench.records.reading import Record
from workbench.records.schema import FRICTION


@dataclass(frozen=True)
class Corrected:
    """An identified parameter (SI) for a corrected plant: its standard deviation, if it has one, and its source."""

    value: float
    std: float | None
    source: str


@dataclass(frozen=True)
class IdentifiedParameter:
    """A parameter (SI, `unit`) as declared, as it is in truth where that is known, and by each method.

    `bound` is its value where the fit by simulation stopped at a bound of the experiment; `refuted`: the records refute
    that fit, and of its values none is identified.
    """

    unit: str
    declared: float | None
    truth: float | None
    thesis: Estimate | None
    simulation: Fitted | None
    bound: float | None
    refuted: bool = False

    def to_json(self, *, has_truth: bool) -> dict[str, object]:
        """As identified.json holds it; `has_truth`: the experiment names a truth, though maybe not of this."""
        data: dict[str, object] = {"unit": self.unit, "declared": self.declared}
        if has_truth:
            data["truth"] = self.truth
        if self.thesis is not None:
            data["thesis"] = self.thesis.to_json()
        if self.bound is not None:
            data["simulation"] = {"value": self.bound, "at_bound": True}
        elif self.simulation is not None and self.refuted:
            data["simulation"] = {"value": self.simulation.value, "refuted": True}
        elif self.simulation is not None:
            data["simulation"] = asdict(self.simulation)
        return data


@dataclass(frozen=True)
class Identification:
    """An experiment with what each method found; None for a method that was not asked for."""

    experiment: Experiment
    records: Sequence[Record]
    thesis: ThesisFit | None
    simulation: SimulationFit | None

    @property
    def names(self) -> list[str]:
        """Canonical names of all parameters that a method found or could not find, both directions apart."""
        names: dict[str, None] = {}
        for fit in (self.simulation, self.thesis):
            names |= dict.fromkeys(fit.estimates if fit is not None else ())
        if self.simulation is not None:
            names |= dict.fromkeys([*self.simulation.bounded, *self.simulation.unidentified])
        order = {name: i for i, name in enumerate(FRICTION)}
        return sorted(
            names, key=lambda name: (name.endswith("_negative"), order.get(name.removesuffix("_negative"), len(order)))
        )

    @property
    def refuted(self) -> str:
        """How much more than noise the fit by simulation leaves, where the records refute it; else ""."""
        return "" if self.simulation is None else self.simulation.refuted

    @property
    def parameters(self) -> dict[str, IdentifiedParameter]:
        """All of `names` with what is known of each."""
        return {name: self._parameter(name) for name in self.names}

    def _parameter(self, name: str) -> IdentifiedParameter:
        """One parameter; a direction that is not declared apart has the value of both."""
        experiment, thesis, simulation = self.experiment, self.thesis, self.simulation
        plain, truth = name.removesuffix("_negative"), experiment.truth or {}
        bound = None if simulation is None else simulation.bounded.get(name)
        return IdentifiedParameter(
            unit=known_units(experiment.plant.axis)[name],
            declared=experiment.values.get(name, experiment.values.get(plain)),
            truth=truth.get(name, truth.get(plain)),
            thesis=None if thesis is None else thesis.estimates.get(name),
            simulation=None if simulation is None else simulation.estimates.get(name),
            bound=None if bound is None else bound[0],
            refuted=bool(self.refuted),
        )

    @property
    def corrected(self) -> Mapping[str, Corrected]:
        """Identified parameters by canonical name."""
        count = len(self.records)
        where = f"identified from {count} record{'s' * (count > 1)} of {self.experiment.path.name}"
        if self.simulation is not None:
            by = f"{where}, by simulation error"
            if self.refuted:
                by = f"not identified: {self.refuted}; {by.removeprefix('identified ')}"
            fitted = {name: Corrected(fit.value, fit.std, by) for name, fit in self.simulation.estimates.items()}
            bounded = self.simulation.bounded.items()
            return fitted | {name: Corrected(value, None, f"{by}: {why}") for name, (value, why) in bounded}
        if self.thesis is None:
            return {}
        return {
            name: Corrected(estimate.value, estimate.std_of_repeats, f"{where}, by the thesis's method")
            for name, estimate in self.thesis.estimates.items()
            if name not in self.thesis.unidentified
        }

    @property
    def values(self) -> dict[str, float]:
        """All parameters: the declared ones with what was identified."""
        return {**self.experiment.values, **{name: entry.value for name, entry in self.corrected.items()}}

    def to_json(self) -> dict[str, object]:
        """The content of identified.json (SI)."""
        experiment = self.experiment
        data: dict[str, object] = {
            "title": experiment.title,
            "plant": experiment.plant.name,
            "declared": experiment.declared,
            "records": [
                {"file": record.path.name, "label": record.name, "rpm": record.rpm, "notes": list(record.notes)}
                for record in self.records
            ],
            "parameters": {
                name: parameter.to_json(has_truth=experiment.truth is not None)
                for name, parameter in self.parameters.items()
            },
        }
        if self.thesis is not None:
            data["thesis"] = self.thesis.to_json()
        if self.simulation is not None:
            data["simulation"] = self.simulation.to_json()
        return data
