"""The figure of the importance of gains: which of them told good trials from the others."""

import math
from collections.abc import Sequence
from dataclasses import replace
from warnings import catch_warnings, simplefilter

import optuna
from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances

from workbench.publish.style import COLOURS, figure_style
from workbench.tune.report.panels import Picture, note, small_multiples
from workbench.tune.result import ControllerTuning, Tuning
from workbench.tune.search import as_optuna, distributions_of
from workbench.tune.space import Dimension
from workbench.tune.trials import Trial

FEWEST = 12
"""Feasible trials below which the importance of gains is not told."""

BEST_SHARE = 0.25
"""The best quarter of the trials is held against all of them."""


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


def importance_picture(tuning: Tuning) -> Picture | str:
    """Importance of each gain, a panel a controller; or why it is told of none."""
    shares = [importance(tuned) for tuned in tuning.tuned]
    if all(isinstance(each, str) for each in shares):
        why = "; ".join(f"{tuned.task.label}: {each}" for tuned, each in zip(tuning.tuned, shares, strict=True))
        return f"The importance of gains is not told. {why}."
    with figure_style():
        figure, panels = small_multiples(len(shares), "Which gains mattered", 1.5, sharex="all")
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
