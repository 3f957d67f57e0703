"""Mean and spread of a residual over each signal, on the records that were fitted."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.diagnose.report.figures.frame import FLOOR, Side, legend, panels_of
from workbench.diagnose.report.figures.residuals import Residuals
from workbench.diagnose.report.series import binned, signals_along
from workbench.publish.pictures import Picture
from workbench.publish.style import figure_style


@dataclass(frozen=True, eq=False)
class BinnedCurve:
    """Of one model: mean signal, and mean and standard deviation of the residual, in bins with equally many values."""

    side: Side
    signal: np.ndarray
    mean: np.ndarray
    spread: np.ndarray


@dataclass(frozen=True, eq=False)
class SignalPanel:
    """One residual over one signal."""

    row: int
    column: int
    signal_label: str
    residual_label: str
    curves: Sequence[BinnedCurve]


@dataclass(frozen=True, eq=False)
class OverSignals:
    """The panels, in two columns and as many `rows` as they need."""

    residuals: Residuals
    rows: int
    panels: Sequence[SignalPanel]


def over_signals_data(residuals: Residuals) -> OverSignals:
    """The numbers of the figure, in the balance's unit: of several residuals each has its column."""
    signals, several = residuals.signals, len(residuals.numbers) > 1
    panels = []
    for place, name in enumerate(signals):
        for number in residuals.numbers:
            row, column = (place, number) if several else divmod(place, 2)
            label = f"chamber {number + 1}" if several else "residual"
            curves = _curves(residuals, number, name)
            panels.append(
                SignalPanel(
                    row,
                    column,
                    signals_along(residuals.parts[0].axis)[name].label,
                    f"{label} ({residuals.unit})",
                    curves,
                )
            )
    return OverSignals(residuals, len(signals) if several else (len(signals) + 1) // 2, panels)


def _curves(residuals: Residuals, number: int, name: str) -> list[BinnedCurve]:
    """Where the contact is known to slide."""
    parts = [part for part in residuals.fitted if part.number == number]
    known = [np.where(part.moving, signal, np.nan) for part in parts if (signal := part.signal(name)) is not None]
    signal = np.concatenate(known)
    return [
        BinnedCurve(side, *binned(signal, np.concatenate([part.of(side.key) for part in parts])))
        for side in residuals.sides
    ]


def draw_over_signals(data: OverSignals) -> Picture:
    """The figure."""
    residuals = data.residuals
    with figure_style():
        title = f"{residuals.title}: does the residual depend on a signal?"
        figure, grid = panels_of(data.rows, 2, title)
        for axes in grid.flat:
            axes.set_visible(False)
        for panel in data.panels:
            axes = grid[panel.row, panel.column]
            axes.set_visible(True)
            axes.axhspan(-residuals.floor, residuals.floor, label="noise floor (± 1 std)", **FLOOR)
            for curve, marker in zip(panel.curves, "os", strict=False):
                low, high, side = curve.mean - curve.spread, curve.mean + curve.spread, curve.side
                shade: dict[str, Any] = {"color": side.colour, "alpha": 0.18, "linewidth": 0.0}
                line: dict[str, Any] = {"color": side.colour, "linestyle": "-", "linewidth": 0.9, "markersize": 3.0}
                which = f", {side.key}" if len(panel.curves) > 1 else ""
                axes.fill_between(curve.signal, low, high, label=f"its spread (± 1 std){which}", **shade)
                axes.plot(curve.signal, curve.mean, marker, label=side.label, **line)
            axes.set_xlabel(panel.signal_label)
            axes.set_ylabel(panel.residual_label)
        legend(figure, grid[0, 0])
    caption = (
        "Points: mean residual in bins with equally many values, over the fit records; shaded: their standard "
        "deviation. Where the plant is complete the points lie on zero; a curve that remains is what it lacks."
        + (" Left out where the contact rests: friction is then whatever holds it." if residuals.contact else "")
    )
    return Picture(figure, caption, residuals.balance)
