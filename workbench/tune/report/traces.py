"""Figures of runs before and after tuning: a step that is held, and the error over the last period of each case."""

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from workbench.metrics.window import first_sample
from workbench.publish.style import figure_style
from workbench.simulation.simulate import Run, simulate
from workbench.study.resolve import Resolved
from workbench.tune.objective import hold, rests
from workbench.tune.report.panels import SIDES, Picture, grid, legend, note
from workbench.tune.report.rows import case_labels
from workbench.tune.report.tables import plain
from workbench.tune.result import ControllerTuning, Tuning
from workbench.tune.schema import ConstraintsTable, tune_table

SETTLED = 0.1
"""Of a step: what is left of it when the rise is over."""

FINEST = 1e-4
"""Share of a step that the scale of what is left of it has at least: no rounding is magnified."""

SHOWN_RISE = 1.5
"""How much longer than the slowest rise the jump is drawn."""

SHORTEST = 0.02
"""Share of a step's duration that its jump is drawn for at least."""

LATE = 0.5
"""Share of a step's duration after which what is left of it is drawn."""

SPREAD = 10.0
"""An error before tuning that is this many times larger than that after it is cut off."""

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


# --- a step that is held ---


def step_picture(traced: Sequence[Traced]) -> Picture:
    """Position at the jump, and the error that is left of it, a row a controller."""
    with figure_style():
        figure, panels = grid(len(traced), 2, "A step that is held, before and after", LOW, sharex="col")
        level = _jump(next(iter(traced[0].held.values()))[1])
        rise = max((_rise(run) for each in traced for run in _finished(each).values()), default=1.0)
        for (jump, left), each in zip(panels, traced, strict=True):
            _step(jump, left, each, level)
            jump.set_xlim(0.0, rise)
        panels[-1, 0].set_xlabel("time from the step (s)")
        panels[-1, 1].set_xlabel("time from the step (s)")
        legend(figure, list(panels.ravel()))
    caption = (
        f"A step of {1e3 * level:.3g} mm, held. Left: position, until the slowest controller has come near. Right: the "
        "error in the second half of the hold, each on a scale of its own: a level line is a steady-state error, a "
        f"wave that does not die out a limit cycle. Scales are not finer than {100.0 * FINEST:g} % of the step."
    )
    return Picture(figure, caption)


def _say_failed(axes: Axes) -> None:
    note(axes, "every run failed")
    axes.set_yticks([])


def _finished(each: Traced) -> dict[str, Run]:
    """Runs of the step that did not diverge."""
    return {when: run for when, (_, run) in each.held.items() if not run.diverged}


def _step(jump: Axes, left: Axes, each: Traced, level: float) -> None:
    runs = _finished(each)
    late = {when: _late(run) for when, run in runs.items()}
    scale, unit = _length(error for _, error in late.values())
    for when, run in runs.items():
        time, error = _error(run)
        jump.plot(time, 1e3 * (level - error), **SIDES[when])
        left.plot(late[when][0], scale * late[when][1], **SIDES[when])
    if runs:
        jump.axhline(1e3 * level, color="#666666", linewidth=0.8, label="reference")
        left.axhline(0.0, color="#666666", linewidth=0.8)
        finest = scale * FINEST * abs(level)
        low, high = left.get_ylim()
        left.set_ylim(min(low, -finest), max(high, finest))
    jump.xaxis.set_major_locator(MaxNLocator(5))
    for axes, what in ((jump, "position"), (left, "error, second half")):
        axes.set_title(f"{each.tuned.task.label}: {what}", fontsize="small")
        if not runs:
            _say_failed(axes)
    jump.set_ylabel("position (mm)")
    left.set_ylabel(f"error ({unit})")


def largest_jump(run: Run) -> tuple[float, slice]:
    """The largest jump of a reference (m), that from where the rod starts among them, and its samples."""
    assert run.reference is not None
    asked = run.reference[0]
    edges = np.concatenate([[0], np.flatnonzero(np.diff(asked)) + 1, [asked.size]])
    before = np.concatenate([[run.state("position")[0]], asked[edges[1:-1] - 1]])
    jumps = asked[edges[:-1]] - before
    i = int(np.argmax(np.abs(jumps)))
    return float(jumps[i]), slice(int(edges[i]), int(edges[i + 1]))


def _jump(run: Run) -> float:
    return largest_jump(run)[0]


def _error(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Time from the largest jump (s) and true error (m) until the next."""
    _, samples = largest_jump(run)
    time = run.time[samples]
    return time - time[0], run.signals["error"][samples]


def _late(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Time and error (m) over the second half of the dwell."""
    time, error = _error(run)
    start = first_sample(time, LATE * float(time[-1])) if time.size > 1 else 0
    return time[start:], error[start:]


def _rise(run: Run) -> float:
    """For how long (s) the jump of a run is drawn."""
    time, error = _error(run)
    late = np.flatnonzero(np.abs(error) > SETTLED * abs(_jump(run)))
    until = float(time[late[-1]]) if late.size else 0.0
    return min(max(SHOWN_RISE * until, SHORTEST * float(time[-1])), LATE * float(time[-1]))


# --- the error of each case ---


def error_picture(traced: Sequence[Traced]) -> Picture:
    """Error over the last period of each case, a row a controller, a column a case."""
    labels = case_labels(traced[0].tuned.task.cases)
    with figure_style():
        figure, panels = grid(len(traced), len(labels), "Tracking error over the last period", LOW, sharex="col")
        cut = [
            _errors_drawn(panels[row, column], each, column, label)
            for row, each in enumerate(traced)
            for column, label in enumerate(labels)
        ]
        for axes in panels[-1]:
            axes.set_xlabel("time (s)")
        legend(figure, list(panels.ravel()))
    caption = (
        "Reference less true position over the last period of each case, on the declared machine. Each panel has a "
        "scale of its own: it shows where in a period the error arises; the table says which controller has the least."
        + (f" Errors before tuning above {SPREAD:g} times those after it are cut off." if any(cut) else "")
    )
    return Picture(figure, caption)


def _errors_drawn(axes: Axes, each: Traced, number: int, label: str) -> bool:
    """Draw the error of one case; returns whether that before tuning is cut off."""
    own = _errors(each, number)
    peaks = {when: float(np.max(np.abs(error))) for when, (_, error) in own.items()}
    scale, unit = _length(error for _, error in own.values())
    for when, (time, error) in own.items():
        axes.plot(time, scale * error, **SIDES[when])
    axes.set_title(", ".join(part for part in (each.tuned.task.label, plain(label)) if part), fontsize="small")
    axes.set_ylabel(f"error ({unit})")
    if not own:
        _say_failed(axes)
    cut = len(peaks) == len(SIDES) and peaks["before"] > SPREAD * peaks["after"] > 0.0
    if cut:
        limit = scale * SPREAD * peaks["after"]
        axes.set_ylim(-limit, limit)
    return cut


def _errors(each: Traced, number: int) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Time from its beginning (s) and error (m) over the last period of a case, of runs that did not diverge."""
    errors = {}
    for when, runs in each.cases.items():
        case, run = runs[number]
        if run.diverged or run.reference is None:
            continue
        period = case.signal.period if case.signal is not None else None
        begin = case.transient if period is None else max(float(run.time[-1]) - period, 0.0)
        start = first_sample(run.time, begin)
        errors[when] = (run.time[start:], run.signals["error"][start:])
    return errors


def _length(errors: Iterable[np.ndarray]) -> tuple[float, str]:
    """What to multiply lengths in m with to show them in the unit that suits them, and the unit."""
    largest = max((float(np.max(np.abs(error))) for error in errors if error.size), default=0.0)
    return (1e3, "mm") if largest >= 1e-4 else (1e6, "µm")
