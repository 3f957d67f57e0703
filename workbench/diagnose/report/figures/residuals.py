"""The residuals of a balance as its figures show them: before and after, in the unit that is shown."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.diagnose.report.figures.frame import Side
from workbench.diagnose.report.series import Part, is_changed, parts_of, scale_of, shown_signals, unit_of
from workbench.diagnose.result import Diagnosis
from workbench.diagnose.selection.selection import BalanceResult
from workbench.publish.along import SHOWN


@dataclass(frozen=True, eq=False)
class Residuals:
    """Every residual of a balance on every record, with its floor in the same `unit`, the models that are drawn, and
    the signals over which they are shown.
    """

    balance: str
    unit: str
    floor: float
    contact: bool
    parts: Sequence[Part]
    sides: Sequence[Side]
    signals: Sequence[str]

    @property
    def title(self) -> str:
        """The balance at the top of a figure."""
        return f"{self.words.capitalize()} balance"

    @property
    def words(self) -> str:
        """What the balance is called."""
        return SHOWN[self.parts[0].axis].said(self.balance)

    @property
    def numbers(self) -> list[int]:
        """Of the balance's residuals: a flow has one of each chamber."""
        return sorted({part.number for part in self.parts})

    @property
    def is_known(self) -> bool:
        """Whether anything is known of it on the records that were fitted."""
        return any(np.isfinite(part.after).any() for part in self.fitted)

    @property
    def fitted(self) -> list[Part]:
        """Those of the records that were fitted."""
        return [part for part in self.parts if part.use == "fit"]

    def what(self, number: int) -> str:
        """What a residual is called."""
        name = f"{self.words} residual"
        return name if len(self.numbers) == 1 else f"{name}, chamber {number + 1}"

    def highest(self, side: Side) -> float:
        """What all but rare peaks of a residual stay below."""
        values = np.concatenate([part.of(side.key) for part in self.parts])
        return max(1.3 * float(np.nanquantile(np.abs(values), 0.99)), 2.0 * self.floor)


def residuals_of(diagnosis: Diagnosis, result: BalanceResult) -> Residuals:
    """The residuals of a balance; one side alone where nothing was found that changes them."""
    balance = result.balance
    parts = parts_of(diagnosis, balance)
    sides = [Side("after", "declared plant, fitted (nothing was added here)")]
    if diagnosis.effects and is_changed(parts):
        after = "with what was rejected" if diagnosis.is_rejected else "after, with what was found"
        sides = [Side("before", "before: declared plant, fitted"), Side("after", after)]
    signals = shown_signals(diagnosis, balance, parts[0])
    return Residuals(balance.name, unit_of(balance), scale_of(balance), balance.contact, parts, sides, signals)
