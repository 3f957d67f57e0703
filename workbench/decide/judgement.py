"""What the runs say: of each candidate at each speed and spread, and which of them suffices there."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import pandas as pd

from workbench.metrics.statistics import quantile, quantile_interval, share_interval
from workbench.simulation.simulate import COMPLETED
from workbench.study.decide_schema import DecideTable

Kind = Literal["plain", "compensation", "rotation"]
"""Plain control of a rod at rest, friction compensation of one, any control of one that rotates."""

KINDS: tuple[Kind, ...] = ("plain", "compensation", "rotation")
"""From the simplest on: the first that suffices is the answer."""

ALIKE = 0.05
"""Powers that differ by less than this share are one power: which of them is less does not decide."""


@dataclass(frozen=True)
class Judged:
    """A candidate at a speed (m/s) and a spread (standard deviations of friction), over its draws.

    `met` draws keep to accuracy and power: the `probability`, within `low` and `high`. `error` is the quantile (m) of
    the error that [decide] asks for, infinite where too few runs complete, within `error_low` and `error_high`;
    `power` the same of power (W), and `mean_power`, of the runs that complete; NaN where none does.
    """

    controller: str
    rpm: float
    speed: float
    spread: float
    kind: Kind
    outcome: str
    passed: tuple[bool, ...]
    low: float
    high: float
    accurate: float
    within_power: float
    error: float
    error_low: float
    error_high: float
    mean_power: float
    power: float

    @property
    def draws(self) -> int:
        """How many machines it was run on."""
        return len(self.passed)

    @property
    def met(self) -> int:
        """On how many it keeps to accuracy and power."""
        return sum(self.passed)

    @property
    def probability(self) -> float:
        """The share of these."""
        return self.met / self.draws

    def excess(self, table: DecideTable) -> float:
        """The larger of error quantile over accuracy and power quantile over its limit; infinite without them."""
        ratios = (self.error / table.accuracy, self.power / table.power)
        return math.inf if any(math.isnan(ratio) for ratio in ratios) else max(ratios)

    def meets(self, table: DecideTable) -> bool:
        """Whether the share of draws that keep to both is what is asked for."""
        return self.probability >= table.probability

    def settled(self, table: DecideTable) -> bool:
        """Whether the probability that is asked for is outside the interval; a single machine leaves nothing open."""
        return self.draws == 1 or not self.low < table.probability < self.high


def judge(draws: pd.DataFrame, table: DecideTable) -> list[Judged]:
    """Of each candidate at each speed and spread what its draws say, in the order of the runs."""
    groups = draws.groupby(["controller", "rpm", "speed_m_per_s", "spread"], sort=False)
    return [_judged(group, table) for _, group in groups]


def _judged(group: pd.DataFrame, table: DecideTable) -> Judged:
    first = group.iloc[0]
    done = group["outcome"] == COMPLETED
    passed = tuple(bool(one) for one in group["meets_accuracy"] & group["meets_power"])
    errors = [float(one) for one in group["error_m"].where(done, math.inf)]
    powers = [float(one) for one in group["power_W"][done]]
    return Judged(
        str(first["controller"]),
        float(first["rpm"]),
        float(first["speed_m_per_s"]),
        float(first["spread"]),
        kind_of(str(first["controller"]), float(first["rpm"]), table),
        _outcomes(group),
        passed,
        *share_interval(sum(passed), len(passed)),
        float(group["meets_accuracy"].mean()),
        float(group["meets_power"].mean()),
        quantile(errors, table.probability),
        *quantile_interval(errors, table.probability),
        sum(powers) / len(powers) if powers else math.nan,
        quantile(powers, table.probability) if powers else math.nan,
    )


def kind_of(controller: str, rpm: float, table: DecideTable) -> Kind:
    """What a candidate is."""
    if rpm:
        return "rotation"
    return "plain" if controller in table.plain else "compensation"


def _outcomes(group: pd.DataFrame) -> str:
    """How the runs ended, in words."""
    counts = group["outcome"].value_counts()
    if list(counts.index) == [COMPLETED]:
        return COMPLETED
    return ", ".join(f"{count} {outcome}" for outcome, count in sorted(counts.items(), key=lambda item: str(item[0])))


def ordered(rows: Sequence[Judged], table: DecideTable) -> list[Judged]:
    """First those that meet what is asked, from the least power on; then the others, the nearest to it first.

    Of those with about one power, or about equally near (`ALIKE`), the one with the least error quantile comes first.
    """
    chosen = _by_size([row for row in rows if row.meets(table)], lambda row: row.mean_power)
    rest = [row for row in rows if not row.meets(table)]
    for probability in sorted({row.probability for row in rest}, reverse=True):
        chosen += _by_size([row for row in rest if row.probability == probability], lambda row: row.excess(table))
    return chosen


def _by_size(rows: Sequence[Judged], size: Callable[[Judged], float]) -> list[Judged]:
    """From the least size on; of those whose sizes are alike the one with the least error first."""
    left, chosen = sorted(rows, key=size), list[Judged]()
    while left:
        least = size(left[0])
        alike = [row for row in left if size(row) <= (1.0 + ALIKE) * least]
        chosen += sorted(alike, key=lambda row: row.error)
        left = left[len(alike) :]
    return chosen


def of_kind(rows: Sequence[Judged], kind: Kind, table: DecideTable) -> Judged | None:
    """The first of a kind in that order."""
    return next(iter(ordered([row for row in rows if row.kind == kind], table)), None)


@dataclass(frozen=True)
class Answer:
    """What suffices at a speed and a spread: the first of `KINDS` that does, with its `best`; None: nothing does.

    Where nothing does, `best` is the nearest. `settled`: more draws would not change it, as far as these tell.
    """

    kind: Kind | None
    best: Judged
    settled: bool


def answer(rows: Sequence[Judged], table: DecideTable) -> Answer:
    """The answer at one speed and spread, of whose candidates these are the rows."""
    for kind in KINDS:
        best = of_kind(rows, kind, table)
        if best is not None and best.meets(table):
            # A simpler kind that these draws do not rule out leaves the answer open too.
            simpler = [row for row in rows if KINDS.index(row.kind) < KINDS.index(kind)]
            return Answer(kind, best, all(row.settled(table) for row in (best, *simpler)))
    best = ordered(rows, table)[0]
    return Answer(None, best, all(row.settled(table) for row in rows))


def at(rows: Sequence[Judged], speed: float, spread: float) -> list[Judged]:
    """The candidates at a speed (m/s) and a spread."""
    return [row for row in rows if row.speed == speed and row.spread == spread]


def non_dominated(rows: Sequence[Judged]) -> list[Judged]:
    """From the least mean power on, those whose error quantile is below that of all that need less.

    Of those with about one power (`ALIKE`) the one with the least error stands for all; those without a finite error
    do not count.
    """
    left = sorted((row for row in rows if math.isfinite(row.error)), key=lambda row: row.mean_power)
    front: list[Judged] = []
    while left:
        alike = [row for row in left if row.mean_power <= (1.0 + ALIKE) * left[0].mean_power]
        left = left[len(alike) :]
        least = min(alike, key=lambda row: row.error)
        if not front or least.error < front[-1].error:
            front.append(least)
    return front


def results(rows: Sequence[Judged]) -> pd.DataFrame:
    """The rows of results.csv; what does not apply is empty."""
    return pd.DataFrame(
        [
            {
                "controller": row.controller,
                "rpm": row.rpm,
                "speed_m_per_s": row.speed,
                "spread": row.spread,
                "outcome": row.outcome,
                "draws": row.draws,
                "met": row.met,
                "probability": row.probability,
                "probability_low": row.low,
                "probability_high": row.high,
                "accuracy_share": row.accurate,
                "power_share": row.within_power,
                "error_quantile_m": _finite(row.error),
                "error_quantile_low_m": _finite(row.error_low),
                "error_quantile_high_m": _finite(row.error_high),
                "mean_power_W": _finite(row.mean_power),
                "power_quantile_W": _finite(row.power),
            }
            for row in rows
        ]
    )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
