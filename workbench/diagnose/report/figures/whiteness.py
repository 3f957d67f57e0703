"""Autocorrelation of a residual over the records that were fitted: is what remains noise?"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.diagnose.report.figures.frame import FLOOR, Side, legend, panels_of
from workbench.diagnose.report.figures.residuals import Residuals
from workbench.diagnose.report.series import autocorrelation
from workbench.publish.pictures import Picture
from workbench.publish.style import COLOURS, figure_style
from workbench.records.sampling.sight import window_points


@dataclass(frozen=True, eq=False)
class Autocorrelation:
    """Of one model: autocorrelation over `lags` (s), and what white noise keeps to in 95 %."""

    side: Side
    lags: np.ndarray
    values: np.ndarray
    white: float


@dataclass(frozen=True, eq=False)
class Whiteness:
    """Of each of the balance's residuals the autocorrelations, by the residual's title; the smoothing window (s)."""

    residuals: Residuals
    panels: Sequence[tuple[str, Sequence[Autocorrelation]]]
    window: float


def whiteness_data(residuals: Residuals) -> Whiteness:
    """The numbers of the figure."""
    panels = []
    for number in residuals.numbers:
        own = [part for part in residuals.fitted if part.number == number]
        step = max(part.motion.thinned.sample_time for part in own)
        curves = [
            Autocorrelation(side, *autocorrelation([part.of(side.key) for part in own], step))
            for side in residuals.sides
        ]
        panels.append((residuals.what(number), curves))
    steps = [part.motion.sample_time for part in residuals.fitted]
    return Whiteness(residuals, panels, max(step * window_points(step) for step in steps))


def draw_whiteness(data: Whiteness) -> Picture:
    """The figure."""
    with figure_style():
        title = f"{data.residuals.title}: is what remains noise?"
        figure, grid = panels_of(1, len(data.panels), title, share_y=True)
        for axes, (panel_title, curves) in zip(grid[0], data.panels, strict=True):
            axes.axvspan(0.0, data.window, color=COLOURS[5], alpha=0.2, zorder=0.5, label="smoothing window")
            axes.axhspan(-curves[0].white, curves[0].white, label="white noise, 95 %", **FLOOR)
            for curve in curves:
                axes.plot(curve.lags, curve.values, color=curve.side.colour, label=curve.side.label)
            axes.set_title(panel_title, fontsize="small")
            axes.set_xlabel("lag (s)")
            axes.set_ylabel("autocorrelation")
            axes.set_xlim(0.0, curves[-1].lags[-1])
        legend(figure, grid[0, 0])
    caption = (
        "Autocorrelation of the residual. Noise forgets itself within the window over which all channels are smoothed; "
        "a curve that stays away from zero beyond it is something that is not noise."
    )
    return Picture(figure, caption, data.residuals.balance)
