"""What a diagnosis finds, whole when it is made, in SI; `Diagnosis.to_json` is the content of report.json."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from plants.axis import LINEAR, name_along
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.selection.selection import BalanceResult
from workbench.diagnose.selection.unexplained import Unexplained
from workbench.diagnose.simulation.stage import SimulationStage
from workbench.parameters.sets import known_units
from workbench.records.experiment import Experiment

IDENTIFIED = 0.5
"""Standard deviation over value below which a parameter is identified."""

WORSE = 1.02
"""Error of a balance, after over before, beyond which what was found is rejected."""

BETTER = 0.5
"""Error of a free run of held-out records, after over before, below which it speaks for what was found, whatever a
balance shows."""

ENDED = "the fit ran to the end of its range"
VAGUE = "the standard deviation exceeds half the value"
MISLED = "what was found moves the value beyond what its standard deviation allows"
MAKES_UP = "it makes up for what is missing"
"""Why a parameter is not identified."""

BALANCE_ERRORS = {
    ("force", "N"): "force_rms_N",
    ("force", "N m"): "torque_rms_N_m",
    ("flow", "m^3/s"): "flow_rms_m3_per_s",
    ("flow", "kg/s"): "flow_rms_kg_per_s",
    ("rotation", "N m"): "rotation_rms_N_m",
    ("motor", "V"): "motor_rms_V",
    ("velocity", "m/s"): "velocity_rms_m_per_s",
}
"""What the errors of our plants' balances are called in report.json, by name and unit of the balance."""


def error_of(balance: str, unit: str) -> str:
    """What the error of a balance is called in report.json; of one that another package brings, in its own unit."""
    return BALANCE_ERRORS.get((balance, unit), f"{balance}_rms")


Verdict = Literal["rejected_on_held_out", "ambiguous", "effect_found", "unexplained", "undecided", "none_missing"]

FAR = 3.0
"""Floors beyond which a residual is not called explained, whatever the verdict."""


class Estimate(NamedTuple):
    """A number with its standard deviation (SI)."""

    value: float
    std: float

    @property
    def is_known(self) -> bool:
        """Whether the deviation is small against the value."""
        return self.std < IDENTIFIED * abs(self.value)


@dataclass(frozen=True)
class Evidence:
    """What speaks for an effect; None where it does not apply.

    `left_out_gain` is the share by which it lowers the residual on data left out, `standard_errors` how sure that is;
    `correlation_with_speed` that of the pressure on which it depends; `explained` the share of what the simulated plant
    was off by beyond noise. Of a sensor's offset: rms of the pressures' sum (Pa), `sum_rms`, and what one constant
    leaves of it, `left_rms`.
    """

    left_out_gain: float | None = None
    standard_errors: float | None = None
    correlation_with_speed: float | None = None
    explained: float | None = None
    sum_rms: float | None = None
    left_rms: float | None = None

    def to_json(self) -> dict[str, object]:
        """As report.json holds it: what there is, with units in the names."""
        whole = {f"{name}_Pa" if name.endswith("_rms") else name: value for name, value in asdict(self).items()}
        return {name: value for name, value in whole.items() if value is not None}


@dataclass(frozen=True)
class FoundEffect:
    """An effect that was found: on which balance, its parameters, what it may be instead, what a reader has to know."""

    name: str
    balance: str
    parameters: Mapping[str, Estimate]
    alternatives: Sequence[str]
    evidence: Evidence
    remarks: Sequence[str] = ()

    def to_json(self, axis: str) -> dict[str, object]:
        """As report.json holds it, of a plant along that axis."""
        units = known_units(axis)
        return {
            "name": self.name,
            "balance": name_along(self.balance, axis),
            "parameters": {
                name: {"value": number.value, "unit": units.get(name, "1"), "std": number.std}
                for name, number in self.parameters.items()
            },
            "alternatives": list(self.alternatives),
            "evidence": {**self.evidence.to_json(), **({"remarks": list(self.remarks)} if self.remarks else {})},
        }


@dataclass(frozen=True)
class FittedParameter:
    """A parameter that a fit moved: value and standard deviation (SI), and why the records do not identify it, empty
    where they do.
    """

    value: float
    std: float
    doubt: str = ""

    @classmethod
    def of(cls, number: Estimate, *, ended: bool = False, far: bool = False) -> "FittedParameter":
        """A number that a fit gives, which `ended` at an end of its range or not, and may be `far` from its records."""
        doubts = {VAGUE: not number.is_known, ENDED: ended, MAKES_UP: far}
        return cls(number.value, number.std, next((doubt for doubt, applies in doubts.items() if applies), ""))

    @property
    def identified(self) -> bool:
        """Whether the records identify it."""
        return not self.doubt

    def to_json(self, unit: str) -> dict[str, object]:
        """As report.json holds it."""
        return {"value": self.value, "unit": unit, "std": self.std, "identified": self.identified}


@dataclass(frozen=True, eq=False)
class Errors:
    """Rms errors (SI) of one model on some records: residual of each balance by name, speed of a pump on plateaus,
    position and load pressure of a free run; None where the records show none. `units` are those of the balances;
    `shown` is what the sensors would have shown in the free run of the first record, empty where none was made.
    """

    balances: Mapping[str, float]
    pump_speed: float | None = None
    position: float | None = None
    load_pressure: float | None = None
    axis: str = LINEAR
    units: Mapping[str, str] = field(default_factory=dict)
    shown: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def by_key(self) -> dict[str, float]:
        """Those that there are, by their names in report.json."""
        whole = {
            **{error_of(name, self.units.get(name, "")): rms for name, rms in self.balances.items()},
            "pump_speed_rms_rad_per_s": self.pump_speed,
            f"position_rms_{self.axis}": self.position,
            "load_pressure_rms_Pa": self.load_pressure,
        }
        return {name: rms for name, rms in whole.items() if rms is not None}


@dataclass(frozen=True)
class BeforeAfter:
    """Errors of the fitted baseline, and of the plant with what was found."""

    before: Errors
    after: Errors

    def to_json(self) -> dict[str, object]:
        """As report.json holds them."""
        return {"before": self.before.by_key, "after": self.after.by_key}


@dataclass(frozen=True)
class ErrorsByUse:
    """Errors on the records that were fitted and on those that were held out.

    `own_parameters` are those on held-out records with the same parameters fitted to these, which nothing that differs
    between records is in, `gained` is by how much the logarithm of these records' likelihood rises with what was found;
    None where that was not asked. Where the parameters by which the plant ran freely are of free runs alone, `written`
    are the errors of free runs, of the records that were fitted and of those that were held out, with the parameters
    that are written. `with_curve` are those of free runs with a curve that is switched on for what no effect explains.
    """

    fit: BeforeAfter
    held_out: BeforeAfter
    own_parameters: BeforeAfter | None = None
    gained: float | None = None
    written: tuple[BeforeAfter, BeforeAfter] | None = None
    with_curve: tuple[Errors, Errors] | None = None

    def is_worse(self, balances: Sequence[str]) -> bool:
        """Whether one of these balances of the held-out records has a larger error with what was found."""
        before, after = self.held_out.before.balances, self.held_out.after.balances
        return any(after[name] > WORSE * before[name] for name in balances if name in before)

    @property
    def runs_worse(self) -> bool:
        """Whether a free run of the held-out records has a larger error of position with what was found, and noise does
        not tell why.
        """
        before, after = self.held_out.before.position, self.held_out.after.position
        if self.gained is not None and self.gained > 0.0:
            return False
        return after is not None and before is not None and after > WORSE * before

    @property
    def runs_better(self) -> bool:
        """Whether a free run of the held-out records has a far smaller error of position with what was found."""
        before, after = self.held_out.before.position, self.held_out.after.position
        return after is not None and before is not None and after < BETTER * before

    def to_json(self) -> dict[str, object]:
        """As report.json holds them."""
        own = {} if self.own_parameters is None else {"own_parameters": self.own_parameters.to_json()}
        gained = {} if self.gained is None else {"gained_log_likelihood": self.gained}
        runs = [dict[str, object](), dict[str, object]()]
        if self.written is not None:
            runs = [{"parameters_written": one.to_json()} for one in self.written]
        if self.with_curve is not None:
            runs = [{"with_curve": one.by_key} for one in self.with_curve]
        fitted, tested = runs
        return {
            "fit": {**self.fit.to_json(), **fitted},
            "held_out": {**self.held_out.to_json(), **own, **gained, **tested},
        }


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """All that a diagnosis finds.

    `baseline` and `corrected` are the parameters, without and with effects, that fit the balances; those that fit the
    simulated plant are in `simulation`, if the records can be simulated. `baseline_parameters` and `fitted_parameters`
    are those that count, of the simulated plant where it is trusted.
    """

    experiment: Experiment
    held_out: Sequence[Motion]
    results: Sequence[BalanceResult]
    simulation: SimulationStage | None
    effects: Sequence[FoundEffect]
    unexplained: Unexplained | None
    errors: ErrorsByUse
    declared: Values
    baseline: Values
    corrected: Values
    baseline_parameters: Mapping[str, FittedParameter]
    fitted_parameters: Mapping[str, FittedParameter]

    @property
    def verdict(self) -> Verdict:
        """The first of these that applies."""
        if self.is_rejected:
            return "rejected_on_held_out"
        if any(effect.alternatives for effect in self.effects):
            return "ambiguous"
        if self.effects:
            return "effect_found"
        if self.unexplained is not None:
            return "unexplained"
        return "none_missing" if self.follows else "undecided"

    @property
    def follows(self) -> bool:
        """Whether the plant follows its records near to noise: simulated, or in the balances where it cannot be; one
        that follows pieces of them alone within noise, since what adds up beyond them does not show.
        """
        if self.simulation is not None:
            whole = self.simulation.starts_anew_every is None
            return self.simulation.is_trusted if whole else self.simulation.follows
        return all(result.after.rms <= FAR for result in self.results)

    @property
    def axis(self) -> str:
        """Unit of the positions of the plant, "m" or "rad"."""
        return self.experiment.plant.axis

    @property
    def is_rejected(self) -> bool:
        """Whether what was found makes held-out records worse: then the plant stays as declared.

        It is the free run that counts, and the balances that have effects, too, where the simulated plant is not
        trusted and its free run not far better: one sums up all that acts, a balance shows most of it at break-aways.
        """
        if not self.effects:
            return False
        trusted = self.simulation is not None and self.simulation.is_trusted
        balances = [] if trusted else [result.balance.name for result in self.results if result.effects]
        return self.errors.runs_worse or (self.errors.is_worse(balances) and not self.errors.runs_better)

    @property
    def rounds(self) -> list[BalanceResult]:
        """Where effects competed: the balances, and the simulated plant."""
        return [*self.results, *([self.simulation.result] if self.simulation is not None else [])]

    def to_json(self) -> dict[str, object]:
        """The content of report.json: numbers, text, lists and dictionaries, null for what is not finite."""
        units = known_units(self.axis)
        floors = {
            name_along(result.balance.name, self.axis): {
                "value": result.balance.floor,
                "unit": result.balance.unit,
                "spread": result.balance.spread,
                "before": result.before.rms,
                "after": result.after.rms,
            }
            for result in self.results
        }
        fits = {
            key: {name: fitted.to_json(units.get(name, "1")) for name, fitted in parameters.items()}
            for key, parameters in (("baseline", self.baseline_parameters), ("fitted", self.fitted_parameters))
        }
        data = {
            "title": self.experiment.title,
            "experiment": self.experiment.path.as_posix(),
            "verdict": self.verdict,
            "effects": [effect.to_json(self.axis) for effect in self.effects],
            "unexplained": None if self.unexplained is None else self.unexplained.to_json(),
            "error": self.errors.to_json(),
            "floor": floors,
            "simulation": None if self.simulation is None else self.simulation.to_json(),
            **fits,
        }
        return {key: _plain(value) for key, value in data.items()}


def _plain(data: object) -> object:
    """Data as JSON holds it: no NumPy scalars, null in the place of what is not finite."""
    if isinstance(data, Mapping):
        return {str(key): _plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_plain(value) for value in data]
    if isinstance(data, np.generic):
        data = data.item()
    return None if isinstance(data, float) and not math.isfinite(data) else data
