"""From the sampler's best downhill, by exact derivatives, where the goal has them."""

import math

import numpy as np

from workbench.metrics.window import find_window
from workbench.tune.bench import Bench
from workbench.tune.goal import Score
from workbench.tune.polish import Bound, PolishCase, PolishProblem, polish
from workbench.tune.search import SHORT
from workbench.tune.space import Point


def descended(bench: Bench, best: Point) -> tuple[Point, Score, str]:
    """The best after a descent, where that helps; its score; and what was gained in words."""
    score = bench.judge([best], math.inf)[0]
    reason = _obstacle(bench)
    if reason:
        return best, score, reason
    descent = polish(_problem(bench, best))
    if descent.value >= descent.start_value:
        return best, score, f"no gain: {descent.reason}"
    task = bench.task
    moved = {one.name: float(f"{getattr(descent.settings, one.name):.{SHORT}g}") for one in task.dimensions}
    again = bench.judge([moved], math.inf)[0]
    if not again.feasible:
        failed = ", ".join(name for name, beyond in again.violations.items() if beyond > 0.0)
        return best, score, f"no gain: what it leads to does not keep {failed}"
    if again.value >= score.value:
        return best, score, "no gain: the simulation does not confirm what it leads to"
    share = 1.0 - again.value / score.value
    return moved, again, f"{100.0 * share:.2g} % in {descent.gradient_evaluations} evaluations of the gradient"


def _obstacle(bench: Bench) -> str:
    """Why there is no descent, "" if there is one."""
    table = bench.goal.table
    if not table.polish:
        return "not asked for"
    if table.draws:
        return "none: a quantile over draws is not smooth"
    if set(bench.goal.columns) != {"rms_error_m"}:
        return "none: only the rms error has a derivative here"
    return "none: the rotation is tuned too" if bench.task.rotates else ""


def _problem(bench: Bench, best: Point) -> PolishProblem:
    """The smooth part of a goal about a point."""
    task, cases = bench.task, bench.task.declared(best)
    units = [one["rms_error_m"] for one in bench.goal.units]
    parts = []
    for case, unit in zip(cases, units, strict=True):
        samples = round(case.setup.duration / case.setup.sample_time) + 1
        window = find_window(case.setup.sample_time * np.arange(samples), case.signal, case.transient)
        if unit is not None and window is not None:
            parts.append(PolishCase(case.setup, window.start, samples - 1, 1.0 / (unit * len(cases))))
    bounds = {one.name: Bound(one.low, one.high, one.logarithmic) for one in task.dimensions}
    return PolishProblem(tuple(parts), task.controller, task.settings_at(best), cases[0].belief, bounds)
