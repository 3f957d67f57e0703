"""The figure of the search for gains: what each trial reached."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from workbench.publish.style import COLOURS, figure_style, plain_numbers
from workbench.tune.report.panels import Picture, legend, small_multiples
from workbench.tune.result import ControllerTuning, Tuning
from workbench.tune.schema import tune_table
from workbench.tune.trials import Trial

KINDS: Mapping[str, dict[str, Any]] = {
    "feasible": {"marker": "o", "color": COLOURS[0], "markersize": 4.0},
    "infeasible (breaks a constraint)": {"marker": "x", "color": COLOURS[1], "markersize": 4.0},
    "on the declared machine alone": {"marker": "v", "color": COLOURS[3], "markersize": 4.0},
}
FEASIBLE, INFEASIBLE, DECLARED = KINDS
BEST: dict[str, Any] = {"color": "black", "linewidth": 1.2, "drawstyle": "steps-post", "label": "best so far"}

HIGHEST = 10.0
"""Objectives above this many times the largest that a controller has before or after stand at the upper edge."""

BEYOND: dict[str, Any] = {"marker": "^", "markersize": 5.0, "linestyle": "none", "fillstyle": "none"}
"""What stands there."""

ROOM = 1.6
"""By what factor the top edge is above the largest objective that is drawn at its own height."""

NARROW = 50.0
"""An axis that spans less than this factor has plain numbers between the powers of ten."""


@dataclass(frozen=True, eq=False)
class History:
    """The trials of a controller: of each its objective and how it is drawn (of `KINDS`), and the best so far that
    keeps all constraints, infinite before there is one.
    """

    label: str
    values: np.ndarray
    kinds: Sequence[str]
    best: np.ndarray


@dataclass(frozen=True, eq=False)
class Histories:
    """The numbers of the figure: a history a controller, the smallest objective, and the height at which all stand that
    are above it.
    """

    panels: Sequence[History]
    low: float
    top: float


def kind_of(trial: Trial, draws: int) -> str:
    """How a trial is drawn, where the tuning counts on so many draws."""
    if not trial.feasible:
        return INFEASIBLE
    return FEASIBLE if trial.draws == draws else DECLARED


def histories(tuning: Tuning) -> Histories:
    """The numbers of the figure of a tuning."""
    panels = [_history(tuned, tune_table(tuning.study).draws) for tuned in tuning.tuned]
    finite = [float(value) for panel in panels for value in panel.values if math.isfinite(value)]
    reached = [score.nominal for tuned in tuning.tuned for score in (tuned.start, tuned.score) if score is not None]
    largest = max((value for value in reached if math.isfinite(value)), default=math.inf)
    top = ROOM * min(max(finite, default=1.0), HIGHEST * largest)
    return Histories(panels, min(finite, default=0.1 * top), top)


def _history(tuned: ControllerTuning, draws: int) -> History:
    kinds = [kind_of(trial, draws) for trial in tuned.trials]
    values = np.array([trial.value for trial in tuned.trials])
    best = np.minimum.accumulate(np.where(np.array(kinds) == FEASIBLE, values, np.inf))
    return History(tuned.task.label, values, kinds, best)


def history_picture(tuning: Tuning) -> Picture:
    """Objective of each trial over its number, a panel a controller."""
    data = histories(tuning)
    with figure_style():
        figure, panels = small_multiples(len(data.panels), "Objective of every trial", sharex="all", sharey="all")
        for axes, panel in zip(panels, data.panels, strict=True):
            _draw(axes, panel, data.top)
            axes.set_title(panel.label, fontsize="small")
            axes.set_ylabel("objective")
            axes.set_ylim(data.low / ROOM, data.top * ROOM)
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
            if data.top < NARROW * data.low:
                plain_numbers(axes.yaxis)
        for axes in panels[-2:]:
            axes.set_xlabel("trial")
        legend(figure, panels)
    return Picture(figure, _caption(tuning, data))


def _draw(axes: Axes, panel: History, top: float) -> None:
    axes.set_yscale("log")
    numbers, kinds = np.arange(panel.values.size), np.array(panel.kinds)
    for kind, style in KINDS.items():
        within, above = ((kinds == kind) & (panel.values <= top)), ((kinds == kind) & (panel.values > top))
        if within.any():
            axes.plot(numbers[within], panel.values[within], linestyle="none", label=kind, **style)
        if above.any():
            label = f"{kind.partition(' (')[0]}, infinite or beyond the axis"
            heights = np.full(int(above.sum()), top)
            axes.plot(numbers[above], heights, label=label, color=style["color"], **BEYOND)
    if np.isfinite(panel.best).any():
        axes.plot(numbers, np.where(np.isfinite(panel.best), panel.best, np.nan), **BEST)


def _caption(tuning: Tuning, data: Histories) -> str:
    table = tune_table(tuning.study)
    caption = (
        "Objective of each trial over its number, one search after the other; lower is better. The first of each "
        "has the gains of the study. The line is the best trial so far that keeps all constraints."
    )
    if any(np.any(panel.values > data.top) for panel in data.panels):
        caption += (
            " Triangles at the upper edge: no run was made since margins are too small, or one failed, so that the "
            "objective is infinite, or it is beyond the axis."
        )
    if table.draws:
        caption += (
            f" Trials on draws stand at the {table.quantile:g} quantile over them, those before at the objective on "
            "the declared machine."
        )
    return caption
