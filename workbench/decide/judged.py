"""What the runs say of a candidate at a speed and a spread: how often it keeps to what is asked, and what fails."""

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
class Judged:
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

    @property
    def main_failure(self) -> str | None:
        """What fails on most draws; None where nothing does. Hunting comes first: it rules out by itself."""
        if self.hunting:
            return HUNTING
        return max(self.failures, key=lambda word: self.failures[word]) if self.failures else None


def judge(draws: pd.DataFrame, table: DecideTable, sure: float = SURE) -> list[Judged]:
    """Of each candidate at each speed and spread what its draws of one stage say, in the order of the runs."""
    groups = draws.groupby(["controller", "rpm", "speed_m_per_s", "spread"], sort=False)
    return [_judged(group, table, sure) for _, group in groups]


def _judged(group: pd.DataFrame, table: DecideTable, sure: float) -> Judged:
    first = group.iloc[0]
    done = group["outcome"] == COMPLETED
    words = [_failure(*row) for row in zip(*(group[name] for name in _TOLD), strict=True)]
    passed = tuple(word is None for word in words)
    errors = [float(one) for one in group["error_m"].where(done, math.inf)]
    powers = [float(one) for one in group["power_W"][done]]
    return Judged(
        str(first["controller"]),
        float(first["rpm"]),
        float(first["speed_m_per_s"]),
        float(first["spread"]),
        kind_of(str(first["controller"]), float(first["rpm"]), table),
        first["stage"],
        _outcomes(group),
        passed,
        dict(Counter(word for word in words if word is not None)),
        int(group["hunts"].sum()),
        sure,
        *_interval(passed, sure),
        float(group["meets_accuracy"].mean()),
        float(group["meets_power"].mean()),
        quantile(errors, table.probability),
        *quantile_interval(errors, table.probability),
        _mean(powers),
        quantile(powers, table.probability) if powers else math.nan,
        _mean(group[PUMP][done].dropna()),
        _mean(group[MOTOR][done].dropna()),
        _mean(group[REAL_SPEED][done].dropna()),
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
