"""The result of a candidate at a speed and a spread: how often it keeps to what is asked, and what fails."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import pandas as pd

from workbench.decide.plan import Candidate, Stage
from workbench.decide.schema import MOTOR, PUMP, REAL_SPEED, DecideTable
from workbench.metrics.statistics import SURE, quantile, quantile_interval, share_interval
from workbench.simulation.simulate import COMPLETED

Kind = Literal["plain", "compensation", "rotation", "both"]
"""Plain control of a rod at rest, compensation of its friction, plain control of one that rotates, both together."""

KINDS: tuple[Kind, ...] = ("plain", "compensation", "rotation", "both")
"""From the simplest on: the first that suffices is the answer."""

Standing = Literal["meets", "fails", "open"]
"""Whether the interval of the probability is above what is asked, below it, or holds it: cannot be told."""

HUNTING, ACCURACY, POWER, BOTH = "hunting", "accuracy", "power", "accuracy and power"


@dataclass(frozen=True)
class CandidateResult:
    """A candidate at a speed (m/s) and a spread (standard deviations of friction), over the draws of a stage.

    On `met` of them it keeps to accuracy and power without hunting: the `probability`, within `low` and `high` with a
    probability of `sure`. `failures` says by word on how many draws what fails. `error` is the quantile (m) of the
    error that [decide] asks for, infinite where too few runs complete, within `error_low` and `error_high`; `power` the
    same of power (W), `mean_power` of the runs that complete, of which the pump takes `pump` and the motor's terminals
    `motor` (W), and whose rod really turns at `real_rpm`; NaN where none does. `hunting`: draws on which it hunts while
    a step is held.
    """

    controller: str
    rpm: float
    speed: float
    spread: float
    kind: Kind
    stage: Stage
    outcome: str
    passed: tuple[bool, ...]
    failures: Mapping[str, int]
    hunting: int
    sure: float
    low: float
    high: float
    accurate: float
    within_power: float
    error: float
    error_low: float
    error_high: float
    mean_power: float
    power: float
    pump: float
    motor: float
    real_rpm: float

    @property
    def candidate(self) -> Candidate:
        """Its controller and rpm."""
        return self.controller, self.rpm

    @property
    def draws(self) -> int:
        """How many machines it was run on."""
        return len(self.passed)

    @property
    def met(self) -> int:
        """On how many it does what is asked."""
        return sum(self.passed)

    @property
    def probability(self) -> float:
        """The share of these."""
        return self.met / self.draws

    def excess(self, table: DecideTable) -> float:
        """The larger of error quantile over accuracy and power quantile over its limit; infinite without them."""
        ratios = (self.error / table.accuracy, self.power / table.power)
        return math.inf if any(math.isnan(ratio) for ratio in ratios) else max(ratios)

    def seems_to_meet(self, table: DecideTable) -> bool:
        """Whether the share of its draws is what is asked for; what hunts on one of them does not."""
        return not self.hunting and self.probability >= table.probability

    def standing(self, table: DecideTable) -> Standing:
        """What its draws tell; what hunts on one of them fails."""
        if self.hunting or self.high < table.probability:
            return "fails"
        return "meets" if self.low > table.probability else "open"

    def to_json(self, table: DecideTable) -> dict[str, object]:
        """As JSON holds it, under the names of results.csv; what is not finite is None."""
        numbers = {
            "probability": self.probability,
            "probability_low": self.low,
            "probability_high": self.high,
            "error_quantile_m": self.error,
            "mean_power_W": self.mean_power,
            "power_quantile_W": self.power,
        }
        return {
            "controller": self.controller,
            "rpm": self.rpm,
            "kind": self.kind,
            "stage": self.stage,
            "draws": self.draws,
            "met": self.met,
            "standing": self.standing(table),
            "fails_by": self.main_failure,
            **{name: value if math.isfinite(value) else None for name, value in numbers.items()},
        }

    @property
    def main_failure(self) -> str | None:
        """What fails on most draws; None where nothing does. Hunting comes first: it rules out by itself."""
        if self.hunting:
            return HUNTING
        return max(self.failures, key=lambda word: self.failures[word]) if self.failures else None


def candidate_results(draws: pd.DataFrame, table: DecideTable, sure: float = SURE) -> list[CandidateResult]:
    """Of each candidate at each speed and spread what its draws of one stage say, in the order of the runs."""
    groups = draws.groupby(["controller", "rpm", "speed_m_per_s", "spread"], sort=False)
    return [_result(group, table, sure) for _, group in groups]


def _result(group: pd.DataFrame, table: DecideTable, sure: float) -> CandidateResult:
    first = group.iloc[0]
    done = group["outcome"] == COMPLETED
    words = [_failure(*row) for row in zip(*(group[name] for name in _TOLD), strict=True)]
    passed = tuple(word is None for word in words)
    errors = [float(value) for value in group["error_m"].where(done, math.inf)]
    powers = [float(value) for value in group["power_W"][done]]
    low, high = _interval(passed, sure)
    error_low, error_high = quantile_interval(errors, table.probability)
    controller, rpm = str(first["controller"]), float(first["rpm"])
    return CandidateResult(
        controller=controller,
        rpm=rpm,
        speed=float(first["speed_m_per_s"]),
        spread=float(first["spread"]),
        kind=kind_of(controller, rpm, table),
        stage=first["stage"],
        outcome=_outcomes(group),
        passed=passed,
        failures=dict(Counter(word for word in words if word is not None)),
        hunting=int(group["hunts"].sum()),
        sure=sure,
        low=low,
        high=high,
        accurate=float(group["meets_accuracy"].mean()),
        within_power=float(group["meets_power"].mean()),
        error=quantile(errors, table.probability),
        error_low=error_low,
        error_high=error_high,
        mean_power=_mean(powers),
        power=quantile(powers, table.probability) if powers else math.nan,
        pump=_mean(group[PUMP][done].dropna()),
        motor=_mean(group[MOTOR][done].dropna()),
        real_rpm=_mean(group[REAL_SPEED][done].dropna()),
    )


def _interval(passed: Sequence[bool], sure: float) -> tuple[float, float]:
    """Where the share of all machines is; of a single machine, which is all there are, the share itself."""
    if len(passed) == 1:
        return float(passed[0]), float(passed[0])
    return share_interval(sum(passed), len(passed), sure)


def _mean(values: Sequence[float] | pd.Series) -> float:
    return float(sum(values) / len(values)) if len(values) else math.nan


_TOLD = ("outcome", "meets_accuracy", "meets_power", "hunts")


def _failure(outcome: str, accurate: bool, within_power: bool, hunts: bool) -> str | None:
    """Why a run does not do what is asked, in a word; None where it does."""
    if outcome != COMPLETED:
        return outcome
    if hunts:
        return HUNTING
    if accurate:
        return None if within_power else POWER
    return ACCURACY if within_power else BOTH


def kind_of(controller: str, rpm: float, table: DecideTable) -> Kind:
    """What a candidate is."""
    plain = controller in table.plain
    if rpm:
        return "rotation" if plain else "both"
    return "plain" if plain else "compensation"


def _outcomes(group: pd.DataFrame) -> str:
    """How the runs ended, in words."""
    counts = group["outcome"].value_counts()
    if list(counts.index) == [COMPLETED]:
        return COMPLETED
    return ", ".join(f"{count} {outcome}" for outcome, count in sorted(counts.items(), key=lambda item: str(item[0])))
