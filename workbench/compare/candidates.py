"""Who takes part in a comparison: a controller at one speed of rotation, with its errors over the draws.

A cell of the comparison is one machine, scenario and reference. Its candidates fall into four classes, by whether their
controller compensates and whether the rod turns. What hunts in any draw never wins. One hunting draw of many says
little of a share, though: whether it is more than `RARE` may be open, and then what rests on it is open too.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from workbench.compare.intervals import LEAST
from workbench.compare.schema import ComparisonTable
from workbench.metrics.limit_cycle import HUNTING
from workbench.metrics.statistics import share_interval
from workbench.publish.words import plain_name
from workbench.simulation.run import COMPLETED

MM = 1e3

TOLD_SPEED = 0.02
"""A real speed of rotation is told where it differs from the command by more than this share."""

SOLVER_ERROR = {"rms_error_m": "solver_rms_error_m", "steady_state_max_error_m": "solver_error_m"}
"""The column that says what the integration may add to an error."""

RARE = 0.05
"""What hunts on no larger a share of the machines hunts rarely."""

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


@dataclass(frozen=True, eq=False)
class Candidate:
    """A controller at one speed of rotation, in one cell: a row of the results a draw, indexed by draw.

    `flaw` says why it cannot win; it is empty where it can. `hunting`: on how many draws it hunts in any reference that
    holds still, and of how many.
    """

    controller: str
    rpm: float
    family: Family
    rows: pd.DataFrame
    error_column: str
    flaw: str
    hunting: tuple[int, int] = (0, 0)

    @property
    def rare(self) -> bool:
        """Whether hunting is its only flaw, and may be rare: its share is not surely above `RARE`."""
        known = not np.isnan(self.errors).any()
        return self.flaw == HUNTS and known and share_interval(*self.hunting)[0] <= RARE

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

    @cached_property
    def errors(self) -> NDArray[np.float64]:
        """Its error (m) on each draw."""
        return self.rows[self.error_column].to_numpy(float)

    @property
    def size(self) -> float:
        """The geometric mean of its errors (m); those too small to be told count as `LEAST`."""
        return float(np.exp(np.mean(np.log(np.maximum(self.errors, LEAST)))))

    @property
    def solver_error(self) -> float:
        """What the integration adds to its error (m), the mean over the draws that tell; 0 where none does."""
        known = self.rows[SOLVER_ERROR[self.error_column]].dropna()
        return float(known.mean()) if len(known) else 0.0

    @property
    def paid(self) -> float:
        """Mean power (W) that pump and motor pay together."""
        return self.mean("paid_power_W")

    def mean(self, column: str) -> float:
        """The mean of a figure over the draws in which it applies, NaN if in none."""
        return float(pd.to_numeric(self.rows[column]).mean())

    @property
    def words(self) -> str:
        """Its name: controller and speed, the real one too where it is another."""
        if self.rpm == 0:
            return f"{plain_name(self.controller)} at rest"
        real = self.mean("rotation_speed_mean_rpm")
        said = f" (really {real:.3g})" if abs(real - self.rpm) > TOLD_SPEED * self.rpm else ""
        return f"{plain_name(self.controller)} at {self.rpm:g} rpm{said}"


def error_column(spec: ComparisonTable, reference: str) -> str:
    """What counts as the error of a reference: the largest at the end of a dwell for steps, the rms error of motion."""
    return "steady_state_max_error_m" if reference in spec.steps else "rms_error_m"


def family_of(spec: ComparisonTable, controller: str) -> Family:
    """The family of a controller."""
    return "plain" if controller in spec.plain else "pressure" if controller in spec.pressure else "friction model"


def with_all_axes(frame: pd.DataFrame) -> pd.DataFrame:
    """The results with a column for each axis of a comparison: one machine, scenario or draw where there is no axis."""
    filled: dict[str, str | int] = {"machine": "", "scenario": "nominal", "draw": 1}
    for name, value in filled.items():
        if name not in frame:
            frame = frame.assign(**{name: value})
    return frame


def of_tuned(spec: ComparisonTable, frame: pd.DataFrame) -> pd.DataFrame:
    """The results without controllers whose gains are those before."""
    return frame[~frame["controller"].isin(list(spec.before.values()))]


def cells_of(spec: ComparisonTable, frame: pd.DataFrame) -> dict[Cell, list[Candidate]]:
    """The candidates of each cell, in the order of the results."""
    frame = with_all_axes(frame)
    hunting = hunting_draws(frame)
    found: dict[Cell, list[Candidate]] = {}
    names = ["machine", "scenario", "reference", "controller", "rpm"]
    for key, rows in frame.set_index("draw").sort_index(kind="stable").groupby(names, sort=False):
        machine, scenario, reference, controller = map(str, key[:-1])
        rpm = float(str(key[-1]))
        column = error_column(spec, reference)
        hunts = hunting.get((machine, scenario, controller, rpm), (0, 0))
        flaw = _flaw(rows, column, hunts[0] > 0)
        candidate = Candidate(controller, rpm, family_of(spec, controller), rows, column, flaw, hunts)
        found.setdefault(Cell(machine, scenario, reference), []).append(candidate)
    return found


def hunting_draws(frame: pd.DataFrame) -> dict[tuple[str, str, str, float], tuple[int, int]]:
    """By machine, scenario, controller and rpm, on how many draws it hunts in any reference that holds still, of how
    many; none for what is judged nowhere.
    """
    judged = frame.dropna(subset=["limit_cycle"])
    names = ["machine", "scenario", "controller", "rpm"]
    hunts = judged["limit_cycle"].isin(HUNTING).groupby([judged[name] for name in (*names, "draw")]).any()
    counts = hunts.groupby(level=names).agg(["sum", "size"])
    return {key: (int(count), int(of)) for key, count, of in counts.itertuples(name=None)}


def _flaw(rows: pd.DataFrame, error: str, hunts: bool) -> str:
    """Why a candidate cannot win; empty if it can. What does not complete has that flaw, whether it hunts or not."""
    unusual = [outcome for outcome in rows["outcome"].to_numpy() if outcome != COMPLETED]
    if unusual:
        return str(unusual[0])
    if hunts:
        return HUNTS
    return "has no error" if np.isnan(rows[error].to_numpy(float)).any() else ""


def by_class(candidates: list[Candidate]) -> Mapping[Class, list[Candidate]]:
    """The candidates of each class, those without a flaw in front, the least error first."""
    return {kind: sorted((one for one in candidates if one.kind == kind), key=order) for kind in CLASSES}


def order(one: Candidate) -> tuple[int, float, float, str, float]:
    """The place of a candidate: the least error first, behind them those that hunt rarely, then all other flaws.

    Of errors too small to be told the smaller mean decides, and then the name: never the order of the study.
    """
    if one.flaw and not one.rare:
        return 2, 0.0, 0.0, *one.key
    return int(bool(one.flaw)), one.size, float(np.mean(one.errors)), *one.key


def sound(candidates: Iterable[Candidate]) -> Iterator[Candidate]:
    """Those that can win."""
    return (one for one in candidates if not one.flaw)
