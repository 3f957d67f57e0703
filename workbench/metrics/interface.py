"""What a metric is: columns of results.csv, each with its unit and meaning, and how they are found."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from plants.axis import LINEAR, unit_along
from workbench.metrics.window import Window
from workbench.simulation.references import ReferenceSignal
from workbench.simulation.run import Run

if TYPE_CHECKING:
    from workbench.metrics.rest import Rest

Figures = Mapping[str, float | str | None]
"""Figures by column. One that does not apply is None, never 0."""


@dataclass(frozen=True)
class Column:
    """A column of results.csv. Its name ends in its SI unit, as in `jerk_rms_m_per_s3`, unless that is "1"."""

    name: str
    unit: str
    meaning: str

    def along(self, axis: str) -> "Column":
        """The same column of a plant whose positions are in `axis`: on a turning one `rms_error_rad`, in rad."""
        unit = unit_along(self.unit, axis)
        if unit == self.unit:
            return self if axis == LINEAR else replace(self, meaning=self.meaning.replace("mm/s", "mrad/s"))
        return replace(self, name=f"{self.name.removesuffix(ending(self.unit))}{ending(unit)}", unit=unit)


@dataclass(frozen=True)
class Observed:
    """A finished run, the window of it that counts, and what it was asked to do.

    Attributes:
        run: the run, which did not diverge.
        window: t >= transient; where the reference repeats, the last whole number of its periods in there.
        reference: what the position was asked to do; in open loop None.
        transient: time (s) at the start that is left out.
        rests: finds what the run does where its reference rests; takes long.
    """

    run: Run
    window: Window
    reference: ReferenceSignal | None
    transient: float
    rests: Callable[[], "Sequence[Rest]"]


@dataclass(frozen=True, eq=False)
class Metric:
    """Columns of results.csv that are found together: `figures` gives some or all of them; the others stay empty."""

    name: str
    columns: tuple[Column, ...]
    figures: Callable[[Observed], Figures]


def ending(unit: str) -> str:
    """How the name of a column says its unit: "m/s^3" is m_per_s3."""
    return unit.replace("/", "_per_").replace(" ", "_").replace("^", "")
