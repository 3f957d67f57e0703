"""From the sampler's best downhill, by exact derivatives, where the goal has them."""

import math
from collections.abc import Sequence

import numpy as np

from workbench.metrics.window import find_window
from workbench.tune.bench import Bench
from workbench.tune.goal import Score
from workbench.tune.polish import Bound, PolishCase, PolishProblem, polish
from workbench.tune.search import SHORT
from workbench.tune.space import Dimension, Point

SHARES = (1.0, 0.7, 0.4, 0.2, 0.1)
"""Of the way that a descent goes, at which it is looked at: constraints may end it before its end."""


def descended(bench: Bench, best: Point) -> tuple[Point, Score, str]:
    """The best after a descent, where that helps; its score; and what was gained in words."""
    score = bench.judge([best], math.inf)[0]
    reason = _obstacle(bench)
    if reason:
        return best, score, reason
    task, descent = bench.task, polish(_problem(bench, best))
    if descent.value >= descent.start_value:
        return best, score, f"no gain: {descent.reason}"
    end = {one.name: float(getattr(descent.settings, one.name)) for one in task.dimensions}
    points = [_between(task.dimensions, best, end, share) for share in SHARES]
    tried = list(zip(points, bench.judge(points, math.inf), strict=True))
    better = [(point, one) for point, one in tried if one.feasible and one.value < score.value]
    if not better:
        failed = ", ".join(name for name, beyond in tried[0][1].violations.items() if beyond > 0.0)
        why = f"what it leads to does not keep {failed}" if failed else "the simulation does not confirm it"
        return best, score, f"no gain: {why}"
    point, again = min(better, key=lambda one: one[1].value)
    share = 100.0 * (1.0 - again.value / score.value)
    return point, again, f"{share:.2g} % by {descent.gradient_evaluations} evaluations of the gradient"


def _between(dimensions: Sequence[Dimension], start: Point, end: Point, share: float) -> dict[str, float]:
    """The point at a share of the way, on each number's own scale."""
    point = {}
    for one in dimensions:
        a, b = start[one.name], end[one.name]
        value = a * (b / a) ** share if one.logarithmic else a + share * (b - a)
        point[one.name] = min(max(float(f"{value:.{SHORT}g}"), one.low), one.high)
    return point


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
