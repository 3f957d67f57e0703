"""Runs of controllers before and after tuning, which figures show: of each case, and of a step that is held."""

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from workbench.publish.along import Shown
from workbench.simulation.simulate import Run, simulate
from workbench.study.resolve import Resolved
from workbench.tune.objective import hold, rests
from workbench.tune.report.panels import note
from workbench.tune.result import ControllerTuning, Tuning
from workbench.tune.schema import ConstraintsTable, tune_table

LOW = 1.5
"""Inches of a panel of these figures."""


@dataclass(frozen=True, eq=False)
class Traced:
    """Runs of a controller before and after tuning: of each case, and of a step that is held."""

    tuned: ControllerTuning
    cases: Mapping[str, Sequence[tuple[Resolved, Run]]]
    held: Mapping[str, tuple[Resolved, Run]]


def traces_of(tuning: Tuning, executor: Executor) -> list[Traced]:
    """Run every controller's cases, and a step, on the declared machine."""
    return [_traced(tuned, executor) for tuned in tuning.tuned]


def _traced(tuned: ControllerTuning, executor: Executor) -> Traced:
    points = {"before": tuned.task.start, **({} if tuned.best is None else {"after": tuned.best})}
    cases = {when: tuned.task.declared(point) for when, point in points.items()}
    held = {when: held_step(own, tune_table(tuned.task.study).constraints) for when, own in cases.items()}
    runs = {when: list(executor.map(lambda case: simulate(case.setup), own)) for when, own in cases.items()}
    return Traced(
        tuned,
        {when: list(zip(own, runs[when], strict=True)) for when, own in cases.items()},
        {when: (case, simulate(case.setup)) for when, case in held.items()},
    )


def held_step(cases: Sequence[Resolved], constraints: ConstraintsTable) -> Resolved:
    """The step on which a limit cycle is judged; where a reference of the study rests, the first such case."""
    resting = [case for case in cases if rests(case)]
    return resting[0] if resting else hold(cases, constraints.model_copy(update={"limit_cycle": True}))[0]


@dataclass(frozen=True, eq=False)
class Trace:
    """A curve over time (s), in SI."""

    time: np.ndarray
    values: np.ndarray


def length_unit(traces: Iterable[Trace], along: Shown) -> tuple[float, str]:
    """What to multiply lengths in SI with to show them in the unit that suits them, and the unit."""
    largest = max((float(np.max(np.abs(trace.values))) for trace in traces if trace.values.size), default=0.0)
    return along.scaled(largest)


def say_failed(axes: Axes) -> None:
    """What stands in a panel without a run."""
    note(axes, "every run failed")
    axes.set_yticks([])
