"""Figures of a diagnosis: its residuals over time and over signals, and whether they are noise; all figures by name."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.diagnose.diagnose import Diagnosis
from workbench.diagnose.report.evidence import AFTER, BEFORE, WIDE, Picture, evidence, legend
from workbench.diagnose.report.names import REJECTED
from workbench.diagnose.report.parameter_figure import parameters_figure
from workbench.diagnose.report.series import (
    SIGNALS,
    Part,
    autocorrelation,
    binned,
    is_changed,
    parts_of,
    scale_of,
    shown_signals,
    unit_of,
)
from workbench.diagnose.report.simulation import simulated_against_measured
from workbench.diagnose.residuals.motion import WINDOW
from workbench.diagnose.selection.selection import BalanceResult
from workbench.publish.style import COLOURS, figure_style

FLOOR: dict[str, Any] = {"color": "#999999", "alpha": 0.35, "linewidth": 0.0, "zorder": 1.0}

MOST_RECORDS = {"fit": 3, "held-out": 2}
"""Of each use that are drawn over time."""

HEIGHT = 2.0
"""Inches of one of many panels."""


def pictures_of(found: Diagnosis) -> dict[str, Picture]:
    """All figures by name."""
    pictures: dict[str, Picture] = {}
    after = "with what was rejected" if found.report["verdict"] == REJECTED else "after, with what was found"
    for result in found.results:
        name, parts = result.balance.name, parts_of(found, result.balance)
        drawn = _Drawn(result, parts, is_changed(parts), after, shown_signals(found, result.balance, parts[0]))
        known = any(np.isfinite(part.after).any() for part in parts if part.use == "fit")
        if known:
            pictures[f"{name}_time"] = over_time(drawn)
            pictures[f"{name}_signals"] = over_signals(drawn)
        if any(step.candidates for step in result.steps):
            pictures[f"{name}_evidence"] = evidence(result)
        if known:
            pictures[f"{name}_whiteness"] = whiteness(drawn)
    if found.simulated is not None:
        pictures["simulation"] = simulated_against_measured(found, found.simulated)
        if any(step.candidates for step in found.simulated.steps):
            pictures["simulation_evidence"] = evidence(found.simulated.result)
    parameters = parameters_figure(found)
    if parameters is not None:
        pictures["parameters"] = parameters
    return pictures


@dataclass(frozen=True, eq=False)
class _Drawn:
    """A balance with its residuals, and what their two sides are called."""

    result: BalanceResult
    parts: Sequence[Part]
    changed: bool
    after: str
    signals: Sequence[str]

    @property
    def floor(self) -> float:
        return scale_of(self.result.balance)

    @property
    def sides(self) -> list[tuple[str, str, str]]:
        """Attribute, label and colour of each curve."""
        if not self.changed:
            return [("after", "declared plant, fitted (nothing was added here)", AFTER)]
        return [("before", "before: declared plant, fitted", BEFORE), ("after", self.after, AFTER)]

    def highest(self, side: str) -> float:
        """What all but rare peaks of a side of the residual stay below."""
        values = np.concatenate([getattr(part, side) for part in self.parts])
        return max(1.3 * float(np.nanquantile(np.abs(values), 0.99)), 2.0 * self.floor)

    @property
    def numbers(self) -> list[int]:
        return sorted({part.number for part in self.parts})

    def what(self, number: int) -> str:
        """What a residual is called: a flow has one of each chamber."""
        name = f"{self.result.balance.name} residual"
        return name if len(self.numbers) == 1 else f"{name}, chamber {number + 1}"

    @property
    def unit(self) -> str:
        return unit_of(self.result.balance)


def _grid(rows: int, columns: int, title: str, **options: Any) -> tuple[Figure, np.ndarray]:
    figure = Figure(figsize=(WIDE, HEIGHT * rows + 0.8))
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def over_time(drawn: _Drawn) -> Picture:
    """Residual over time, a row for each side of each record, a column a residual of the balance."""
    labels = dict.fromkeys((part.use, part.label) for part in drawn.parts)
    shown = [key for use, most in MOST_RECORDS.items() for key in [one for one in labels if one[0] == use][:most]]
    sides = drawn.sides
    with figure_style():
        title = f"{drawn.result.balance.name.capitalize()} balance: what the plant leaves unexplained over time"
        figure, panels = _grid(len(shown) * len(sides), len(drawn.numbers), title)
        for part in drawn.parts:
            if (part.use, part.label) not in shown:
                continue
            for row, (side, label, colour) in enumerate(sides, len(sides) * shown.index((part.use, part.label))):
                axes = panels[row, part.number]
                axes.axhspan(-drawn.floor, drawn.floor, label="noise floor (± 1 std)", **FLOOR)
                axes.plot(part.time, getattr(part, side), color=colour, linewidth=0.7, label=label, rasterized=True)
                word = f", {side}" if drawn.changed else ""
                axes.set_title(f'{drawn.what(part.number)}, {part.use} record "{part.label}"{word}', fontsize="small")
                axes.set_ylim(-drawn.highest(side), drawn.highest(side))
                axes.set_ylabel(f"residual ({drawn.unit})")
                axes.set_xlabel("time (s)")
        legend(figure, *panels[: len(sides), 0])
    left = len(labels) - len(shown)
    caption = (
        f"Residual of the {drawn.result.balance.name} balance in {drawn.unit}. A complete model leaves noise that "
        "keeps to the grey band in two thirds of the time."
        + (" Before and after have scales of their own." if drawn.changed else "")
        + " Gaps: there the balance cannot be told, as something "
        "happened faster than the smoothing follows, or near the ends. Rare peaks (1 %) may go beyond the axis."
        + (f" {left} further record{'s are' if left > 1 else ' is'} not drawn." if left else "")
    )
    return Picture(figure, caption, drawn.result.balance.name)


def over_signals(drawn: _Drawn) -> Picture:
    """Mean and spread of the residual over each signal, on the fit records."""
    parts = [part for part in drawn.parts if part.use == "fit"]
    known = drawn.signals
    several = len(drawn.numbers) > 1
    with figure_style():
        title = f"{drawn.result.balance.name.capitalize()} balance: does the residual depend on a signal?"
        figure, panels = _grid(len(known) if several else (len(known) + 1) // 2, 2, title)
        for axes in panels.flat:
            axes.set_visible(False)
        for row, name in enumerate(known):
            for number in drawn.numbers:
                axes = panels[row, number] if several else panels[row // 2, row % 2]
                axes.set_visible(True)
                own = [part for part in parts if part.number == number]
                _over_signal(axes, drawn, own, name)
                axes.set_ylabel(f"{'chamber ' + str(number + 1) if several else 'residual'} ({drawn.unit})")
        legend(figure, panels[0, 0])
    caption = (
        "Points: mean residual in bins with equally many values, over the fit records; shaded: their standard "
        "deviation. Where the plant is complete the points lie on zero; a curve that remains is what it lacks."
        + (
            " Left out where the contact rests: friction is then whatever holds it."
            if drawn.result.balance.sharp
            else ""
        )
    )
    return Picture(figure, caption, drawn.result.balance.name)


def _over_signal(axes: Axes, drawn: _Drawn, parts: Sequence[Part], name: str) -> None:
    known = [(part.moving, part.signal(name)) for part in parts]
    signals = np.concatenate([np.where(moving, one, np.nan) for moving, one in known if one is not None])
    axes.axhspan(-drawn.floor, drawn.floor, label="noise floor (± 1 std)", **FLOOR)
    for k, (side, label, colour) in enumerate(drawn.sides):
        centre, mean, spread = binned(signals, np.concatenate([getattr(part, side) for part in parts]))
        shade: dict[str, Any] = {"color": colour, "alpha": 0.18, "linewidth": 0.0}
        axes.fill_between(centre, mean - spread, mean + spread, label=f"its spread (± 1 std), {side}", **shade)
        axes.plot(centre, mean, "os"[k], linestyle="-", color=colour, markersize=3.0, linewidth=0.9, label=label)
    axes.set_xlabel(SIGNALS[name].label)


def whiteness(drawn: _Drawn) -> Picture:
    """Autocorrelation of the residual before and after, over the fit records."""
    with figure_style():
        title = f"{drawn.result.balance.name.capitalize()} balance: is what remains noise?"
        figure, panels = _grid(1, len(drawn.numbers), title, sharey=True)
        for number in drawn.numbers:
            axes = panels[0, number]
            own = [part for part in drawn.parts if part.number == number and part.use == "fit"]
            axes.axvspan(0.0, WINDOW, color=COLOURS[5], alpha=0.2, zorder=0.5, label="smoothing window")
            for side, label, colour in drawn.sides:
                lags, values, white = autocorrelation([getattr(part, side) for part in own])
                if side == drawn.sides[0][0]:
                    axes.axhspan(-white, white, label="white noise, 95 %", **FLOOR)
                axes.plot(lags, values, color=colour, label=label)
            axes.set_title(drawn.what(number), fontsize="small")
            axes.set_xlabel("lag (s)")
            axes.set_ylabel("autocorrelation")
            axes.set_xlim(0.0, lags[-1])
        legend(figure, panels[0, 0])
    caption = (
        "Autocorrelation of the residual. Noise forgets itself within the window over which all channels are smoothed; "
        "a curve that stays away from zero beyond it is something that is not noise."
    )
    return Picture(figure, caption, drawn.result.balance.name)
