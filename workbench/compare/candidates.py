"""Who takes part in a comparison: a controller at one speed of rotation, with its errors over the plant samples.

A cell of the comparison is one machine, scenario and reference. Its candidates fall into four classes, by whether their
controller compensates and whether the rod turns. What hunts on any plant sample never wins. One hunting sample of many
says little of a share, though: whether it is more than `RARE` may be open, and then what rests on it is open too.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from workbench.compare.intervals import LEAST, Interval, interval_of_mean
from workbench.metrics.statistics import share_interval
from workbench.publish.words import plain_name

MM = 1e3

TOLD_SPEED = 0.02
"""A real speed of rotation is told where it differs from the command by more than this share."""

SOLVER_ERROR = {"rms_error_m": "solver_rms_error_m", "steady_state_max_error_m": "solver_error_m"}
"""The column that says what the integration may add to an error."""

RARE = 0.05
"""What hunts on no larger a share of all plants hunts rarely."""

HUNTS = "hunts"
"""The flaw of what hunts."""

Family = Literal["plain", "pressure", "friction model"]
Class = Literal["nothing", "compensate", "avoid", "both"]
CLASSES: tuple[Class, ...] = ("nothing", "compensate", "avoid", "both")
"""The simplest first: a plain controller at rest, a compensator at rest, a plain one rotating, a compensator so."""


class Cell(NamedTuple):
    """One field of the matrix."""

    machine: str
    scenario: str
    reference: str

    @property
    def words(self) -> str:
        """Scenario and reference in words."""
        return f"{plain_name(self.scenario)} {plain_name(self.reference)}"

    @property
    def whole_words(self) -> str:
        """The same with the machine, where there are several."""
        return f"{plain_name(self.machine)} {self.words}" if self.machine else self.words


class HuntingCount(NamedTuple):
    """On how many plant samples a candidate hunts in any reference that holds still, and of how many."""

    hunts: int
    samples: int

    @property
    def share(self) -> tuple[float, float]:
        """Between which shares of all plants that is."""
        return share_interval(self.hunts, self.samples)


NOWHERE_JUDGED = HuntingCount(0, 0)


@dataclass(frozen=True, eq=False)
class Candidate:
    """A controller at one speed of rotation, in one cell: a row of the results a plant sample, indexed by its number.

    `flaw` says why it cannot win; it is empty where it can.
    """

    controller: str
    rpm: float
    family: Family
    rows: pd.DataFrame
    error_column: str
    flaw: str
    hunting: HuntingCount = NOWHERE_JUDGED

    @property
    def rare(self) -> bool:
        """Whether hunting is its only flaw, and may be rare: its share is not surely above `RARE`."""
        known = not np.isnan(self.errors).any()
        return self.flaw == HUNTS and known and self.hunting.share[0] <= RARE

    @property
    def key(self) -> tuple[str, float]:
        """What tells it from the others of its cell: controller and rpm."""
        return self.controller, self.rpm

    @property
    def kind(self) -> Class:
        """Its class."""
        if self.family == "plain":
            return "avoid" if self.rpm > 0 else "nothing"
        return "both" if self.rpm > 0 else "compensate"

    @property
    def samples(self) -> int:
        """On how many plant samples it was run."""
        return len(self.rows)

    @cached_property
    def errors(self) -> NDArray[np.float64]:
        """Its error (m) on each plant sample."""
        return self.rows[self.error_column].to_numpy(float)

    @property
    def size(self) -> float:
        """The geometric mean of its errors (m); those too small to be told count as `LEAST`."""
        return float(np.exp(np.mean(np.log(np.maximum(self.errors, LEAST)))))

    def mean_error(self, probability: float) -> Interval:
        """The mean of its errors (m) with its interval of that `probability`: no error is below 0."""
        interval = interval_of_mean(self.errors, probability)
        return replace(interval, low=max(interval.low, 0.0))

    @property
    def solver_error(self) -> float:
        """What the integration adds to its error (m), the mean over the samples that tell; 0 where none does."""
        known = self.rows[SOLVER_ERROR[self.error_column]].dropna()
        return float(known.mean()) if len(known) else 0.0

    @property
    def paid_power(self) -> float:
        """Mean power (W) that pump and motor pay together."""
        return self._mean("paid_power_W")

    @property
    def pump_power(self) -> float:
        """Mean power (W) that the pump pays."""
        return self._mean("supply_power_W")

    @property
    def terminal_power(self) -> float:
        """Mean power (W) at the motor's terminals; NaN where nothing turns."""
        return self._mean("motor_electric_power_W")

    @property
    def motor_loss(self) -> float:
        """Mean power (W) that is lost between the terminals and the rod; NaN where no motor is modelled."""
        return self._mean("motor_loss_W")

    @property
    def motor_torque(self) -> float:
        """Mean of the rms torque (N m) of the motor; NaN where nothing turns."""
        return self._mean("motor_torque_rms_N_m")

    @property
    def real_rpm(self) -> float:
        """Mean real speed of rotation (rpm); NaN where nothing turns."""
        return self._mean("rotation_speed_mean_rpm")

    def _mean(self, column: str) -> float:
        """The mean of a metric over the plant samples on which it applies, NaN if on none."""
        return float(pd.to_numeric(self.rows[column]).mean())

    @property
    def words(self) -> str:
        """Its name: controller and speed, the real one too where it is another."""
        if self.rpm == 0:
            return f"{plain_name(self.controller)} at rest"
        return f"{plain_name(self.controller)} at {turning_words(self.rpm, self.real_rpm, ' rpm')}"


def turning_words(rpm: float, real: float, unit: str = "") -> str:
    """A commanded speed of rotation (rpm), with the real one where it is another."""
    off = rpm != 0 and abs(real - rpm) > TOLD_SPEED * rpm
    return f"{rpm:g}{unit}" + (f" (really {real:.3g})" if off else "")


def by_class(candidates: Iterable[Candidate]) -> Mapping[Class, list[Candidate]]:
    """The candidates of each class, those without a flaw in front, the least error first."""
    ranked = sorted(candidates, key=order)
    return {kind: [candidate for candidate in ranked if candidate.kind == kind] for kind in CLASSES}


def order(candidate: Candidate) -> tuple[int, float, float, str, float]:
    """The place of a candidate: the least error first, behind them those that hunt rarely, then all other flaws.

    Of errors too small to be told the smaller mean decides, and then the name: never the order of the study.
    """
    if candidate.flaw and not candidate.rare:
        return 2, 0.0, 0.0, *candidate.key
    return int(bool(candidate.flaw)), candidate.size, float(np.mean(candidate.errors)), *candidate.key


def sound(candidates: Iterable[Candidate]) -> Iterator[Candidate]:
    """Those that can win."""
    return (candidate for candidate in candidates if not candidate.flaw)
