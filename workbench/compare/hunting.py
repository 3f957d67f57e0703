"""Who hunts where, by the rows of results."""

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from workbench.compare.candidates import Cell
from workbench.metrics.limit_cycle import HUNTING


@dataclass(frozen=True)
class Hunter:
    """A controller that hunts: at which speeds (rpm), at which it does not, and how far (m, peak to peak) at most; NaN
    where that is not known.
    """

    controller: str
    speeds: Sequence[float]
    quiet: Sequence[float]
    amplitude: float


@dataclass(frozen=True)
class HuntingPlace:
    """A machine in a scenario: on how many of the cases that hold still somebody hunts, and who."""

    machine: str
    scenario: str
    hunting: int
    cases: int
    hunters: Sequence[Hunter]

    @property
    def words(self) -> str:
        """Machine and scenario in words."""
        return Cell(self.machine, self.scenario, "").whole_words.strip()


def judged(frame: pd.DataFrame) -> pd.DataFrame:
    """The rows in which a limit cycle is judged, with `hunts`: whether there is, or may be, one."""
    known = frame.dropna(subset=["limit_cycle"])
    return known.assign(hunts=known["limit_cycle"].isin(HUNTING))


def hunting_places(frame: pd.DataFrame) -> list[HuntingPlace]:
    """By machine and scenario who hunts; none where no reference holds still."""
    places = []
    for (machine, scenario), rows in judged(frame).groupby(["machine", "scenario"], sort=False):
        bad = rows[rows["hunts"]]
        hunters = [_hunter(str(name), group, rows) for name, group in bad.groupby("controller", sort=False)]
        places.append(HuntingPlace(str(machine), str(scenario), len(bad), len(rows), hunters))
    return places


def _hunter(controller: str, bad: pd.DataFrame, rows: pd.DataFrame) -> Hunter:
    own = rows.loc[rows["controller"] == controller, "rpm"]
    speeds = sorted(bad["rpm"].unique())
    return Hunter(
        controller, speeds, sorted(set(own) - set(speeds)), float(pd.to_numeric(bad["limit_cycle_amplitude_m"]).max())
    )
