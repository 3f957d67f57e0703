"""Figures of the search for gains: what each trial reached, and which gains mattered."""

import math
from collections.abc import Mapping, Sequence
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np
import optuna
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances
from optuna.trial import FrozenTrial

from workbench.report.style import COLOURS, figure_style
from workbench.report.tuning_panels import Picture, legend, note, small_multiples
from workbench.tune.gains import history
from workbench.tune.search import is_candidate
from workbench.tune.study import Tuning
from workbench.tune.task import tune_table
from workbench.tune.tuning import Tuned

KINDS: Mapping[str, dict[str, Any]] = {
    "feasible": {"marker": "o", "color": COLOURS[0], "markersize": 4.0},
    "infeasible (breaks a constraint)": {"marker": "x", "color": COLOURS[1], "markersize": 4.0},
    "given up before its last draw": {"marker": "v", "color": COLOURS[3], "markersize": 4.0},
}
FEASIBLE, INFEASIBLE, PRUNED = KINDS
BEST: dict[str, Any] = {"color": "black", "linewidth": 1.2, "drawstyle": "steps-post", "label": "best so far"}

HIGHEST = 1e3
"""Objectives above this many times the smallest are drawn at the top edge, as infinite ones are."""

ROOM = 1.6
"""By what factor the top edge is above the largest objective that is drawn at its own height."""

FEWEST = 12
"""Feasible trials below which the importance of gains is not told."""

BEST_SHARE = 0.25
"""The best quarter of the trials is held against all of them."""


def history_picture(tuning: Tuning) -> Picture:
    """Objective of each trial over its number, a panel a controller."""
    rows = {one.task.name: history(one) for one in tuning.found}
    finite = [row["value"] for own in rows.values() for row in own if math.isfinite(row["value"])]
    low = min(finite, default=0.1)
    drawn = [value for value in finite if value <= HIGHEST * low]
    top = ROOM * max(drawn, default=1.0)
    with figure_style():
        options: dict[str, Any] = {"sharex": True, "sharey": True}
        figure, panels = small_multiples(len(rows), "Objective of every trial", **options)
        for axes, one in zip(panels, tuning.found, strict=True):
            _history(axes, rows[one.task.name], top)
            axes.set_title(one.task.name, fontsize="small")
            axes.set_ylabel("objective")
            axes.set_ylim(low / ROOM, top * 1.15)
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        for axes in panels[-2:]:
            axes.set_xlabel("trial")
        legend(figure, panels, 4)
    table = tune_table(tuning.study)
    caption = (
        "Objective of each trial over its number; lower is better, and 1 is as good as the yardstick. Trial 0 has the "
        "gains of the study. The line is the best trial so far that keeps all constraints."
    )
    if len(drawn) < sum(len(own) for own in rows.values()):
        caption += (
            " Points on the upper edge are runs that failed, whose objective is infinite, or are above it by far."
        )
    if table.draws:
        caption += (
            f" Feasible trials stand at the {table.quantile:g} quantile over the draws, infeasible ones at the "
            "objective on the declared machine; one that was given up at the quantile of the draws until then."
        )
    return Picture(figure, caption)


def kind_of(row: Mapping[str, Any]) -> str:
    """How a trial is drawn."""
    return INFEASIBLE if not row["feasible"] else PRUNED if row["ended"] == "pruned" else FEASIBLE


def _history(axes: Axes, rows: Sequence[Mapping[str, Any]], top: float) -> None:
    axes.set_yscale("log")
    for kind, style in KINDS.items():
        own = [row for row in rows if kind_of(row) == kind]
        if own:
            heights = [min(row["value"], top) for row in own]
            axes.plot([row["trial"] for row in own], heights, linestyle="none", label=kind, **style)
    best = np.minimum.accumulate([row["value"] if row["candidate"] else np.inf for row in rows])
    if np.isfinite(best).any():
        axes.plot([row["trial"] for row in rows], np.where(np.isfinite(best), best, np.nan), **BEST)


def importance_picture(tuning: Tuning) -> Picture | None:
    """Importance of each gain, a panel a controller; None where it can be told of none."""
    found = [importance(one) for one in tuning.found]
    if all(isinstance(each, str) for each in found):
        return None
    with figure_style():
        figure, panels = small_multiples(len(found), "Which gains mattered", 1.5, sharex=True)
        for axes, one, each in zip(panels, tuning.found, found, strict=True):
            axes.set_title(one.task.name, fontsize="small")
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
        "How much each gain tells good trials from the others, as shares of 100 %: PED-ANOVA, which compares where the "
        f"best {BEST_SHARE:.0%} of the feasible trials lie in a gain's range with where all of them lie. It says what "
        "mattered among the gains that were tried, not how far a gain may be moved."
    )
    return Picture(figure, caption)


def importance(one: Tuned) -> dict[str, float] | str:
    """Share of each gain in the importance, or why that is not told."""
    trials = [trial for trial in one.trials if is_candidate(trial) and math.isfinite(trial.value or math.nan)]
    if len(one.task.dimensions) < 2:
        return f"{one.task.dimensions[0].name} is the only gain"
    if len(trials) < FEWEST:
        return f"{len(trials)} feasible trials, {FEWEST} are needed"
    if len({trial.value for trial in trials}) < 2:
        return "all feasible trials are alike"
    return _importance(trials)


def _importance(trials: Sequence[FrozenTrial]) -> dict[str, float]:
    with catch_warnings():
        simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        memory = optuna.create_study()
        memory.add_trials(
            [
                optuna.trial.create_trial(value=trial.value, params=trial.params, distributions=trial.distributions)
                for trial in trials
            ]
        )
        return get_param_importances(memory, evaluator=PedAnovaImportanceEvaluator(target_quantile=BEST_SHARE))
