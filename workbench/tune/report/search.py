"""Figures of the search for gains: what each trial reached, and which gains mattered."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np
import optuna
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances

from workbench.publish.style import COLOURS, figure_style
from workbench.tune.report.panels import Picture, legend, note, small_multiples
from workbench.tune.report.rows import history
from workbench.tune.result import ControllerTuning, Tuning
from workbench.tune.schema import tune_table
from workbench.tune.search import as_optuna, distributions_of
from workbench.tune.space import Dimension
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

FEWEST = 12
"""Feasible trials below which the importance of gains is not told."""

BEST_SHARE = 0.25
"""The best quarter of the trials is held against all of them."""


def history_picture(tuning: Tuning) -> Picture:
    """Objective of each trial over its number, a panel a controller."""
    rows = {tuned.task.label: history(tuned) for tuned in tuning.tuned}
    values = [row["value"] for own in rows.values() for row in own]
    low, top = _edges(tuning, values)
    with figure_style():
        options: dict[str, Any] = {"sharex": True, "sharey": True}
        figure, panels = small_multiples(len(rows), "Objective of every trial", **options)
        for axes, tuned in zip(panels, tuning.tuned, strict=True):
            _history(axes, rows[tuned.task.label], top)
            axes.set_title(tuned.task.label, fontsize="small")
            axes.set_ylabel("objective")
            axes.set_ylim(low / ROOM, top * ROOM)
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
            if top < NARROW * low:
                axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
                axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
                axes.yaxis.set_minor_formatter(NullFormatter())
        for axes in panels[-2:]:
            axes.set_xlabel("trial")
        legend(figure, panels)
    table = tune_table(tuning.study)
    caption = (
        "Objective of each trial over its number, one search after the other; lower is better. The first of each "
        "has the gains of the study. The line is the best trial so far that keeps all constraints."
    )
    if max(values) > top:
        caption += (
            " Triangles at the upper edge: no run was made since margins are too small, or one failed, so that the "
            "objective is infinite, or it is beyond the axis."
        )
    if table.draws:
        caption += (
            f" Trials on draws stand at the {table.quantile:g} quantile over them, those before at the objective on "
            "the declared machine."
        )
    return Picture(figure, caption)


def _edges(tuning: Tuning, values: Sequence[float]) -> tuple[float, float]:
    """The smallest objective, and the height at which all stand that are above it."""
    finite = [value for value in values if math.isfinite(value)]
    reached = [score.nominal for tuned in tuning.tuned for score in (tuned.start, tuned.score) if score is not None]
    largest = max((value for value in reached if math.isfinite(value)), default=math.inf)
    top = ROOM * min(max(finite, default=1.0), HIGHEST * largest)
    return min(finite, default=0.1 * top), top


def kind_of(row: Mapping[str, Any]) -> str:
    """How a trial is drawn."""
    return INFEASIBLE if not row["feasible"] else FEASIBLE if row["candidate"] else DECLARED


def _history(axes: Axes, rows: Sequence[Mapping[str, Any]], top: float) -> None:
    axes.set_yscale("log")
    for kind, style in KINDS.items():
        own = [row for row in rows if kind_of(row) == kind]
        within = [row for row in own if row["value"] <= top]
        if within:
            drawn = [[row[key] for row in within] for key in ("trial", "value")]
            axes.plot(*drawn, linestyle="none", label=kind, **style)
        if len(within) < len(own):
            above = [row["trial"] for row in own if row["value"] > top]
            label = f"{kind.partition(' (')[0]}, infinite or beyond the axis"
            axes.plot(above, [top] * len(above), label=label, color=style["color"], **BEYOND)
    best = np.minimum.accumulate([row["value"] if row["candidate"] else np.inf for row in rows])
    if np.isfinite(best).any():
        axes.plot([row["trial"] for row in rows], np.where(np.isfinite(best), best, np.nan), **BEST)


def importance_picture(tuning: Tuning) -> Picture | str:
    """Importance of each gain, a panel a controller; or why it is told of none."""
    shares = [importance(tuned) for tuned in tuning.tuned]
    if all(isinstance(each, str) for each in shares):
        why = "; ".join(f"{tuned.task.label}: {each}" for tuned, each in zip(tuning.tuned, shares, strict=True))
        return f"The importance of gains is not told. {why}."
    with figure_style():
        figure, panels = small_multiples(len(shares), "Which gains mattered", 1.5, sharex=True)
        for axes, tuned, each in zip(panels, tuning.tuned, shares, strict=True):
            axes.set_title(tuned.task.label, fontsize="small")
            axes.set_xlim(0.0, 100.0)
            axes.grid(axis="y", visible=False)
            if isinstance(each, str):
                axes.set_yticks([])
                note(axes, each)
                continue
            names = sorted(each, key=each.__getitem__)
            axes.barh(names, [100.0 * each[name] for name in names], color=COLOURS[0], height=0.6)
            axes.set_ylim(-0.6, len(names) - 0.4)
        for axes in panels[-2:]:
            axes.set_xlabel("share of the importance (%)")
    caption = (
        "How much each gain tells good trials from the others, as shares of 100 %: PED-ANOVA, which holds where "
        f"the best {100.0 * BEST_SHARE:g} % of the feasible trials lie against where all of them lie. It says what "
        "mattered among the gains that were tried, not how far a gain may be moved."
    )
    return Picture(figure, caption)


def importance(tuned: ControllerTuning) -> dict[str, float] | str:
    """Share of each gain in the importance, or why that is not told."""
    trials = [trial for trial in tuned.trials if not trial.draws and trial.feasible and math.isfinite(trial.nominal)]
    if len(tuned.task.dimensions) < 2:
        return f"{tuned.task.dimensions[0].name} is the only gain"
    if len(trials) < FEWEST:
        return f"{len(trials)} feasible trials, {FEWEST} are needed"
    if len({trial.nominal for trial in trials}) < 2:
        return "all feasible trials are alike"
    return _importance(trials, tuned.task.dimensions)


def _importance(trials: Sequence[Trial], dimensions: Sequence[Dimension]) -> dict[str, float]:
    distributions = distributions_of(dimensions)
    with catch_warnings():
        simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        memory = optuna.create_study()
        memory.add_trials([as_optuna(replace(trial, violations={}), distributions) for trial in trials])
        return get_param_importances(memory, evaluator=PedAnovaImportanceEvaluator(target_quantile=BEST_SHARE))
